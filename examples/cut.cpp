// SPDX-License-Identifier: Apache-2.0
// Cuts a block of tissue while it sags, takes a hole out of it, and takes the hole back.
#include "pbdsurg/surgery/cut.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <set>

#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/views/live_pieces.h"

namespace {

using pbdsurg::Index;

void print_pieces(const char* when, const pbdsurg::LivePieces& pieces) {
  std::printf("%s: %d piece(s):", when, pieces.count());
  for (Index piece = 0; piece < pieces.count(); ++piece) {
    std::printf(" %d tets", pieces.tet_count(piece));
  }
  std::printf("\n");
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 5e-3;  // m
  const pbdsurg::ImplicitShape box =
      pbdsurg::rounded_box_shape({0, 0, 0}, {0.03, 0.012, 0.012}, 2e-3);
  const pbdsurg::TetMesh block = pbdsurg::tetrahedralize(box, options).mesh;
  pbdsurg::Scene scene;
  scene.add_body("block", block, pbdsurg::elastic_material(block, 1060, 50e3));  // kg/m^3, Pa
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return std::abs(x.x()) > 0.025; });
  pbdsurg::Solver solver(scene);
  pbdsurg::Tissue& tissue = solver.tissue();
  pbdsurg::LivePieces pieces(tissue);  // follows each edit from here on
  print_pieces("whole", pieces);

  // cut: a straight edge, longer than the block is wide, comes down by 2 mm a frame
  pbdsurg::CutFront front;
  for (int frame = 0; frame < 20; ++frame) {
    const auto edge_at = [](float y) {
      return pbdsurg::BladeEdge{{0.003F, y, -0.03F}, {0.003F, y, 0.03F}};
    };
    const float y = 0.02F - 0.002F * static_cast<float>(frame);
    const pbdsurg::CutSurface swept = pbdsurg::sweep_blade({{edge_at(y), edge_at(y - 0.002F)}});
    const pbdsurg::CutPlan cut = pbdsurg::plan_cut(solver, swept, {.front = front});
    tissue.apply(cut.edit);
    front = cut.front;   // where the next motion goes on
    solver.step(5e-3F);  // s
  }
  print_pieces("cut", pieces);

  // remove: what is within 8 mm of a point, with crumbs of fewer than 8 tets that this would free
  const std::uint64_t before = solver.state_hash();
  std::set<Index> tets;
  for (const Index vertex : pbdsurg::find_vertices_near(solver, 0, {-0.01F, 0, 0}, 8e-3F)) {
    tets.insert(tissue.tets_at(vertex).begin(), tissue.tets_at(vertex).end());
  }
  pbdsurg::TopologyEdit hole{.remove_tets = {tets.begin(), tets.end()}};
  pieces.add_crumbs(tissue, hole, 8);
  const pbdsurg::TissueChange& change = tissue.apply(hole);
  std::printf("%zu tets and %zu edges go\n", change.removed_tets.size(),
              change.removed_edges.size());
  print_pieces("removed", pieces);

  // undo: the last edit, here with all bits, since nothing moved meanwhile
  tissue.undo();
  print_pieces("undone", pieces);
  std::printf("the state is %s\n", solver.state_hash() == before ? "as before" : "another");
} catch (const std::exception& error) {
  std::fprintf(stderr, "cut: %s\n", error.what());
  return 2;
}
