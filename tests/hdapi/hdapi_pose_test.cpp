// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/hdapi_pose.h"

#include <array>
#include <limits>

#include "tests/support/catch.h"

namespace rig {

// Catches rows taken for columns, and centimetres or metres taken for millimetres.
TEST_CASE("hdapi pose: columns, and metres of millimetres", "[unit]") {
  // a quarter turn about z: x to y, y to -x
  const std::array<double, 16> transform = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, -20, 30, 1};
  const auto pose = pose_of(transform);
  REQUIRE(pose.has_value());
  CHECK(pose->translation().isApprox(Eigen::Vector3f(0.01f, -0.02f, 0.03f)));
  CHECK((pose->linear() * Eigen::Vector3f::UnitX()).isApprox(Eigen::Vector3f::UnitY()));
  CHECK((pose->linear() * Eigen::Vector3f::UnitY()).isApprox(-Eigen::Vector3f::UnitX()));
}

// Catches axes that are handed on as they come: a tool would shrink and shear.
TEST_CASE("hdapi pose: axes of a few digits become a rotation", "[unit]") {
  const std::array<double, 16> transform = {1.01, 0.01, 0, 0, 0.012, 0.99, 0.01, 0,
                                            0.01, 0,    1, 0, 0,     0,    0,    1};
  const auto pose = pose_of(transform);
  REQUIRE(pose.has_value());
  CHECK((pose->linear().transpose() * pose->linear()).isIdentity(1e-6f));
  CHECK(pose->linear().determinant() > 0);
  CHECK(pose->linear().isIdentity(0.03f));
}

// Catches a reading that would throw a tool out of the scene.
TEST_CASE("hdapi pose: what is no pose is refused", "[unit]") {
  const std::array<double, 16> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  REQUIRE(pose_of(identity).has_value());
  for (const std::size_t element : {0u, 5u, 10u, 12u, 14u}) {
    std::array<double, 16> broken = identity;
    broken[element] = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(pose_of(broken).has_value());
  }
  std::array<double, 16> mirror = identity;
  mirror[0] = -1;
  CHECK_FALSE(pose_of(mirror).has_value());
  CHECK_FALSE(pose_of(std::array<double, 16>{}).has_value());
}

}  // namespace rig
