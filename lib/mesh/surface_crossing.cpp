// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/surface_crossing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lib/mesh/box_tree.h"

namespace pbdsurg {
namespace {

using Eigen::AlignedBox2d;
using Eigen::AlignedBox3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

// Coordinates are at most 1 here. Each is uncertain by the rounding of a change of unit, and what
// is computed from them by some more.
constexpr double kUncertainty = 32 * std::numeric_limits<double>::epsilon();

int sign(double value, double bound) {
  return value > bound ? 1 : value < -bound ? -1 : 0;
}

/// On which side of the plane of a, b, c a point lies: 0 if that is uncertain.
int side_of_plane(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& point) {
  const Vector3d u = b - a, v = c - a, w = point - a;
  const double lu = u.lpNorm<1>(), lv = v.lpNorm<1>(), lw = w.lpNorm<1>();
  return sign(u.dot(v.cross(w)), kUncertainty * (lu * lv + lv * lw + lw * lu));
}

/// On which side of the line through a and b a point lies: 0 if that is uncertain.
int side_of_line(const Vector2d& a, const Vector2d& b, const Vector2d& point) {
  const Vector2d u = b - a, v = point - a;
  return sign(u.x() * v.y() - u.y() * v.x(), kUncertainty * (u.lpNorm<1>() + v.lpNorm<1>()));
}

bool have_both_signs(int a, int b, int c) {
  return std::max({a, b, c}) > 0 && std::min({a, b, c}) < 0;
}

bool segments_meet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return side_of_line(a, b, c) * side_of_line(a, b, d) <= 0 &&
         side_of_line(c, d, a) * side_of_line(c, d, b) <= 0 &&
         AlignedBox2d(a).extend(b).intersects(AlignedBox2d(c).extend(d));
}

/// Whether a segment and a triangle meet when seen along the axis on which the triangle is
/// broadest: they do so in space, too, if they lie in one plane.
bool meet_in_plane(const Vector3d& p, const Vector3d& q, const Corners& triangle) {
  Eigen::Index axis = 0;
  (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).cwiseAbs().maxCoeff(&axis);
  const auto flattened = [axis](const Vector3d& x) {
    return Vector2d(x[(axis + 1) % 3], x[(axis + 2) % 3]);
  };
  const Vector2d from = flattened(p), to = flattened(q);
  const Vector2d a = flattened(triangle[0]), b = flattened(triangle[1]), c = flattened(triangle[2]);
  return !have_both_signs(side_of_line(a, b, from), side_of_line(b, c, from),
                          side_of_line(c, a, from)) ||
         segments_meet(from, to, a, b) || segments_meet(from, to, b, c) ||
         segments_meet(from, to, c, a);
}

/// Whether the segment from p to q and a triangle have a point in common.
/// @param side_p, side_q  of the triangle's plane
bool meets(const Vector3d& p, int side_p, const Vector3d& q, int side_q, const Corners& triangle) {
  if (side_p * side_q > 0) {
    return false;
  }
  if (side_p != 0 || side_q != 0) {
    const auto& [a, b, c] = triangle;
    const int ab = side_of_plane(p, q, a, b);
    const int bc = side_of_plane(p, q, b, c);
    const int ca = side_of_plane(p, q, c, a);
    if (have_both_signs(ab, bc, ca)) {
      return false;
    }
    if (side_p * side_q * ab * bc * ca != 0) {
      return true;
    }
  }
  return meet_in_plane(p, q, triangle);
}

std::array<int, 3> sides_of_plane(const Corners& plane, const Corners& triangle) {
  std::array<int, 3> sides;
  for (std::size_t i = 0; i < 3; ++i) {
    sides[i] = side_of_plane(plane[0], plane[1], plane[2], triangle[i]);
  }
  return sides;
}

/// Whether a side of the first triangle meets the second; with a common corner, the side opposite
/// to it alone. Of two triangles that meet elsewhere, one has such a side.
/// @param common  the number of the first triangle's common corner; 3 for none
bool side_meets(const Corners& first, const std::array<int, 3>& sides, std::size_t common,
                const Corners& second) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t from = (i + 1) % 3, to = (i + 2) % 3;
    if ((common == 3 || common == i) &&
        meets(first[from], sides[from], first[to], sides[to], second)) {
      return true;
    }
  }
  return false;
}

