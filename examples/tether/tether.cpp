// SPDX-License-Identifier: Apache-2.0
// Hangs a lobe of liver on a suture that gives, joins a second lobe to it by another, cuts the
// first suture's hold away, and takes that back.
#include <cstdio>
#include <exception>
#include <memory>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

#include "examples/tether/tethers.h"

namespace {

using pbdsurg::Index;

// The vertex of a body that lies highest or lowest.
Index end_of(pbdsurg::World& world, pbdsurg::BodyId body, float up) {
  const auto positions = world.solver().positions();
  const pbdsurg::Body& own = world.tissue().body(world.body_in_tissue(body));
  Index found = own.first_vertex;
  for (Index v = own.first_vertex; v < own.first_vertex + own.vertex_count; ++v) {
    if (up * (positions[v].y() - positions[found].y()) > 0) {
      found = v;
    }
  }
  return found;
}

void rest_and_print(pbdsurg::World& world, const Tethers& sutures, const char* what) {
  for (int step = 0; step < 400; ++step) {
    world.step(5e-3);  // s
  }
  std::printf("%s: %.1f and %.1f mN\n", what, 1e3 * sutures.tension(0), 1e3 * sutures.tension(1));
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  pbdsurg::SolverOptions solver;
  solver.damping = 10;  // 1/s
  pbdsurg::World world(solver);
  const auto add_lobe = [&](const char* name, double height) {
    const pbdsurg::ImplicitShape lobe = pbdsurg::sphere_shape({0, height, 0}, 0.01);
    return world.add_body(name, pbdsurg::tetrahedralize(lobe, options).mesh,
                          pbdsurg::tissues::liver());
  };
  const pbdsurg::BodyId upper = add_lobe("upper", 0), lower = add_lobe("lower", -0.03);

  const Index top = end_of(world, upper, 1);
  const Eigen::Vector3f hook(0, 0.015F, 0);  // m
  const auto sutures = std::make_shared<Tethers>(std::vector<Tether>{
      {.vertex = top, .point = hook, .length = 5e-3F, .compliance = 0.05F},
      {.vertex = end_of(world, upper, -1), .other = end_of(world, lower, 1), .length = 0.01F}});
  world.add_constraints(sutures);
  rest_and_print(world, *sutures, "hanging");
  const Eigen::Vector3f held = world.solver().positions()[top];
  std::printf("the upper suture is %.2f mm longer\n", 1e3 * ((hook - held).norm() - 5e-3F));

  const auto around = world.tissue().tets_at(top);
  world.tissue().apply({.remove_tets = {around.begin(), around.end()}});
  world.step(5e-3);
  std::printf("torn out: %.1f mN\n", 1e3 * sutures->tension(0));
  world.undo();
  rest_and_print(world, *sutures, "undone");
  world.compact();
  rest_and_print(world, *sutures, "compacted");
} catch (const std::exception& error) {
  std::fprintf(stderr, "tether: %s\n", error.what());
  return 2;
}
