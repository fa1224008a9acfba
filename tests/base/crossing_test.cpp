// SPDX-License-Identifier: Apache-2.0
#include "lib/base/crossing.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

// Four corners at the start and at the end.
struct Ways {
  std::array<Vector3d, 4> start, end;

  [[nodiscard]] CornerWay way(int k) const {
    return {Vec3<double>{start[k].x(), start[k].y(), start[k].z()},
            Vec3<double>{end[k].x(), end[k].y(), end[k].z()}};
  }
  [[nodiscard]] std::array<Vector3d, 4> at(double share) const {
    std::array<Vector3d, 4> x;
    for (std::size_t k = 0; k < 4; ++k) {
      x[k] = start[k] + share * (end[k] - start[k]);
    }
    return x;
  }
};

// In a cube; ways up to as long as its sides.
Ways random_ways(std::uint64_t seed) {
  Ways ways;
  for (std::uint64_t k = 0; k < 4; ++k) {
    for (std::uint64_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      ways.start[k][a] = random_unit(seed, k, axis);
      ways.end[k][a] = ways.start[k][a] + 2 * random_unit(seed, k, axis + 3) - 1;
    }
  }
  return ways;
}

// What a look at many moments says.
struct Looks {
  bool crosses = false;
  double margin = 1;  // least way of any crossing, or near one, from being none
};

// @param shares_of  (corners) -> shares along both segments, or in the triangle, all of which are
//                   positive where they meet
template <class SharesOf>
Looks look(const Ways& ways, const SharesOf& shares_of) {
  constexpr int kLooks = 4000;
  Looks looks;
  const auto volume = [](const std::array<Vector3d, 4>& x) {
    return (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]));
  };
  double before = volume(ways.at(0));
  for (int i = 1; i <= kLooks; ++i) {
    const auto x = ways.at(static_cast<double>(i) / kLooks);
    const double now = volume(x);
    if ((before > 0) != (now > 0)) {
      const double least = shares_of(x).minCoeff();
      looks.crosses |= least > 0;
      looks.margin = std::min(looks.margin, std::abs(least));
    }
    before = now;
  }
  return looks;
}

// Shares of two segments in a plane, and what is left of each.
Eigen::Vector4d shares_of_segments(const std::array<Vector3d, 4>& x) {
  Eigen::Matrix<double, 3, 2> sides;
  sides << x[1] - x[0], x[2] - x[3];
  const Eigen::Vector2d s = sides.colPivHouseholderQr().solve(x[2] - x[0]);
  return {s[0], 1 - s[0], s[1], 1 - s[1]};
}

// Shares of the corners 1 to 3 at corner 0.
Eigen::Vector3d shares_in_triangle(const std::array<Vector3d, 4>& x) {
  Eigen::Matrix<double, 3, 2> sides;
  sides << x[2] - x[1], x[3] - x[1];
  const Eigen::Vector2d s = sides.colPivHouseholderQr().solve(x[0] - x[1]);
  return {1 - s.sum(), s[0], s[1]};
}

// @param shares_of  as of look()
// @param crosses    (ways) -> bool, what is to say the same
template <class SharesOf, class Crosses>
void check_against_looks(const SharesOf& shares_of, const Crosses& crosses) {
  constexpr double kUnsure = 1e-2;
  int crossings = 0, sure = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    CAPTURE(seed);
    const Ways ways = random_ways(seed);
    const Looks looks = look(ways, shares_of);
    if (looks.margin > kUnsure) {
      const bool found = crosses(ways);
      CHECK(found == looks.crosses);
      ++sure;
      crossings += found ? 1 : 0;
    }
  }
  CHECK(sure > 1500);
  CHECK(crossings > 50);
}

}  // namespace

// Would catch a root of the cubic that is passed over or found where there is none, and segments
// that meet beyond their ends. Ways that come within a hundredth of such an end may be seen either
// way by the looks.
TEST_CASE("crossing: segments that come through each other are seen", "[property]") {
  check_against_looks(shares_of_segments, [](const Ways& ways) {
    return segments_cross(ways.way(0), ways.way(1), ways.way(2), ways.way(3));
  });
}

TEST_CASE("crossing: a point that comes through a triangle is seen", "[property]") {
  check_against_looks(shares_in_triangle, [](const Ways& ways) {
    return point_crosses(ways.way(0), ways.way(1), ways.way(2), ways.way(3));
  });
}

// Would catch a crossing exactly at the corner that two edges share, which neither of them sees.
TEST_CASE("crossing: no gap is between two edges at their corner", "[unit]") {
  const auto still = [](const Vec3<double>& x) { return CornerWay{x, x}; };
  for (double offset = -1e-6; offset < 1e-6; offset += 1.3e-7) {
    CAPTURE(offset);
    const CornerWay from{Vec3<double>{offset, -1, 1}, Vec3<double>{offset, -1, -1}},
        to{Vec3<double>{offset, 1, 1}, Vec3<double>{offset, 1, -1}};
    const CornerWay left = still({-1, 0.5, 0}), middle = still({0, 0, 0}), right = still({1, 0, 0});
    CHECK((segments_cross(from, to, left, middle) || segments_cross(from, to, middle, right)));
  }
}

// Would catch a tool that starts in the plane of a surface, and takes it along when it leaves.
TEST_CASE("crossing: what starts in a plane has not come through it", "[unit]") {
  const auto still = [](const Vec3<double>& x) { return CornerWay{x, x}; };
  const double way = GENERATE(-1.0, 1.0);
  const CornerWay point{Vec3<double>{0.2, 0.2, 0}, Vec3<double>{0.2, 0.2, way}};
  CHECK_FALSE(point_crosses(point, still({0, 0, 0}), still({1, 0, 0}), still({0, 1, 0})));
}

// Would catch a division by nothing: of what does not move, or is one point.
TEST_CASE("crossing: what stands still or has no length crosses nothing", "[unit]") {
  const CornerWay a{Vec3<double>{0, 0, 0}, Vec3<double>{0, 0, 0}},
      b{Vec3<double>{1, 0, 0}, Vec3<double>{1, 0, 0}},
      c{Vec3<double>{0, 1, 0}, Vec3<double>{0, 1, 0}},
      d{Vec3<double>{0, 0, 1}, Vec3<double>{0, 0, 1}};
  CHECK_FALSE(segments_cross(a, b, c, d));
  CHECK_FALSE(segments_cross(a, a, c, c));
  CHECK_FALSE(point_crosses(a, b, c, d));
  CHECK_FALSE(point_crosses(a, b, b, b));
}

}  // namespace pbdsurg
