// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"
#include "tests/support/test_surfaces.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;
using testing::ContainsSubstring;
using testing::icosphere;
using testing::joined;
using testing::turned;

constexpr double kRadius = 0.02;

Vector3d random_point(int element) {
  Vector3d point;
  for (int axis = 0; axis < 3; ++axis) {
    point[axis] = 2 * kRadius * (2 * random_unit(3, static_cast<std::uint64_t>(element), axis) - 1);
  }
  return point;
}

SurfaceDistance distance_to(const MeshData& mesh) {
  return SurfaceDistance(mesh.points, mesh.triangles);
}

// Removes all triangles that reach above a height.
MeshData opened(MeshData mesh, double height) {
  std::erase_if(mesh.triangles, [&](const Triangle& triangle) {
    return std::any_of(triangle.begin(), triangle.end(),
                       [&](Index v) { return mesh.points[v].z() > height; });
  });
  return mesh;
}

}  // namespace

// An icosphere of 1280 triangles keeps within 0.5 % of its sphere.
TEST_CASE("surface distance: a fine icosphere is a sphere", "[property]") {
  const SurfaceDistance surface = distance_to(icosphere({0, 0, 0}, kRadius, 3));
  for (int i = 0; i < 1000; ++i) {
    const Vector3d point = random_point(i);
    const double exact = point.norm() - kRadius;
    CHECK(surface.signed_distance(point) == Approx(exact).margin(0.005 * kRadius));
    CHECK(surface.closest_point(point).norm() == Approx(kRadius).epsilon(0.005));
    if (std::abs(exact) > 0.01 * kRadius) {
      CHECK(surface.winding_number(point) == Approx(exact < 0 ? 1 : 0).margin(0.04));
    }
  }
}

// Would catch a bounding volume that cuts off the nearest triangle.
TEST_CASE("surface distance: no triangle is nearer than the closest point", "[property]") {
  const MeshData mesh = icosphere({0, 0, 0}, kRadius, 2);
  const SurfaceDistance surface = distance_to(mesh);
  for (int i = 0; i < 300; ++i) {
    const Vector3d point = random_point(i);
    const double distance = (surface.closest_point(point) - point).norm();
    for (const auto& [a, b, c] : mesh.triangles) {
      const Vector3d middle = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
      REQUIRE((middle - point).norm() >= distance);
      REQUIRE((mesh.points[a] - point).norm() >= distance);
      REQUIRE((0.5 * (mesh.points[a] + mesh.points[b]) - point).norm() >= distance);
    }
  }
}

TEST_CASE("surface distance: an inside-out surface is turned", "[unit]") {
  const SurfaceDistance surface = distance_to(turned(icosphere({0, 0, 0}, kRadius, 2)));
  CHECK(surface.was_inside_out());
  CHECK(surface.winding_number({0, 0, 0}) == Approx(1).margin(0.04));
  CHECK(surface.signed_distance({0, 0, 0}) < 0);
  CHECK_FALSE(distance_to(icosphere({0, 0, 0}, kRadius, 2)).was_inside_out());
}

TEST_CASE("surface distance: triangles wound against their neighbours are turned", "[unit]") {
  MeshData mesh = icosphere({0, 0, 0}, kRadius, 2);
  Index against = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    ++against;
  }
  const SurfaceDistance surface = distance_to(mesh);
  CHECK(surface.turned_triangles() == against);
  CHECK_FALSE(surface.was_inside_out());
  CHECK(surface.winding_number({0, 0, 0}) == Approx(1).margin(0.04));
}

TEST_CASE("surface distance: a hole gets a lid without a jump", "[property]") {
  const double rim = 0.5 * kRadius;
  const SurfaceDistance surface = distance_to(opened(icosphere({0, 0, 0}, kRadius, 3), rim));
  CHECK(surface.signed_distance({0, 0, -0.5 * kRadius}) < 0);
  CHECK(surface.signed_distance({0, 0, 1.5 * kRadius}) > 0);
  // along the axis through the hole
  constexpr int kSteps = 4000;
  const double step = 3 * kRadius / kSteps;
  double last = surface.signed_distance({0, 0, -kRadius / 2});
  int changes = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = surface.signed_distance({0, 0, -kRadius / 2 + i * step});
    // steps of the dipole approximation come on top of the slope
    CHECK(std::abs(next - last) < 3 * step + 0.05 * kRadius);
    changes += (next < 0) != (last < 0) ? 1 : 0;
    last = next;
  }
  CHECK(changes == 1);
}

TEST_CASE("surface distance: crossing spheres are inside of either", "[unit]") {
  const SurfaceDistance surface =
      distance_to(joined(icosphere({0, 0, 0}, kRadius, 2), icosphere({kRadius, 0, 0}, kRadius, 2)));
  CHECK(surface.winding_number({0.5 * kRadius, 0, 0}) == Approx(2).margin(0.08));
  CHECK(surface.signed_distance({0.5 * kRadius, 0, 0}) < 0);
  CHECK(surface.signed_distance({-0.5 * kRadius, 0, 0}) < 0);
  CHECK(surface.signed_distance({1.5 * kRadius, 0, 0}) < 0);
  CHECK(surface.signed_distance({0.5 * kRadius, kRadius, 0}) > 0);
}

TEST_CASE("surface distance: a surface without an inside is refused", "[unit]") {
  const MeshData sphere = icosphere({0, 0, 0}, kRadius, 2);
  CHECK_THROWS_WITH(distance_to(opened(sphere, -0.7 * kRadius)),
                    ContainsSubstring("encloses nothing"));
  // a sphere and the same inside out around it: every winding number is small
  MeshData cancelled = joined(sphere, turned(sphere));
  CHECK_THROWS_WITH(distance_to(cancelled), ContainsSubstring("winding number"));
  CHECK_THROWS_WITH(distance_to(MeshData{}), ContainsSubstring("none of its 0 triangles"));
  MeshData broken = sphere;
  broken.triangles[7][1] = 100000;
  CHECK_THROWS_WITH(distance_to(broken), ContainsSubstring("triangle 7 refers to vertex 100000"));
  broken = sphere;
  broken.points[5].y() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(distance_to(broken), ContainsSubstring("vertex 5"));
}

}  // namespace pbdsurg
