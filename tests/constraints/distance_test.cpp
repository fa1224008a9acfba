// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/distance.h"

#include "tests/support/constraint_checks.h"

namespace pbdsurg {
namespace {

constexpr Substep<float> kSubstep{1, 1};

}  // namespace

TEST_CASE("distance constraint: gradient, scale, momentum, frame and compliance", "[property]") {
  testing::check_all<DistanceConstraint>();
}

TEST_CASE("distance constraint: the fraction is what one projection removes", "[unit]") {
  Vec3<float> x[2] = {{0, 0, 0}, {3e-3F, 0, 0}};
  const float w[2] = {1e6F, 3e6F};
  const float parameters[] = {2e-3F, 0.4F, 0};
  float multiplier[] = {0};

  DistanceConstraint::project<ProjectionMode::fraction>(x, w, parameters, kSubstep, multiplier);

  // 0.4 mm of the 1 mm excess, a quarter of it from the heavier vertex
  CHECK(x[0].x == testing::Approx(0.1e-3));
  CHECK(x[1].x == testing::Approx(2.7e-3));
}

TEST_CASE("distance constraint: no direction and no mobility mean no move", "[unit]") {
  Vec3<float> same[2] = {{1, 1, 1}, {1, 1, 1}};
  Vec3<float> apart[2] = {{0, 0, 0}, {1, 0, 0}};
  const float free[2] = {1, 1};
  const float fixed[2] = {0, 0};
  const float parameters[] = {0.5F, 1, 0};
  float multiplier[] = {0};

  DistanceConstraint::project<ProjectionMode::fraction>(same, free, parameters, kSubstep,
                                                        multiplier);
  DistanceConstraint::project<ProjectionMode::fraction>(apart, fixed, parameters, kSubstep,
                                                        multiplier);

  CHECK(same[0].x == 1);
  CHECK(apart[1].x == 1);
  CHECK(multiplier[0] == 0);
}

}  // namespace pbdsurg
