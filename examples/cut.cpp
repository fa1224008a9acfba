// SPDX-License-Identifier: Apache-2.0
// Holds a block of tissue at both ends and draws a blade down through its middle while it sags.
#include "pbdsurg/edit/cut.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

namespace {

constexpr float kDensity = 1060;  // kg/m^3

// What is left, as pieces that hang together, and the mass of each.
void print_pieces(const pbdsurg::Solver& solver) {
  std::vector<pbdsurg::Tet> live;
  std::vector<double> masses;  // kg
  for (pbdsurg::Index t = 0; t < static_cast<pbdsurg::Index>(solver.tets().size()); ++t) {
    if (solver.is_tet_alive(t)) {
      live.push_back(solver.tets()[t]);
      masses.push_back(kDensity * solver.rest_volume(t));
    }
  }
  const auto pieces = pbdsurg::find_components(solver.vertex_count(), live);
  std::vector<double> piece_masses(pieces.count, 0);
  double mass = 0;
  for (std::size_t i = 0; i < live.size(); ++i) {
    piece_masses[pieces.of_vertex[live[i][0]]] += masses[i];
    mass += masses[i];
  }
  std::printf("%zu tets, %.4f g in %d piece(s):", live.size(), 1e3 * mass, pieces.count);
  for (const double piece : piece_masses) {
    std::printf(" %.4f g", 1e3 * piece);
  }
  std::printf("\n");
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 5e-3;  // m
  const pbdsurg::TetMesh block =
      pbdsurg::tetrahedralize(pbdsurg::rounded_box_shape({0, 0, 0}, {0.03, 0.012, 0.012}, 0.002),
                              options)
          .mesh;
  pbdsurg::Scene scene;
  scene.add_body("block", block, pbdsurg::elastic_material(block, kDensity, 20e3));  // Pa
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return std::abs(x.x()) > 0.025; });
  pbdsurg::Solver solver(scene);
  print_pieces(solver);

  pbdsurg::CutFront front;
  for (int frame = 0; frame < 30; ++frame) {
    // 2 mm a frame downwards; a straight edge, longer than the block is wide
    const auto edge_at = [](float height) {
      return pbdsurg::BladeEdge{{0.003F, height, -0.03F}, {0.003F, height, 0.03F}};
    };
    const float height = 0.02F - 0.002F * static_cast<float>(frame);
    const pbdsurg::CutPlan cut = pbdsurg::plan_cut(
        solver, pbdsurg::sweep_blade({{edge_at(height), edge_at(height - 0.002F)}}),
        {.front = front});
    const pbdsurg::EditResult result = pbdsurg::apply_edit(solver, cut.edit);
    front = cut.front;  // where the next motion goes on
    if (!cut.edit.new_vertices.empty()) {
      std::printf("frame %2d: %3zu tets divided into %3zu, %3zu vertices more\n", frame,
                  result.tets.size(), cut.edit.new_tets.size(), cut.edit.new_vertices.size());
    }
    if (solver.step(1.0F / 60).non_finite_vertices > 0) {
      return 1;
    }
  }
  print_pieces(solver);
} catch (const std::exception& error) {
  std::fprintf(stderr, "cut: %s\n", error.what());
  return 2;
}
