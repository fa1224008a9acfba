// SPDX-License-Identifier: Apache-2.0
// Pulls a hanging strip of liver aside, tips the table, and blows at the strip.
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::Index;

// Where the far end has come, in mm, once the strip rests.
void rest_and_print(pbdsurg::World& world, const std::vector<Index>& end, const char* what) {
  for (int step = 0; step < 400; ++step) {
    world.step(5e-3);  // s
  }
  const std::vector<Eigen::Vector3f> x = world.solver().positions();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const Index v : end) {
    sum += x[v] / static_cast<float>(end.size());
  }
  std::printf("%s: the end at %.2f, %.2f, %.2f mm\n", what, 1e3 * sum.x(), 1e3 * sum.y(),
              1e3 * sum.z());
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape strip =
      pbdsurg::rounded_box_shape({0.03, 0, 0}, {0.03, 0.005, 0.01}, 1e-3);
  pbdsurg::SolverOptions solver;
  solver.damping = 20;  // 1/s
  pbdsurg::World world(solver);
  const pbdsurg::BodyId liver = world.add_body(
      "liver", pbdsurg::tetrahedralize(strip, options).mesh, pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.x() < 4e-3; });
  world.set_gravity({9.81F, 0, 0});  // the strip hangs along x
  std::vector<Index> end;
  for (Index v = 0; v < world.tissue().vertex_count(); ++v) {
    if (world.tissue().rest_positions()[v].x() > 0.058) {
      end.push_back(v);
    }
  }
  rest_and_print(world, end, "hanging");

  // a thread over a pulley, with 2 g: shared by the end's vertices, until it is replaced
  const Eigen::Vector3f pull(0, -0.002F * 9.81F / static_cast<float>(end.size()), 0);  // N
  world.set_forces(end, std::vector<Eigen::Vector3f>(end.size(), pull));
  rest_and_print(world, end, "pulled aside");

  world.set_gravity({9.4F, 0, 2.8F});  // the table is tipped by 17 degrees
  rest_and_print(world, end, "tipped");

  // a field of force: what is far from the hold is pushed the more, in N for each kg
  world.set_forces(liver, [&](Index v, const Eigen::Vector3f& x) -> Eigen::Vector3f {
    return static_cast<float>(world.tissue().masses()[v]) * Eigen::Vector3f(0, 50 * x.x(), 0);
  });
  rest_and_print(world, end, "blown at");

  world.clear_forces();
  world.set_gravity({9.81F, 0, 0});
  rest_and_print(world, end, "hanging again");
} catch (const std::exception& error) {
  std::fprintf(stderr, "loads: %s\n", error.what());
  return 2;
}
