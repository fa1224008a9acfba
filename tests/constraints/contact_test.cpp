// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/contact.h"

#include "tests/support/catch.h"

namespace pbdsurg {

TEST_CASE("contact constraint: pushes out, never pulls, takes back what it overdid", "[unit]") {
  const Vec3<double> normal{0, 1, 0};
  double multiplier = 0;

  Vec3<double> outside{0, 2, 0};
  ContactConstraint::project(outside, 1.0, normal, 1.0, multiplier);
  CHECK(outside.y == 2);
  CHECK(multiplier == 0);

  Vec3<double> x{5, 0.25, 5};
  ContactConstraint::project(x, 2.0, normal, 1.0, multiplier);
  CHECK(x.y == testing::Approx(1));
  CHECK(x.x == 5);
  CHECK(multiplier == testing::Approx(0.375));

  // something else lifts the vertex by 0.5: the contact gives back that much, no more
  x.y += 0.5;
  ContactConstraint::project(x, 2.0, normal, 1.0, multiplier);
  CHECK(x.y == testing::Approx(1));
  x.y += 5;
  ContactConstraint::project(x, 2.0, normal, 1.0, multiplier);
  CHECK(multiplier == 0);
  CHECK(x.y > 1);
}

}  // namespace pbdsurg
