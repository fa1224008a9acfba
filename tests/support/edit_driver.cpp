// SPDX-License-Identifier: Apache-2.0
// One edit of tissue that many follow, for scripts/house-figures: a cut parts and divides
// tetrahedra, others and a link go. Where the library was compiled with -finstrument-functions, it
// prints the address of each function that is entered while the edit is applied, and '<' for each
// that returns.
#include <array>
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/surgery/membrane.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/small_steps.h"

namespace {

thread_local std::vector<void*>* calls = nullptr;  // entered; null for a return

[[gnu::no_instrument_function]] void note(void* function) {
  if (calls != nullptr) {
    calls->push_back(function);
  }
}

}  // namespace

extern "C" {
[[gnu::no_instrument_function]] void __cyg_profile_func_enter(void* function, void*) {
  note(function);
}
[[gnu::no_instrument_function]] void __cyg_profile_func_exit(void*, void*) {
  note(nullptr);
}
}

int main() try {
  using namespace pbdsurg;
  const auto block_at = [](double height) {
    TetrahedralizeOptions options;
    options.spacing = 4e-3;  // m
    return tetrahedralize(rounded_box_shape({0, 0, height}, {0.02, 0.01, 0.006}, 0.002), options)
        .mesh;
  };
  const TetMesh lower = block_at(0), upper = block_at(0.016);
  Material limited = elastic_material(upper, 1000, 20e3);  // kg/m^3, Pa
  limited.max_stretch = 1.3F;
  Scene scene;
  scene.add_body("lower", lower, elastic_material(lower, 1000, 20e3));
  scene.add_body("upper", upper, limited);
  ConnectiveTissue strands;
  strands.join(scene, 0, 1, scattered_links(lower, upper, {.max_distance = 8e-3, .density = 1e6}),
               {.segments = 2});

  Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  const std::array bodies{ThermalBody{0, tissues::fat().heat},
                          ThermalBody{1, tissues::liver().heat}};
  const HeatField field(solver.tissue(), bodies);
  const LiveSurface surface(solver.tissue(), 1);
  const LivePieces pieces(solver.tissue());
  solver.tissue().add_follower(strands, FollowerRank::surgery);
  solver.step(1e-3F);

  const auto blade_at = [](float height) {
    return BladeEdge{{1e-3F, -1, height}, {1e-3F, 1, height}};
  };
  TopologyEdit edit = plan_cut(solver, sweep_blade(std::array{blade_at(1), blade_at(0.012F)})).edit;
  if (edit.new_tets.empty() || edit.corner_moves.empty()) {
    throw InvalidArgument("the cut divides or parts no tetrahedron");
  }
  edit.remove_tets = {0, 1, 2};
  edit.remove_links = {0};

  std::vector<void*> entered;
  entered.reserve(1 << 24);
  calls = &entered;
  solver.tissue().apply(edit);
  calls = nullptr;
  for (void* function : entered) {
    function == nullptr ? std::puts("<") : std::printf("%p\n", function);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "edit_driver: %s\n", error.what());
  return 2;
}
