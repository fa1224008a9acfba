// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/strain_limit.h"

#include <limits>

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

template <ProjectionMode kMode, class Scalar>
void project(Vec3<Scalar> (&x)[2], const Scalar (&w)[2], Scalar limit) {
  const Scalar parameters[] = {limit};
  Scalar multiplier[] = {0};
  StrainLimitConstraint::project<kMode>(x, w, parameters, Substep<Scalar>{1, 1}, multiplier);
}

}  // namespace

TEST_CASE("strain limit: too long is shortened to the limit, and no more, at any scale",
          "[property]") {
  const double edge = GENERATE(1.0, 1e-2, 1e-4);
  Vec3<double> x[2] = {{0, 0, 0}, {0, 3 * edge, 4 * edge}};
  project<ProjectionMode::compliance>(x, {1.0, 3.0}, 4 * edge);

  // the lighter vertex goes three quarters of the way, and momentum is kept
  CHECK(x[0].y == Approx(0.25 * 0.6 * edge));
  CHECK(x[1].z == Approx(4 * edge - 0.75 * 0.8 * edge));
  CHECK(x[0].x == 0);
}

TEST_CASE("strain limit: shorter edges are left alone, in both modes", "[unit]") {
  Vec3<float> x[2] = {{0, 0, 0}, {1e-3F, 0, 0}};
  project<ProjectionMode::compliance>(x, {1.0F, 1.0F}, 1.1e-3F);
  project<ProjectionMode::fraction>(x, {1.0F, 1.0F}, 1.1e-3F);
  CHECK(x[0].x == 0);
  CHECK(x[1].x == 1e-3F);

  project<ProjectionMode::fraction>(x, {0.0F, 1.0F}, 0.5e-3F);
  CHECK(x[0].x == 0);
  CHECK(x[1].x == Approx(0.5e-3));
}

TEST_CASE("strain limit: what is fixed or not finite moves nothing", "[unit]") {
  Vec3<float> fixed[2] = {{0, 0, 0}, {1, 0, 0}};
  project<ProjectionMode::compliance>(fixed, {0.0F, 0.0F}, 0.5F);
  CHECK(fixed[1].x == 1);

  const float bad =
      GENERATE(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity());
  Vec3<float> broken[2] = {{0, 0, 0}, {0, bad, 0}};
  project<ProjectionMode::compliance>(broken, {1.0F, 1.0F}, 0.5F);
  CHECK(broken[0].x == 0);
  CHECK(broken[0].y == 0);
}

}  // namespace pbdsurg
