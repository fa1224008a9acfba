// SPDX-License-Identifier: Apache-2.0
// Loads an organ, holds one end of it, lets it hang for half a second.
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/read.h"
#include "pbdsurg/solver/solver.h"

int main(int argc, char** argv) try {
  const char* path = argc > 1 ? argv[1] : "liver.vtu";
  const pbdsurg::TetMesh organ = pbdsurg::read_tet_mesh(path, {pbdsurg::LengthUnit::automatic});

  pbdsurg::Scene scene;
  const pbdsurg::Index body =
      scene.add_body("organ", organ, {.density = 1060, .youngs_modulus = 10e3F});  // kg/m^3, Pa
  const double middle = pbdsurg::bounding_box(organ).center().x();
  scene.fix_where(body, [&](const Eigen::Vector3d& x) { return x.x() < middle; });

  pbdsurg::Solver solver(scene);
  for (int step = 0; step < 50; ++step) {
    const pbdsurg::StepReport report = solver.step(0.01F);  // s
    if (report.non_finite_vertices > 0) {
      return 1;
    }
  }
  const Eigen::Vector3f last = solver.positions().back();  // m
  std::printf("%d vertices, the last at %.4f %.4f %.4f m\n", solver.vertex_count(), last.x(),
              last.y(), last.z());
} catch (const std::exception& error) {
  std::fprintf(stderr, "hello_tissue: %s\n", error.what());
  return 2;
}
