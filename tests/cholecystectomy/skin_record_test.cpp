// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/skin_record.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "pbdsurg/base/random.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/world/world.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::Triangle;
using pbdsurg::World;
using pbdsurg::testing::Approx;

constexpr double kEdge = 4e-3;  // m
constexpr std::array<Index, 3> kCells{10, 4, 3};

/// A bar along x from 0 to 40 mm, whose skin is followed.
struct Bar {
  explicit Bar(double jitter = 0.1)
      : body(add_bar(world, jitter)),
        surface(world.surface(body)),
        skin(world.tissue(), skin_now()) {}

  static pbdsurg::BodyId add_bar(World& world, double jitter) {
    world.set_gravity(Eigen::Vector3f::Zero());
    return world.add_body("bar", pbdsurg::testing::make_box(kCells, kEdge, jitter),
                          pbdsurg::tissues::liver());
  }

  [[nodiscard]] Triangle scene_triangle(const Triangle& t) const {
    return {surface.vertices()[t[0]], surface.vertices()[t[1]], surface.vertices()[t[2]]};
  }
  [[nodiscard]] std::vector<Triangle> skin_now() const {
    std::vector<Triangle> all;
    for (const Triangle& triangle : surface.triangles()) {
      all.push_back(scene_triangle(triangle));
    }
    return all;
  }

  /// m^2 at rest, of skin and of what is bared.
  [[nodiscard]] std::array<double, 2> areas() const {
    std::array<double, 2> sums{};
    for (const Triangle& triangle : surface.triangles()) {
      const auto at = [&](int i) -> Eigen::Vector3d {
        return surface.rest_positions()[triangle[i]].cast<double>();
      };
      if (triangle[0] != triangle[1]) {
        sums[skin.has(scene_triangle(triangle)) ? 0 : 1] +=
            (at(1) - at(0)).cross(at(2) - at(0)).norm() / 2;
      }
    }
    return sums;
  }

  void edit(const pbdsurg::TopologyEdit& wanted) {
    world.edit(wanted);
    world.step(1e-3);
  }

  /// By a blade that comes down along z, from the first x at its one end to the second at the
  /// other.
  void cut(float first_x, float second_x, float depth = 0.05F,
           pbdsurg::CutStyle style = pbdsurg::CutStyle::through_tets) {
    const auto blade = [&](float z) {
      return pbdsurg::BladeEdge{{first_x, -0.01F, z}, {second_x, 0.03F, z}};
    };
    edit(plan_cut(world.solver(),
                  pbdsurg::sweep_blade(std::array{blade(0.03F), blade(0.03F - depth)}),
                  {.style = style})
             .edit);
  }

  World world;
  pbdsurg::BodyId body;
  const pbdsurg::Surface& surface;
  SkinRecord skin;
};

}  // namespace

// Would catch pieces of cut triangles that are taken for the inside, and faces of the cut that are
// taken for skin.
TEST_CASE("skin record: a cut through tetrahedra leaves all skin and bares its two faces",
          "[unit]") {
  Bar bar(0);
  const auto [skin, bared] = bar.areas();
  const double section = kCells[1] * kCells[2] * kEdge * kEdge;
  REQUIRE(bared == 0);
  REQUIRE(skin == Approx(2 * section + 2 * kCells[0] * (kCells[1] + kCells[2]) * kEdge * kEdge));
  const Index vertices = bar.world.tissue().vertex_count();
  bar.cut(0.018F, 0.018F);
  REQUIRE(bar.world.tissue().vertex_count() > vertices);
  CHECK(bar.areas()[0] == Approx(skin).epsilon(1e-5));
  CHECK(bar.areas()[1] == Approx(2 * section).epsilon(1e-5));
  for (const Triangle& triangle : bar.surface.triangles()) {
    if (triangle[0] != triangle[1] && !bar.skin.has(bar.scene_triangle(triangle))) {
      for (const Index corner : triangle) {
        CHECK(bar.surface.rest_positions()[corner].x() == Approx(0.018).epsilon(1e-5));
      }
    }
  }
}

// Would catch what only holds for the first cut, a flat skin or whole tetrahedra.
TEST_CASE("skin record: cuts across cuts, of either style, leave all skin", "[property]") {
  Bar bar;
  const double skin = bar.areas()[0];
  for (std::uint64_t i = 0; i < 12; ++i) {
    const auto random = [&](int which) {
      return static_cast<float>(pbdsurg::random_unit(7, i, which));
    };
    const double bared = bar.areas()[1];
    bar.cut(0.04F * random(0), 0.04F * random(1), 0.01F + 0.03F * random(2),
            i % 4 == 3 ? pbdsurg::CutStyle::along_faces : pbdsurg::CutStyle::through_tets);
    CHECK(bar.areas()[0] == Approx(skin).epsilon(1e-5));
    CHECK(bar.areas()[1] >= bared - 1e-9);
  }
  CHECK(bar.areas()[1] > 0.5 * skin);
}

// Would catch vertices that an undo or a compaction mixes up.
TEST_CASE("skin record: it goes along with removal, undo and compaction", "[unit]") {
  Bar bar;
  const auto [skin, none] = bar.areas();
  bar.cut(0.01F, 0.014F);
  const std::array<double, 2> cut = bar.areas();
  bar.cut(0.022F, 0.026F);
  REQUIRE(bar.areas()[1] > cut[1]);
  bar.world.undo();
  CHECK(bar.areas() == cut);
  bar.cut(0.03F, 0.026F);
  const std::array<double, 2> twice = bar.areas();
  CHECK(twice[0] == Approx(skin).epsilon(1e-5));

  pbdsurg::TopologyEdit removal;  // of all that has the first vertex
  for (const Index tet : bar.world.tissue().tets_at(0)) {
    removal.remove_tets.push_back(tet);
  }
  bar.edit(removal);
  const std::array<double, 2> burnt = bar.areas();
  CHECK(burnt[0] < twice[0] - 1e-6);
  CHECK(burnt[1] > twice[1]);
  bar.world.compact();
  CHECK(bar.areas()[0] == Approx(burnt[0]).epsilon(1e-6));
  CHECK(bar.areas()[1] == Approx(burnt[1]).epsilon(1e-6));
  bar.cut(0.018F, 0.02F);
  CHECK(bar.areas()[0] == Approx(burnt[0]).epsilon(1e-5));
  CHECK(bar.areas()[1] > burnt[1]);
  CHECK(none == 0);
}

}  // namespace cholecystectomy
