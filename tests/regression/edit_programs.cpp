// SPDX-License-Identifier: Apache-2.0
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/tissue/library.h"

#include "tests/regression/programs.h"
#include "tests/support/choices.h"
#include "tests/support/edit_maker.h"
#include "tests/support/edit_scenes.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {
namespace {

constexpr float kTimeStep = 1e-3F;  // s

// A random edit: some changes, or a cut with its front, and perhaps more.
void make_edit(Driver& driver, Choices& choices) {
  Solver& solver = driver.solver();
  CutPlan plan;
  const bool is_cut = choices.below(4) == 0;
  if (is_cut) {
    plan = make_cut(solver, choices.below(2) == 0 ? CutFront{} : driver.front(), choices);
  }
  EditMaker maker(solver, choices, plan.edit);
  for (Index more = choices.below(2) + (is_cut ? 0 : 1); more > 0; --more) {
    maker.add();
  }
  if (choices.below(6) == 0) {
    maker.add_links();
  }
  plan.edit = maker.edit();
  if (!is_cut && choices.below(3) == 0) {
    driver.edit_without_crumbs(plan.edit, 1 + choices.below(8));
  } else {
    driver.cut(plan);
  }
}

// For when edits have taken all there was.
TopologyEdit with_fresh_tissue(int round) {
  const TetMesh mesh = make_box({3, 2, 2}, 4e-3, 0.1);
  TopologyEdit edit;
  edit.new_bodies.add_body("fresh " + std::to_string(round), mesh,
                           elastic_material(mesh, 1000, 20e3));
  return edit;
}

void run_edits(const EditScene& scene, const SolverOptions& options, std::uint64_t seed,
               const Executor& executor, Record& record) {
  constexpr int kRounds = 36, kInterval = 18;
  Driver driver(scene.scene, options, executor);
  const ThermalBody warm{0, tissues::liver().heat};
  driver.follow_heat({&warm, 1});
  driver.follow_strands(scene.strands);
  driver.follow_pieces();
  Index surface_count = 0;
  const auto follow_new_surfaces = [&] {
    for (; surface_count < static_cast<Index>(driver.solver().tissue().bodies().size());
         ++surface_count) {
      driver.follow_surface(surface_count);
    }
  };
  follow_new_surfaces();
  const std::vector<std::uint8_t> bytes = random_bytes(seed, 100'000);
  Choices choices(bytes);
  for (int round = 1; round <= kRounds; ++round) {
    const bool is_within_step = choices.below(4) == 0;
    if (is_within_step) {
      driver.start_step(kTimeStep);
    }
    make_edit(driver, choices);
    const bool is_taken_back = choices.below(3) == 0, moves_first = choices.below(2) == 0;
    if (is_within_step) {
      driver.finish_step();
    } else if (moves_first) {
      driver.step(kTimeStep);
    }
    if (moves_first) {
      const HeatSource source{round % driver.solver().vertex_count(), 0.3};
      driver.heat(5e-3, {&source, 1});
    }
    if (is_taken_back) {
      driver.undo();
    } else {
      follow_new_surfaces();
    }
    if (round % kInterval == 0) {
      driver.look(record, round);
      driver.compact();
      surface_count = static_cast<Index>(driver.solver().tissue().bodies().size());
      driver.edit(with_fresh_tissue(round));
      follow_new_surfaces();
    }
  }
  driver.step(kTimeStep);
  driver.look(record, kRounds + 1);
}

}  // namespace

std::vector<Program> edit_programs() {
  std::vector<Program> programs;
  for (const EditScene& scene : edit_scenes()) {
    const std::vector<SolverOptions> all_options = edit_options(scene);
    std::string name = "edits-of-" + scene.name + "-";
    for (char& letter : name) {
      letter = letter == ' ' ? '-' : letter;
    }
    for (std::size_t i = 0; i < all_options.size(); ++i) {
      const SolverOptions options = all_options[i];
      const std::uint64_t seed = 100 + programs.size();
      programs.push_back({name + std::to_string(i),
                          [&scene, options, seed](const Executor& executor, Record& record) {
                            run_edits(scene, options, seed, executor, record);
                          }});
    }
  }
  return programs;
}

}  // namespace pbdsurg::testing
