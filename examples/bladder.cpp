// SPDX-License-Identifier: Apache-2.0
// Blows a bladder up, squeezes it, pricks it and lets it empty, closes it again and fills it with a
// syringe.
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/surgery/lumen.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::Index;

void run(pbdsurg::World& world, int steps) {
  for (int step = 0; step < steps; ++step) {
    world.step(5e-3);  // s
  }
}

void print(pbdsurg::World& world, const pbdsurg::Lumen& lumen, const char* what) {
  const double volume = lumen.cavity().volume(world.solver().positions());  // m^3
  const auto [amount, pressure] = lumen.state();
  std::printf("%s: %.0f Pa in %.2f ml, by p V %.3f of %.3f ml of air\n", what, double{pressure},
              1e6 * volume, 1e6 * volume * (1 + double{pressure} / 101325), 1e6 * amount);
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape ball = pbdsurg::sphere_shape({0, 0, 0}, 0.026);
  pbdsurg::SolverOptions solver;
  solver.damping = 10;  // 1/s
  pbdsurg::World world(solver);
  pbdsurg::TissueRecord wall = pbdsurg::tissues::gallbladder_wall();
  wall.mechanics.youngs_modulus = 20e3F;  // Pa: soft, since meshes of this size have thick walls
  const pbdsurg::BodyId bladder = world.add_body(
      "bladder", pbdsurg::tetrahedralize(pbdsurg::shell_shape(ball, 6e-3), options).mesh, wall);
  world.fix(bladder, [](const Eigen::Vector3d& x) { return x.y() < -0.02; });

  const auto walls = pbdsurg::find_cavities(world.tissue(), world.body_in_tissue(bladder));
  const auto lumen = std::make_shared<pbdsurg::Lumen>(world.tissue(), walls.at(0));
  world.add_constraints(lumen);
  run(world, 100);
  print(world, *lumen, "at rest");

  lumen->set_reservoir(1e-5F, 300);  // m^2, Pa: an insufflator
  run(world, 300);
  print(world, *lumen, "blown up");
  lumen->set_reservoir(0, 0);

  world.set_forces(bladder, [](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f {
    return {x.x() > 0.02F ? -2e-3F : x.x() < -0.02F ? 2e-3F : 0, 0, 0};  // N, from two sides
  });
  run(world, 200);
  print(world, *lumen, "squeezed");
  world.clear_forces();
  run(world, 200);

  pbdsurg::TopologyEdit prick;  // through the wall, above
  const auto x = world.tissue().rest_positions();
  for (Index t = 0; t < static_cast<Index>(world.tissue().tets().size()); ++t) {
    const pbdsurg::Tet& tet = world.tissue().tets()[t];
    const Eigen::Vector3d middle = (x[tet[0]] + x[tet[1]] + x[tet[2]] + x[tet[3]]) / 4;
    if (middle.y() > 0 && std::hypot(middle.x(), middle.z()) < 2e-3) {
      prick.remove_tets.push_back(t);
    }
  }
  world.tissue().apply(prick);
  std::printf("pricked: %d hole of %.0f mm^2\n", lumen->cavity().hole_count(),
              1e6 * lumen->cavity().hole_area(world.solver().positions()));
  int steps = 0;
  for (; lumen->pressure() > 30 && steps < 1000; ++steps) {
    run(world, 1);
  }
  std::printf("below 30 Pa after %d ms\n", 5 * steps);

  world.undo();
  print(world, *lumen, "closed again");
  lumen->set_inflow(2e-6F);  // m^3/s: a syringe
  run(world, 200);
  lumen->set_inflow(0);
  run(world, 100);
  print(world, *lumen, "2 ml of air later");
} catch (const std::exception& error) {
  std::fprintf(stderr, "bladder: %s\n", error.what());
  return 2;
}
