// SPDX-License-Identifier: Apache-2.0
// The vertex-block method: edits.
#include <cmath>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::farthest;
using testing::kSoftEdge;
using testing::neo_hookean;
using testing::run;
using testing::soft_springs;
using testing::vertex_options;

double volume_of(const Solver& solver) {
  std::vector<Eigen::Vector3d> x;
  for (const Eigen::Vector3f& p : solver.positions()) {
    x.push_back(p.cast<double>());
  }
  double volume = 0;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    volume += solver.tissue().is_tet_alive(t) ? tet_volume(x, solver.tissue().tets()[t]) : 0;
  }
  return volume;
}

}  // namespace

TEST_CASE("vertex method: an edited body moves like one made that way", "[property]") {
  const bool springs = GENERATE(false, true);
  const TetMesh mesh = testing::make_box({8, 3, 3}, kSoftEdge, 0.1);
  const Material material = springs ? soft_springs(mesh) : neo_hookean(3e4F, 0.4F);
  std::vector<Index> removed;
  std::vector<Tet> kept;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    const auto& tet = mesh.tets()[t];
    const double x = (mesh.positions()[tet[0]].x() + mesh.positions()[tet[3]].x()) / 2;
    const double y = (mesh.positions()[tet[0]].y() + mesh.positions()[tet[3]].y()) / 2;
    if (std::abs(x - 4 * kSoftEdge) < kSoftEdge && y > 2 * kSoftEdge) {
      removed.push_back(t);
    } else {
      kept.push_back(tet);
    }
  }
  REQUIRE(removed.size() > 10);
  const auto make = [&](const TetMesh& shape) {
    Scene scene;
    scene.add_body("bar", shape, material);
    scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
    return scene;
  };
  Solver edited(make(mesh), vertex_options(1, 60, 10));
  edited.tissue().apply({.remove_tets = removed});
  Solver made(make(TetMesh({mesh.positions().begin(), mesh.positions().end()}, kept)),
              vertex_options(1, 60, 10));
  const float before = made.positions().back().y();

  run(edited, 100);
  run(made, 100);

  const float sag = before - made.positions().back().y();
  REQUIRE(sag > 0.1F * static_cast<float>(kSoftEdge));
  CHECK(farthest(edited, made) < 0.01F * sag);
}

TEST_CASE("vertex method: tissue shrinks to new rest shapes", "[unit]") {
  const bool springs = GENERATE(false, true);
  const TetMesh mesh = testing::make_box({4, 3, 3}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, springs ? soft_springs(mesh) : neo_hookean(2e4F, 0.4F));
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, vertex_options(2, 20, 20));
  const double before = volume_of(solver);
  TopologyEdit edit;
  const float scale = 0.9F;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    edit.rest_volumes.push_back({t, scale * scale * scale * solver.rest_volume(t)});
  }
  for (Index e = 0; springs && e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    edit.rest_lengths.push_back({e, scale * solver.rest_length(e)});
  }
  solver.tissue().apply(edit);

  run(solver, 150);

  CHECK(volume_of(solver) == Approx(0.729 * before).epsilon(1e-3));
}

TEST_CASE("vertex method: links hold, until they are cut", "[unit]") {
  Scene scene;
  scene.add_particles("thread", std::vector<Eigen::Vector3d>{{0, 0, 0}, {0, -0.01, 0}}, 1e-3);
  scene.fix_vertices(0, std::vector<Index>{0});
  const Index link = scene.add_link({0, 1, 0.01F, {1, 0.1F}});
  Solver solver(scene, vertex_options(10, 1, 20));

  run(solver, 200);
  CHECK(solver.positions()[1].y() == Approx(-0.01 - 0.1 * 1e-3 * 9.81).epsilon(1e-3));

  solver.tissue().apply({.remove_links = {link}});
  run(solver, 40);
  CHECK(solver.positions()[1].y() < -0.05F);
}

}  // namespace pbdsurg
