// SPDX-License-Identifier: Apache-2.0
// Self-crossings as check_mesh() counts them.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/check.h"

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"
#include "tests/support/test_surfaces.h"

namespace pbdsurg {
namespace {

using testing::box_mesh;
using testing::box_surface;
using testing::icosphere;
using testing::joined;

using Vector3l = Eigen::Matrix<std::int64_t, 3, 1>;
using Polygon = std::vector<Vector3l>;  // a triangle or a segment

/// Whether two triangles or segments have no point in common: some direction parts them. Exact.
bool are_apart(const Polygon& first, const Polygon& second) {
  std::vector<Vector3l> directions;
  for (const Polygon& polygon : {first, second}) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      directions.emplace_back(polygon[(i + 1) % polygon.size()] - polygon[i]);
    }
    if (polygon.size() == 3) {
      directions.emplace_back((polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]));
    }
  }
  const std::size_t own = directions.size();
  for (std::size_t i = 0; i < own; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      directions.emplace_back(directions[i].cross(directions[j]));
    }
  }
  return std::any_of(directions.begin(), directions.end(), [&](const Vector3l& direction) {
    const auto along = [&](const Vector3l& a, const Vector3l& b) {
      return a.dot(direction) < b.dot(direction);
    };
    const auto [low1, high1] = std::minmax_element(first.begin(), first.end(), along);
    const auto [low2, high2] = std::minmax_element(second.begin(), second.end(), along);
    return along(*high1, *low2) || along(*high2, *low1);
  });
}

/// A triangle's corners: those that the other one has too, then its own.
struct Shared {
  Polygon common, own;
};

Shared split(const Polygon& triangle, const Polygon& other) {
  Shared corners;
  for (const Vector3l& corner : triangle) {
    const bool both = std::find(other.begin(), other.end(), corner) != other.end();
    (both ? corners.common : corners.own).push_back(corner);
  }
  return corners;
}

/// The definition, in whole numbers.
bool cross(const Polygon& first, const Polygon& second) {
  const Shared a = split(first, second), b = split(second, first);
  switch (a.common.size()) {
    case 0:
      return !are_apart(first, second);
    case 1:
      return !are_apart(a.own, second) || !are_apart(b.own, first);
    case 2: {
      const Vector3l edge = a.common[1] - a.common[0];
      const Vector3l up = edge.cross(a.own[0] - a.common[0]);
      const Vector3l other = edge.cross(b.own[0] - a.common[0]);
      return up.cross(other).isZero() && up.dot(other) > 0;
    }
    default:
      return false;  // they coincide
  }
}

/// @param side  points lie on a grid of so many places a side: a few for touching, many for
/// crossing
MeshData random_soup(std::uint64_t seed, int points, int triangles, std::uint64_t side) {
  MeshData mesh;
  for (int p = 0; p < points; ++p) {
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = static_cast<double>(
          random_bits(seed, static_cast<std::uint64_t>(p), static_cast<std::uint64_t>(axis)) %
          side);
    }
    mesh.points.push_back(point);
  }
  for (int t = 0; t < triangles; ++t) {
    Triangle triangle;
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] =
          static_cast<Index>(random_bits(seed + 1'000'000, static_cast<std::uint64_t>(t), i) %
                             static_cast<std::uint64_t>(points));
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

Index count_crossings(const MeshData& mesh) {
  std::vector<Polygon> triangles;
  for (const Triangle& t : mesh.triangles) {
    Polygon corners;
    for (const Index v : t) {
      corners.emplace_back(mesh.points[v].cast<std::int64_t>());
    }
    if (!(corners[1] - corners[0]).cross(corners[2] - corners[0]).isZero()) {
      triangles.push_back(corners);
    }
  }
  Index count = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      count += cross(triangles[i], triangles[j]) ? 1 : 0;
    }
  }
  return count;
}

template <class Map>
Index crossings_after(MeshData mesh, Map map) {
  for (Eigen::Vector3d& p : mesh.points) {
    p = map(p);
  }
  return check_mesh(mesh).self_crossings;
}

}  // namespace

// Would catch pairs that the tree does not bring together, each wrong sign of a predicate, and
// touching that is lost when coordinates are rounded.
TEST_CASE("surface crossing: soups have the pairs of a count in whole numbers, in every unit",
          "[property]") {
  Index total = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    const std::uint64_t side = std::array<std::uint64_t, 4>{3, 6, 40, 1000}[seed % 4];
    const MeshData soup = random_soup(seed, seed % 3 == 0 ? 12 : 60, 40, side);
    const Index due = count_crossings(soup);
    total += due;
    INFO("seed " << seed << ", side " << side);
    for (const double scale : {1.0, 1e-3, 1e3, 1 / 3.0, 1e-200, 1e200}) {
      INFO("scale " << scale);
      CHECK(crossings_after(soup, [=](const auto& p) { return (scale * p).eval(); }) == due);
    }
  }
  CHECK(total > 1000);
}