class CrossingSearch {
 public:
  CrossingSearch(std::span<const Vector3d> points, std::span<const Triangle> triangles)
      : triangles_(triangles) {
    double largest = 0;
    for (const Triangle& triangle : triangles) {
      for (const Index v : triangle) {
        largest = std::max(largest, points[v].cwiseAbs().maxCoeff());
      }
    }
    // a power of two, so that nothing is rounded
    int exponent = 0;
    std::frexp(largest, &exponent);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      Corners corners;
      for (std::size_t i = 0; i < 3; ++i) {
        corners[i] = points[triangles[t][i]].unaryExpr(
            [exponent](double x) { return std::ldexp(x, -exponent); });
      }
      const Vector3d u = corners[1] - corners[0], v = corners[2] - corners[0];
      if (u.cross(v).lpNorm<1>() > kUncertainty * (u.lpNorm<1>() + v.lpNorm<1>())) {
        corners_.push_back(corners);
        ids_.push_back(static_cast<Index>(t));
      }
    }
  }

  SurfaceCrossings run() {
    SurfaceCrossings result;
    std::vector<AlignedBox3d> boxes;
    std::vector<Vector3d> centers;
    for (const auto& [a, b, c] : corners_) {
      boxes.push_back(AlignedBox3d(a).extend(b).extend(c));
      centers.push_back(boxes.back().center());
    }
    const BoxTree tree(boxes, centers, [](std::span<const Index>) {});
    double left = std::max(kLeastCrossingComparisons,
                           kCrossingComparisons * static_cast<double>(corners_.size()));
    tree.visit_near_pairs([&](Index a, Index b) {
      if (--left < 0) {
        result.complete = false;
        return false;
      }
      if (boxes[a].intersects(boxes[b]) && cross(a, b)) {
        result.pairs.push_back(std::minmax(ids_[a], ids_[b]));
      }
      result.complete = result.pairs.size() < kMostCrossings;
      return result.complete;
    });
    std::sort(result.pairs.begin(), result.pairs.end());
    return result;
  }

 private:
  [[nodiscard]] bool cross(Index a, Index b) const {
    const Triangle& first = triangles_[ids_[a]];
    const Triangle& second = triangles_[ids_[b]];
    std::array<std::size_t, 2> common{3, 3};  // the last common corner, in both
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        if (first[i] == second[j]) {
          common = {i, j};
          ++count;
        }
      }
    }
    if (count == 3) {
      return false;
    }
    return count == 2 ? are_folded(a, b) : meet_beyond(corners_[a], corners_[b], common);
  }

  /// For triangles with a common edge.
  [[nodiscard]] bool are_folded(Index a, Index b) const {
    const Triangle& first = triangles_[ids_[a]];
    const Triangle& second = triangles_[ids_[b]];
    const auto lone_corner = [](const Triangle& triangle, const Triangle& other) {
      std::size_t i = 0;
      while (std::find(other.begin(), other.end(), triangle[i]) != other.end()) {
        ++i;
      }
      return i;
    };
    const std::size_t i = lone_corner(first, second), j = lone_corner(second, first);
    const Vector3d& from = corners_[a][(i + 1) % 3];
    const Vector3d& to = corners_[a][(i + 2) % 3];
    const Vector3d& p = corners_[a][i];
    const Vector3d& q = corners_[b][j];
    const Vector3d edge = to - from;
    return side_of_plane(from, to, p, q) == 0 && edge.cross(p - from).dot(edge.cross(q - from)) > 0;
  }

  [[nodiscard]] static bool meet_beyond(const Corners& first, const Corners& second,
                                        const std::array<std::size_t, 2>& common) {
    const auto is_apart = [](const std::array<int, 3>& sides) {
      return std::abs(sides[0] + sides[1] + sides[2]) == 3;
    };
    const std::array<int, 3> first_sides = sides_of_plane(second, first);
    if (is_apart(first_sides)) {
      return false;
    }
    const std::array<int, 3> second_sides = sides_of_plane(first, second);
    if (is_apart(second_sides)) {
      return false;
    }
    return side_meets(first, first_sides, common[0], second) ||
           side_meets(second, second_sides, common[1], first);
  }

  std::span<const Triangle> triangles_;
  std::vector<Corners> corners_;  // of those with an area
  std::vector<Index> ids_;        // and which they are
};

}  // namespace

SurfaceCrossings find_surface_crossings(std::span<const Vector3d> points,
                                        std::span<const Triangle> triangles) {
  return CrossingSearch(points, triangles).run();
}

}  // namespace pbdsurg
