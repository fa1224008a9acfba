// SPDX-License-Identifier: Apache-2.0
// What ids mean, what errors say, and what a step reports in place of an error.
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/library.h"

namespace {

// Prints what a call throws: the element, the value and the rule.
template <class Call>
void try_out(Call call) {
  try {
    call();
  } catch (const pbdsurg::Error& error) {
    std::printf("refused: %s\n", error.what());
  }
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 8e-3;  // m
  const auto ball_at = [&](double x) {
    return pbdsurg::tetrahedralize(pbdsurg::sphere_shape({x, 0, 0}, 0.02), options).mesh;
  };
  const pbdsurg::Material& liver = pbdsurg::tissues::liver().mechanics;
  pbdsurg::Scene scene;
  scene.add_body("left", ball_at(-0.03), liver);
  const pbdsurg::BodyId right = scene.add_body("right", ball_at(0.03), liver);

  // a body's own vertex 0 has another id in the scene
  scene.fix_vertices(right, {{0}});
  const pbdsurg::Body& body = scene.body(right);
  std::printf("body %d '%s': vertices %d to %d of the scene\n", right.value, body.name.c_str(),
              body.first_vertex, body.first_vertex + body.vertex_count - 1);

  try_out([&] { scene.fix_vertices(right, {{body.vertex_count}}); });
  try_out([&] { scene.add_body("left", ball_at(0)); });
  try_out([&] { pbdsurg::Solver(scene, {.substeps = -1}); });

  pbdsurg::Solver solver(scene);
  try_out([&] { solver.step(-1e-3F); });
  try_out([&] { solver.tissue().apply({.remove_tets = {5, 5}}); });

  // physics never throws: a vertex that flies off is reported
  std::vector<Eigen::Vector3f> velocities = solver.velocities();
  velocities[body.first_vertex + 7].x() = 1000;  // m/s
  solver.write_velocities(velocities);
  const pbdsurg::StepReport report = solver.step(5e-3F);  // s
  std::printf("reported: %d vertices not finite, %d tets inverted, volumes off by %.0f %%\n",
              report.non_finite_vertices, report.inverted_tets, 100 * report.volume_residual);
} catch (const std::exception& error) {
  std::fprintf(stderr, "units: %s\n", error.what());
  return 2;
}
