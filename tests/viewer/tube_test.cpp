// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/tube.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

double enclosed_volume(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto at = [&](pbdsurg::Index v) -> Eigen::Vector3d {
      return mesh.positions[static_cast<std::size_t>(v)].cast<double>();
    };
    sum += at(a).cross(at(b)).dot(at(c)) / 6;
  }
  return sum;
}

}  // namespace

// Would catch inward winding, an open end and a twisted or collapsed ring.
TEST_CASE("tube: a straight rod has the volume of a capsule", "[property]") {
  const float scale = GENERATE(1.0f, 1e-3f, 1e-5f);
  const std::vector<Eigen::Vector3f> points{{0, 0, 0}, {scale, 0, 0}, {4 * scale, 0, 0}};
  const float radius = 0.5f * scale;

  const TriangleMesh mesh = sweep_tube(points, std::vector<float>(3, radius));

  const double pi = std::acos(-1.0);
  const double r = radius;
  const double capsule = pi * r * r * 4 * scale + 4.0 / 3 * pi * r * r * r;
  // a prism of 24 sides has 1.1 % less than its cylinder
  CHECK(enclosed_volume(mesh) > 0.97 * capsule);
  CHECK(enclosed_volume(mesh) < capsule);
}

TEST_CASE("tube: normals of a bent rod point outwards", "[property]") {
  const std::vector<Eigen::Vector3f> points{{0, 0, 0}, {0.01f, 0, 0}, {0.01f, 0.01f, 0}};
  const TriangleMesh mesh = sweep_tube(points, std::vector<float>(3, 0.001f));

  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh.positions, mesh.triangles);

  std::map<std::pair<pbdsurg::Index, pbdsurg::Index>, int> balance;
  for (const pbdsurg::Triangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      ++balance[{t[i], t[(i + 1) % 3]}];
    }
  }
  for (const auto& [edge, count] : balance) {
    REQUIRE(count == 1);  // each directed edge once: one consistent winding
  }
  for (std::size_t v = 0; v < normals.size(); ++v) {
    if (normals[v].isZero()) {
      continue;
    }
    CHECK(std::abs(normals[v].norm() - 1) < 1e-5f);
  }
  CHECK(enclosed_volume(mesh) > 0);
}

TEST_CASE("tube: what cannot be swept is left out", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> points{{0, 0, 0}, {0, 0, 0}, {nan, 0, 0}, {0, 0, 1}};

  const TriangleMesh mesh = sweep_tube(points, std::vector<float>(4, 0.1f));
  const std::vector<Eigen::Vector3f> clean{points[0], points[3]};

  CHECK(mesh.positions == sweep_tube(clean, std::vector<float>(2, 0.1f)).positions);
  CHECK(sweep_tube({points.data(), 3}, std::vector<float>(3, 0.1f)).triangles.empty());
  CHECK_THROWS_AS(sweep_tube(points, std::vector<float>(3, 0.1f)), pbdsurg::InvalidArgument);
}

TEST_CASE("tube: a normal is weighted by area and survives a broken triangle", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> positions{{0, 0, 0}, {3, 0, 0},     {0, 3, 0},
                                               {0, 0, 1}, {0, nan, nan}, {5, 5, 5}};
  // areas 4.5 towards +z and 1.5 towards -y at vertex 0
  const std::vector<pbdsurg::Triangle> triangles{{0, 1, 2}, {0, 1, 3}, {0, 2, 4}};

  const std::vector<Eigen::Vector3f> normals = vertex_normals(positions, triangles);

  CHECK((normals[0] - Eigen::Vector3f(0, -1, 3).normalized()).norm() < 1e-6f);
  CHECK(normals[5].isZero());
}

}  // namespace cholecystectomy