// Would catch neighbours that are taken for crossing: at flat sides, at sharp edges and where
// rounding bends a plane.
TEST_CASE("surface crossing: a closed surface without crossings has none, wherever it lies",
          "[property]") {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const MeshData shells =
      joined(icosphere({0, 0, 0}, 1, 3), icosphere({0, 0, 0}, 0.999, 3));  // 1 mm apart in 1 m
  for (const MeshData& mesh : {icosphere({0, 0, 0}, 1, 4), box_surface(6), box_mesh(4), shells}) {
    CHECK(check_mesh(mesh).self_crossings == 0);
    CHECK(crossings_after(mesh, [&](const auto& p) { return (turn * p).eval(); }) == 0);
    CHECK(crossings_after(mesh, [&](const auto& p) {
            return (1e-3 * (turn * p) + Eigen::Vector3d(7, -300, 0.1)).eval();
          }) == 0);
    // needles: sides of one to a million
    CHECK(crossings_after(mesh, [&](const auto& p) {
            return (turn * Eigen::Vector3d(p.x(), 1e-6 * p.y(), p.z())).eval();
          }) == 0);
  }
}

TEST_CASE("surface crossing: crossing, folding, overlapping and touching count", "[unit]") {
  const auto pairs = [](const std::vector<Eigen::Vector3d>& points,
                        const std::vector<Triangle>& triangles) {
    return check_mesh({points, {}, triangles}).self_crossings;
  };
  const std::vector<Triangle> apart{{0, 1, 2}, {3, 4, 5}}, at_edge{{0, 1, 2}, {1, 0, 3}},
      at_corner{{0, 1, 2}, {0, 3, 4}};
  // through each other
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, -1}, {1, 1, 1}, {9, 9, 1}}, apart) == 1);
  // through each other from a common corner
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, -1}, {1, 1, 1}}, at_corner) == 1);
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {-1, -1, -1}, {-1, -1, 1}}, at_corner) == 0);
  // folded at the common edge, at an angle, and flat
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 0}}, at_edge) == 1);
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 1e-9}}, at_edge) == 0);
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, -1, 0}}, at_edge) == 0);
  // one within the other, in one plane
  CHECK(pairs({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, apart) == 1);
  CHECK(pairs({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {8, 8, 0}, {7, 8, 0}, {8, 7, 0}}, apart) == 0);
  // a corner on the other's inside, on its edge, and just short of it
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 0}, {1, 1, 1}, {2, 1, 1}}, apart) == 1);
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 0, 0}, {1, -1, 1}, {2, -1, 1}}, apart) == 1);
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, 1e-9}, {1, 1, 1}, {2, 1, 1}}, apart) == 0);
  // without area
  CHECK(pairs({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {1, 1, -1}, {1, 1, 0}, {1, 1, 1}}, apart) == 0);
}

TEST_CASE("surface crossing: the boundary of tets is searched, and findings name the triangles",
          "[unit]") {
  MeshData mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}, {}};
  for (int i = 0; i < 4; ++i) {
    mesh.points.emplace_back(mesh.points[static_cast<std::size_t>(i)] +
                             Eigen::Vector3d(0.2, 0.1, -0.5));
  }
  CHECK(check_mesh(mesh).self_crossings == 0);
  mesh.tets.push_back({4, 5, 6, 7});
  const MeshReport report = check_mesh(mesh);
  CHECK(report.self_crossings > 0);
  CHECK(std::any_of(report.findings.begin(), report.findings.end(), [](const Finding& finding) {
    return finding.severity == Severity::warning &&
           finding.text.find("pairs of triangles that cross") == 0 &&
           finding.text.find(" with ") != std::string::npos;
  }));
}

// Would catch a search that never ends, or that passes over what it left out.
TEST_CASE("surface crossing: a search that ends early says so", "[unit]") {
  MeshData fan;
  constexpr int kBlades = 2000;  // two million pairs
  for (int i = 0; i < kBlades; ++i) {
    const double angle = std::numbers::pi * i / kBlades;
    const Eigen::Vector3d side(std::cos(angle), std::sin(angle), 0);
    const auto first = static_cast<Index>(fan.points.size());
    fan.points.insert(fan.points.end(), {side, -side, Eigen::Vector3d(0.01 * side.y(), 0, 1)});
    fan.triangles.push_back({first, first + 1, first + 2});
  }
  const auto says = [](const std::vector<std::string>& items, const std::string& text) {
    return std::any_of(items.begin(), items.end(), [&](const std::string& item) {
      return item.find(text) != std::string::npos;
    });
  };
  const MeshReport report = check_mesh(fan);
  CHECK(report.self_crossings == 1'000'000);
  CHECK(says(report.not_checked, "more self-crossings: the search ends with 1000000"));
  CHECK_FALSE(says(report.checked, "self-crossings"));
  MeshData pile;  // 5000 slanted triangles, each inside the boxes of most others, that do not meet
  for (int i = 0; i < 5000; ++i) {
    const double height = 1e-5 * i;
    const auto first = static_cast<Index>(pile.points.size());
    pile.points.insert(pile.points.end(),
                       {Eigen::Vector3d(0, 0, height), Eigen::Vector3d(1, 0, height + 1),
                        Eigen::Vector3d(0, 1, height + 1)});
    pile.triangles.push_back({first, first + 1, first + 2});
  }
  const MeshReport crowd = check_mesh(pile);
  CHECK(crowd.self_crossings == 0);
  CHECK(says(crowd.not_checked, "more self-crossings: too many triangles lie in one place"));
  const MeshReport clean = check_mesh(box_surface(2));
  CHECK(says(clean.checked, "self-crossings of the surface's 48 triangles"));
  CHECK_FALSE(says(clean.not_checked, "crossings"));
}

}  // namespace pbdsurg
