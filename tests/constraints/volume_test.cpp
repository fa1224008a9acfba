// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/volume.h"

#include "tests/support/constraint_checks.h"

namespace pbdsurg {

TEST_CASE("volume constraint: gradient, scale, momentum, frame and compliance", "[property]") {
  testing::check_all<VolumeConstraint>();
}

TEST_CASE("volume constraint: an inverted tetrahedron is turned back", "[unit]") {
  Vec3<double> x[4] = {{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, {2e-4, 2e-4, -1e-4}};
  const double w[4] = {1, 1, 1, 1};
  const double rest = 1e-9 / 6;
  const double parameters[] = {rest, 1, 0};
  double multiplier[] = {0};

  for (int i = 0; i < 30; ++i) {
    VolumeConstraint::project<ProjectionMode::fraction>(x, w, parameters, Substep<double>{1, 1},
                                                        multiplier);
  }

  CHECK(VolumeConstraint::value(x, rest) == testing::Approx(0).margin(1e-3 * rest));
}

// The solver gives corners from the first, whose own motion then does not show.
TEST_CASE("volume constraint: friction does not depend on the origin", "[unit]") {
  const Vec3<double> start[4] = {{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, {2e-4, 2e-4, 1e-3}};
  const Vec3<double> moved[4] = {
      {1e-5, 2e-5, 3e-5}, {1e-3, 1e-5, 0}, {0, 1e-3, 4e-5}, {2e-4, 3e-4, 1e-3}};
  const double w[4] = {1, 2, 3, 4};
  const double parameters[] = {2e-10, 1e-9, 0.01};
  const auto change = [&](bool from_first) {
    Vec3<double> x[4];
    Damped<double, 4> damping;
    for (int k = 0; k < 4; ++k) {
      x[k] = from_first ? moved[k] - moved[0] : moved[k];
      damping.start[k] = from_first ? start[k] - start[0] : start[k];
    }
    double multiplier[] = {0};
    static_cast<void>(VolumeConstraint::move<ProjectionMode::compliance>(
        x, w, parameters, Substep<double>{100, 1e4}, multiplier, damping));
    return multiplier[0];
  };

  CHECK(change(true) != 0);
  CHECK(change(false) == testing::Approx(change(true)).epsilon(1e-9));
}

TEST_CASE("volume constraint: four vertices at one point stay finite", "[unit]") {
  Vec3<float> x[4] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
  const float w[4] = {1, 1, 1, 1};
  const float parameters[] = {1, 0, 0};
  float multiplier[] = {0};

  VolumeConstraint::project<ProjectionMode::compliance>(x, w, parameters, Substep<float>{1, 1},
                                                        multiplier);

  CHECK(x[0].x == 1);
  CHECK(multiplier[0] == 0);
}

}  // namespace pbdsurg
