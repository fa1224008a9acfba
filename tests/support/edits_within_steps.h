// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edits while a step runs, on any backend.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/eventful_program.h"

namespace pbdsurg::testing {

/// A vertex with tissue, and all tetrahedra around it.
struct Surroundings {
  Index vertex;
  std::vector<Index> tets;
};

inline Surroundings some_surroundings(const Solver& solver, std::uint64_t round) {
  Surroundings found{static_cast<Index>(random_bits(round, 1) % 60), {}};
  while (!solver.tissue().has_tissue(found.vertex)) {
    found.vertex = (found.vertex + 1) % solver.vertex_count();
  }
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    if (solver.tissue().is_tet_alive(t) && has_corner(solver.tissue().tets()[t], found.vertex)) {
      found.tets.push_back(t);
    }
  }
  return found;
}

/// By turns: removals and rest values, a vertex that a tool holds and its links, links that come
/// and go, and new vertices.
inline TopologyEdit edit_within_step(const Solver& solver, Index round, const Surroundings& held) {
  switch (round % 5) {
    case 1:
      return {.remove_tets = held.tets};
    case 2: {
      TopologyEdit edit{
          .new_links = {{held.vertex, solver.vertex_count() - 1, 0.01F, {0.1F, 1e-2F}}}};
      if (const Index link = round % 24; solver.tissue().is_link_alive(link)) {
        edit.remove_links.push_back(link);
      }
      return edit;
    }
    case 3:
      return split_edge(solver, solver.tissue().tet_edges(held.tets.front())[round % 6], 0.5F);
    default:
      return eventful_edit(solver, round);
  }
}

/// Edits one solver within its steps and another after them, which must not be told apart, and
/// takes some edits back: within the step, after it, or a step later.
/// @param check_waiting  void(const TopologyEdit&), called after each edit within a step
template <class CheckWaiting>
void check_edits_within_steps(Solver& within, Solver& after, CheckWaiting check_waiting) {
  for (Solver* const solver : {&within, &after}) {
    const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
    solver->add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver->add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver->watch(std::array<Index, 3>{5, 1, 40});
  }
  for (Index round = 0; round < 60; ++round) {
    INFO(within.backend_name() << ": " << within.plan().name << ", round " << round);
    const Surroundings held = some_surroundings(after, static_cast<std::uint64_t>(round));
    ToolPose pose = ToolPose::Identity();
    pose.translation().x() = 1e-4F * static_cast<float>(round % 5);
    for (Solver* const solver : {&within, &after}) {
      solver->release(ToolId{1});
      solver->grasp(ToolId{1}, std::array{held.vertex}, 1e-4F);
      solver->move_tool(ToolId{1}, pose);
    }
    within.start_step(kEventfulTimeStep);
    const TopologyEdit edit = edit_within_step(within, round, held);
    const TissueChange result = within.tissue().apply(edit);
    check_waiting(edit);
    const bool is_undone_within = round % 6 == 1;
    if (is_undone_within) {
      within.tissue().undo();
    }
    const StepReport report = within.finish_step();

    REQUIRE(equal(report, after.step(kEventfulTimeStep)));
    const TissueChange expected = after.tissue().apply(edit);
    REQUIRE(result.removed_edges == expected.removed_edges);
    REQUIRE(result.emptied_vertices == expected.emptied_vertices);
    for (Index tool = 0; tool < 2; ++tool) {
      REQUIRE(within.tool_force(ToolId(tool)) == after.tool_force(ToolId(tool)));
    }
    REQUIRE(std::ranges::equal(within.watched_positions(), after.watched_positions()));
    if (round % 6 == 2) {
      within.step(kEventfulTimeStep);
      after.step(kEventfulTimeStep);
    }
    if (round % 6 < 4) {
      after.tissue().undo();
      if (!is_undone_within) {
        within.tissue().undo();
      }
    }
    REQUIRE(equal(within.step(kEventfulTimeStep), after.step(kEventfulTimeStep)));
    REQUIRE(within.state_hash() == after.state_hash());
    REQUIRE(within.snapshot().falling == after.snapshot().falling);
    REQUIRE(within.snapshot().roundings == after.snapshot().roundings);
  }
}

}  // namespace pbdsurg::testing
