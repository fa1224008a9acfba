// SPDX-License-Identifier: Apache-2.0
// Stretches a strip of muscle along its fibres, then turns them across.
#include <array>
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/tet_stress.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::Index;

constexpr double kLength = 0.04;  // m, along x

// How much longer the strip is between two of its vertices, once it rests; and what it bears there.
void rest_and_print(pbdsurg::World& world, Index first, Index last, const char* what) {
  for (int step = 0; step < 150; ++step) {
    world.step(5e-3);  // s
  }
  const pbdsurg::Solver& solver = world.solver();
  const auto before = world.tissue().rest_positions();
  const auto after = solver.positions();
  const double stretch =
      double{(after[last] - after[first]).norm()} /
      (before[static_cast<std::size_t>(last)] - before[static_cast<std::size_t>(first)]).norm();
  const std::array<Index, 1> tet{world.tissue().tets_at(first).front()};
  const float stress = pbdsurg::tet_stresses(solver, tet)[0].stress(0, 0);
  std::printf("%s: %.1f %% longer, %.1f kPa\n", what, 100 * (stretch - 1), 1e-3 * double{stress});
}

// The vertex that is nearest to a place.
Index nearest(const pbdsurg::Tissue& tissue, const Eigen::Vector3d& place) {
  Index best = 0;
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    const auto x = tissue.rest_positions();
    if ((x[v] - place).norm() < (x[best] - place).norm()) {
      best = v;
    }
  }
  return best;
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape strip =
      pbdsurg::rounded_box_shape({0, 0, 0}, {kLength / 2, 6e-3, 6e-3}, 1e-3);
  pbdsurg::SolverOptions solver;
  solver.damping = 20;  // 1/s
  pbdsurg::World world(solver);
  const pbdsurg::BodyId muscle = world.add_body(
      "muscle", pbdsurg::tetrahedralize(strip, options).mesh, pbdsurg::tissues::abdominal_wall());
  world.set_gravity({0, 0, 0});
  world.fix(muscle, [](const Eigen::Vector3d& x) { return x.x() < -0.9 * kLength / 2; });
  world.set_fibres(muscle, [](const Eigen::Vector3d&) {
    return pbdsurg::Fibre{{1, 0, 0}, 100e3F};  // along the strip, Pa
  });

  world.set_forces(muscle, [](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f {
    return {x.x() > 0.9F * kLength / 2 ? 0.05F : 0, 0, 0};  // N, at each vertex of the end
  });
  const Index middle = nearest(world.tissue(), {0, 0, 0});
  const Index beyond = nearest(world.tissue(), {0.2 * kLength, 0, 0});
  rest_and_print(world, middle, beyond, "along the fibres");

  pbdsurg::TopologyEdit turn;
  for (const Index t : world.tissue().tets_of(muscle)) {
    turn.fibres.push_back({t, {{0, 1, 0}, world.tissue().fibre(t).stiffness}});
  }
  world.edit(turn);
  rest_and_print(world, middle, beyond, "across");
} catch (const std::exception& error) {
  std::fprintf(stderr, "fibres: %s\n", error.what());
  return 2;
}
