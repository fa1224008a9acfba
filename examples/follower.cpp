// SPDX-License-Identifier: Apache-2.0
// Keeps which tetrahedra are tumour, through burns, undo, cuts and a compaction.
#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/renumbering.h"

using namespace pbdsurg;

namespace {

class Tumour final : public Follower {
 public:
  Tumour(const Tissue& tissue, double radius) {  // m, around the origin
    std::vector<char> marks;
    for (const Tet& tet : tissue.tets()) {
      marks.push_back(tissue.rest_positions()[tet[0]].norm() < radius);
    }
    is_tumour_ = UndoArray<char>(std::move(marks));
    tissue.add_follower(*this);
  }

  // New tetrahedra have the ids that follow; removed ones keep theirs.
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override {
    is_tumour_.begin_edit();
    for (const NewTet& tet : change.edit.new_tets) {
      is_tumour_.push_back(is_tumour_[tet.parent]);
    }
    is_tumour_.resize(tissue.tets().size(), 0);  // of bodies that the edit brings
  }
  void undo(const Tissue&, const TissueChange&) noexcept override { is_tumour_.undo(); }
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override {
    std::vector<char> marks(tissue.tets().size());
    for (Index tet = 0; tet < is_tumour_.size(); ++tet) {
      if (ids.tets[tet] != kInvalidIndex) {
        marks[ids.tets[tet]] = is_tumour_[tet];
      }
    }
    is_tumour_ = UndoArray<char>(std::move(marks));
  }

  void print(const char* when, const Tissue& tissue) const {
    double mass = 0;  // kg
    for (Index tet = 0; tet < is_tumour_.size(); ++tet) {
      mass += is_tumour_[tet] != 0 && tissue.is_tet_alive(tet) ? tissue.tet_mass(tet) : 0;
    }
    std::printf("%-10s %zu tets ever, %.4f g of tumour\n", when, tissue.tets().size(), 1e3 * mass);
  }

 private:
  UndoArray<char> is_tumour_;  // [tet_count]
};

}  // namespace

int main() {
  TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  Scene scene;
  scene.add_body("liver", tetrahedralize(sphere_shape({0, 0, 0}, 0.02), options).mesh);
  Solver solver(scene);
  Tissue& tissue = solver.tissue();
  Tumour tumour(tissue, 9e-3);
  tumour.print("at first:", tissue);

  const auto tets = tissue.tets_at(tissue.tets()[3000][0]);  // a vertex near the middle
  tissue.apply({.remove_tets = {tets.begin(), tets.end()}});
  tumour.print("burnt:", tissue);
  tissue.undo();
  tumour.print("undone:", tissue);

  const BladeEdge before{{-0.03F, 0.03F, 0}, {-0.03F, -0.03F, 0}};
  const BladeEdge now{{0.03F, 0.03F, 0}, {0.03F, -0.03F, 0}};
  tissue.apply(plan_cut(solver, sweep_blade({{before, now}})).edit);
  tumour.print("cut:", tissue);

  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  tumour.print("compacted:", tissue);
}
