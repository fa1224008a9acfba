// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/thermal_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/heat_tissues.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kFat;
using testing::kLiver;
using testing::make_box;

// A third of each boundary triangle to each corner.
std::vector<double> surface_shares(Index vertex_count, std::span<const Eigen::Vector3d> x,
                                   std::span<const Tet> tets) {
  std::vector<double> shares(static_cast<std::size_t>(vertex_count), 0.0);
  for (const BoundaryTriangle& triangle : find_boundary(tets)) {
    const auto [a, b, c] = triangle.vertices;
    for (const Index v : triangle.vertices) {
      shares[v] += (x[b] - x[a]).cross(x[c] - x[a]).norm() / 6;
    }
  }
  return shares;
}

}  // namespace

// Would catch a wrong share or sign: -V grad N_i . grad N_j, gradients from the inverse of the
// corners' coordinates.
TEST_CASE("thermal mesh: coefficients and shares are those of linear elements", "[unit]") {
  const TetMesh mesh = make_box({4, 3, 3}, 1e-3, 0.2);
  const ThermalMesh thermal(mesh, kLiver);
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    Eigen::Matrix4d corners;
    for (int i = 0; i < 4; ++i) {
      corners.row(i) << 1, mesh.positions()[mesh.tets()[t][i]].transpose();
    }
    const Eigen::Matrix<double, 3, 4> gradients = corners.inverse().bottomRows<3>();
    const double volume = tet_volume(mesh.positions(), mesh.tets()[t]);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [i, j] = kTetEdges[e];
      CHECK(thermal.edge_coefficients(t)[e] ==
            Approx(-volume * gradients.col(i).dot(gradients.col(j))).margin(1e-12));
    }
  }
  const std::vector<double> masses = lumped_masses(mesh, kLiver.density);
  const std::vector<double> surfaces =
      surface_shares(mesh.vertex_count(), mesh.positions(), mesh.tets());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    CHECK(thermal.mass(v) == Approx(masses[v]));
    CHECK(thermal.surface_share(v) == Approx(surfaces[v]).margin(1e-15));
  }
  CHECK(thermal.sliver_count() == 0);
}

// Would catch faces that come to light unseen, and lists or flags that an undo leaves behind.
TEST_CASE("thermal mesh: its surface follows edits and undo", "[unit]") {
  const TetMesh mesh = make_box({4, 4, 4}, 1e-3, 0.1);
  Scene scene;
  scene.add_body("other", make_box({2, 2, 2}, 1e-3));
  scene.add_body("block", mesh);
  Tissue tissue(scene);
  const Body& body = tissue.body(1);
  const ThermalMesh thermal(tissue, std::array{ThermalBody{1, kFat}});
  TopologyEdit edit{.remove_tets = {0}};  // of the other body
  for (Index t = 0; t < body.tet_count; t += 7) {
    edit.remove_tets.push_back(body.first_tet + t);
  }
  const auto check = [&] {
    std::vector<Tet> live;
    for (Index t = 0; t < thermal.tet_count(); ++t) {
      if (thermal.is_alive(t)) {
        live.push_back(thermal.tets()[t]);
      }
    }
    const std::vector<double> surfaces =
        surface_shares(thermal.vertex_count(), thermal.rest_positions(), live);
    for (Index v = 0; v < thermal.vertex_count(); ++v) {
      REQUIRE(thermal.surface_share(v) == Approx(surfaces[v]).margin(1e-15));
    }
  };
  check();
  tissue.apply({.remove_tets = {1}});  // of the other body
  CHECK(thermal.version() == 0);
  const double whole = thermal.mass(body.first_vertex + 31);
  tissue.apply(edit);
  CHECK(thermal.version() == 1);
  CHECK_FALSE(thermal.is_alive(body.first_tet + 7));
  CHECK(std::ranges::count(thermal.touched(), body.first_vertex) == 1);
  CHECK(std::ranges::all_of(thermal.touched(), [&](Index v) { return v >= body.first_vertex; }));
  CHECK(thermal.mass(body.first_vertex + 31) < whole);
  check();
  tissue.undo();
  CHECK(thermal.version() == 0);  // as before the edit
  CHECK(thermal.mass(body.first_vertex + 31) == whole);
  check();
}

TEST_CASE("thermal mesh: flat tetrahedra conduct what is set for slivers, and are counted",
          "[unit]") {
  // a triangle of 1 m and a corner a little above its middle
  const double height = GENERATE(1e-3, 1e-5, 1e-7);
  const TetMesh sliver({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, height}}, {{{0, 1, 2, 3}}});
  const ThermalMesh thermal(sliver, kLiver);
  const double volume = height / 6, longest_cubed = std::sqrt(8.0);
  const bool is_limited = volume < ThermalMesh::kLeastVolume * longest_cubed;
  CHECK(is_limited == (height < 1e-4));
  CHECK(thermal.sliver_count() == (is_limited ? 1 : 0));
  CHECK(thermal.volume(0) == Approx(volume));
  // S_0 . S_3 / (9 V) of the face opposite to the origin and that of the triangle, areas 1/2
  const Eigen::Vector3d s0 =
      (Eigen::Vector3d(-1, 1, 0)).cross(Eigen::Vector3d(-0.7, 0.3, height)) / 2;
  const double used = std::max(volume, ThermalMesh::kLeastVolume * longest_cubed);
  CHECK(std::abs(thermal.edge_coefficients(0)[2]) ==
        Approx(std::abs(s0.dot(Eigen::Vector3d(0, 0, 0.5))) / (9 * used)));
}

TEST_CASE("thermal mesh: bad bodies and layers are refused by name", "[unit]") {
  const TetMesh block = make_box({1, 1, 1}, 1e-3);
  Scene scene;
  scene.add_body("fat", block);
  const Tissue tissue(scene);
  const auto make = [&](std::vector<ThermalBody> bodies) { return ThermalMesh(tissue, bodies); };
  CHECK_THROWS_WITH(make({{1, kFat}}), ContainsSubstring("no body 1"));
  CHECK_THROWS_WITH(make({{0, kFat}, {0, kFat}}), ContainsSubstring("body 'fat' is given twice"));
  CHECK_THROWS_WITH(make({{0, {1, 1, 1, 1.5}}}), ContainsSubstring("water fraction"));
  CHECK_THROWS_WITH(ThermalMesh(block, std::array{kFat}, std::array<Index, 6>{0, 0, 1, 0, 0, 0}),
                    ContainsSubstring("tet 2 is of tissue 1"));
}

}  // namespace pbdsurg
