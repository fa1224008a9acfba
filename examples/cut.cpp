// SPDX-License-Identifier: Apache-2.0
// Holds a block of tissue at both ends and draws a blade down through its middle while it sags.
#include "pbdsurg/surgery/cut.h"

#include <cmath>
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/views/live_pieces.h"

namespace {

constexpr float kDensity = 1060;  // kg/m^3

// The pieces that tissue hangs together in, and the mass of each.
void print_pieces(const pbdsurg::Solver& solver, const pbdsurg::LivePieces& pieces) {
  std::printf("%d piece(s):", pieces.count());
  for (pbdsurg::Index piece = 0; piece < pieces.count(); ++piece) {
    double mass = 0;  // kg
    for (const pbdsurg::Index tet : pieces.tets(piece)) {
      mass += kDensity * solver.rest_volume(tet);
    }
    std::printf(" %d tets of %.4f g", pieces.tet_count(piece), 1e3 * mass);
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
  pbdsurg::LivePieces pieces(solver.tissue());
  print_pieces(solver, pieces);

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
    const pbdsurg::TissueChange& change = solver.tissue().apply(cut.edit);
    front = cut.front;  // where the next motion goes on
    if (!cut.edit.new_vertices.empty()) {
      std::printf("frame %2d: %3zu tets divided into %3zu, %3zu vertices more\n", frame,
                  change.removed_tets.size(), cut.edit.new_tets.size(),
                  cut.edit.new_vertices.size());
    }
    if (solver.step(1.0F / 60).non_finite_vertices > 0) {
      return 1;
    }
  }
  print_pieces(solver, pieces);
} catch (const std::exception& error) {
  std::fprintf(stderr, "cut: %s\n", error.what());
  return 2;
}
