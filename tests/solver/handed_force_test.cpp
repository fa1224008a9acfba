// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/handed_force.h"

#include <array>

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

SurfaceContact make_new(const ContactFeature& feature, const Vec3<float>& normal) {
  SurfaceContact contact;
  contact.feature = feature;
  contact.normal = normal;
  contact.takes_over = true;
  return contact;
}

}  // namespace

// Would catch a force that goes to a contact elsewhere, to one on the other side of a thin tool, or
// to one that has its own.
TEST_CASE("handed force: the new contact beside it takes over", "[unit]") {
  const RememberedContact gone{{{3, 7, kInvalidIndex}}, {0, 0, 1}, 1, {}};
  const SurfaceContact beside = make_new({{3, 7, 9}}, {0, 0.6F, 0.8F});
  SurfaceContact known = make_new({{3, 8, 9}}, {0, 0, 1});
  known.takes_over = false;
  const std::array contacts{
      make_new({{1, 2, kInvalidIndex}}, {0, 0, 1}),              // shares no corner
      known,                                                     // has its own
      make_new({{3, kInvalidIndex, kInvalidIndex}}, {0, 1, 0}),  // across
      make_new({{3, 6, kInvalidIndex}}, {0, 0, -1}),             // on the other side
      beside,
      make_new({{7, 9, kInvalidIndex}}, {0, 0.8F, 0.6F}),  // farther from its direction
      beside                                               // equal, later
  };
  HandedForce handed;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    handed.consider(gone, contacts[c], static_cast<Index>(c));
  }
  CHECK(handed.taker == 4);
  CHECK(handed.share == Approx(0.8F));
}

// Would catch plates at rest, under which contacts come and go without end.
TEST_CASE("handed force: new contacts of rods take over, of plates those that move", "[unit]") {
  const PlacedCapsule rod{{0, 0, 0}, 1e-3F, {1e-2F, 0, 0}};
  const PlacedCapsule plate{{0, 0, 0}, 1e-3F, {1e-2F, 0, 0}, {0, 1e-2F, 0}};
  const auto moved = [](const PlacedCapsule& capsule, float way) {
    return SweptCapsule{capsule, capsule.moved({0, 0, way})};
  };
  CHECK(may_take_over(false, moved(rod, 0)));
  CHECK_FALSE(may_take_over(true, moved(rod, 0)));
  CHECK_FALSE(may_take_over(false, moved(plate, 0)));
  CHECK(may_take_over(false, moved(plate, 1e-4F)));
}

TEST_CASE("handed force: places behind a feature's corners are none", "[unit]") {
  CHECK_FALSE(
      share_corner({{1, kInvalidIndex, kInvalidIndex}}, {{2, kInvalidIndex, kInvalidIndex}}));
  CHECK(share_corner({{1, 5, kInvalidIndex}}, {{2, 5, 8}}));
}

}  // namespace pbdsurg
