// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/attachment.h"

#include "tests/support/catch.h"

namespace pbdsurg {

TEST_CASE("attachment constraint: rigid reaches its target, soft balances its multiplier",
          "[unit]") {
  const Vec3<double> target{1e-3, -2e-3, 3e-3};
  const double w = 1e6;

  Vec3<double> rigid{0, 0, 0}, multiplier{};
  AttachmentConstraint::project<ProjectionMode::compliance>(rigid, w, target, 0.0, multiplier);
  CHECK(rigid.z == testing::Approx(target.z));

  Vec3<double> soft{0, 0, 0};
  const double softness = 2e6;  // twice the inverse mass: a third of the way
  multiplier = {};
  AttachmentConstraint::project<ProjectionMode::compliance>(soft, w, target, softness, multiplier);
  CHECK(soft.x == testing::Approx(target.x / 3));
  CHECK(soft.y - target.y == testing::Approx(-softness * multiplier.y));
}

}  // namespace pbdsurg
