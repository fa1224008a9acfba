// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A solver of many copies against as many solvers of one, which do and undergo the same.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/eventful_program.h"

namespace pbdsurg::testing {

/// What happens to copies: each starts elsewhere, and its tools do something of their own. Choices
/// follow from round and copy alone.
class CopiesProgram {
 public:
  static constexpr int kThirdTool = 14;  // the round in which it comes

  explicit CopiesProgram(const Scene& scene) {
    for (const Eigen::Vector3d& x : scene.positions()) {
      rest_.push_back(x.cast<float>());
    }
  }

  /// Before the first round, for all copies of a solver.
  void begin(Solver& solver) const {
    solver.add_tool({&capsule_, 1}, pose(0, 0), {ContactFeatures::vertices});
    // pushes, too, while it holds nothing
    solver.add_tool({&capsule_, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver.watch(std::array<Index, 3>{5, 1, 40});
  }

  /// Before a step, for all copies of a solver.
  void edit(Solver& solver, int round) const {
    TopologyEdit edit;
    for (std::uint64_t i = 0; i < 4; ++i) {
      const auto tet = static_cast<Index>(random(round, 100 + i) % solver.tissue().tets().size());
      if (solver.tissue().is_tet_alive(tet) &&
          std::ranges::find(edit.remove_tets, tet) == edit.remove_tets.end()) {
        edit.remove_tets.push_back(tet);
      }
    }
    const auto link = static_cast<Index>(random(round, 110) % solver.tissue().links().size());
    if (solver.tissue().is_link_alive(link)) {
      edit.remove_links.push_back(link);
    }
    if (removes_held(round)) {
      for (const Index gone : {vertex(solver, round, kHeld), vertex(solver, round, kHeld + 1)}) {
        for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
          const bool is_near =
              std::ranges::find(solver.tissue().tets()[t], gone) != solver.tissue().tets()[t].end();
          if (is_near && solver.tissue().is_tet_alive(t) &&
              std::ranges::find(edit.remove_tets, t) == edit.remove_tets.end()) {
            edit.remove_tets.push_back(t);
          }
        }
      }
    }
    solver.tissue().apply(edit);
    if (round == kThirdTool) {
      solver.add_tool({&capsule_, 1}, pose(round, 3), {ContactFeatures::vertices});
      solver.watch(std::array<Index, 2>{7, 30});
    }
  }

  /// Before a step, for one copy.
  /// @param which  copy of all
  /// @param copy   of this solver
  void act(Solver& solver, int round, Index which, Index copy) const {
    solver.move_tool(ToolId{0}, pose(round, which), copy);
    switch (random(round, which) % 9) {
      case 0:
      case 1:
        break;
      case 2:
        solver.write_velocities(scaled(rest_, 0.3F * static_cast<float>(which)), copy);
        break;
      case 3:
        solver.write_positions(scaled(rest_, 1 + 0.01F * static_cast<float>(which)), copy);
        break;
      case 4: {
        const Snapshot snapshot = solver.snapshot(copy);
        solver.write_positions(rest_, copy);
        solver.restore(snapshot, copy);
        break;
      }
      case 5:
        solver.release(ToolId{1}, copy);
        break;
      case 6:
        solver.release(ToolId{0}, copy);
        break;
      case 7:
        grasp(solver, round, 0, copy);
        [[fallthrough]];  // both hold the same
      default:
        grasp(solver, round, 1, copy);
        break;
    }
    if (removes_held(round) && which % 2 == 1) {  // not the first copy
      grasp(solver, round, 1, copy);
    }
  }

  /// Before a step, beside act(), for one copy: forces of its own, and gravity of all.
  void load(Solver& solver, int round, Index which, Index copy) const {
    const std::uint64_t choice = random(round, 20 + static_cast<std::uint64_t>(which));
    if (choice % 4 == 0) {
      const std::array forces{Eigen::Vector3f(1e-4F * static_cast<float>(which), 2e-4F, 0)};
      solver.set_forces(std::array{vertex(solver, round, 140)}, forces, copy);
    } else if (choice % 16 == 1) {
      solver.clear_forces(copy);
    }
    if (round % 8 == 6) {
      solver.set_gravity(static_cast<Index>(random(round, 150) % 3), Eigen::Vector3f(0, -5, 2));
    } else if (round % 16 == 13) {
      solver.set_gravity(Eigen::Vector3f(1, -9.81F, 0));
    }
  }

 private:
  static constexpr std::uint64_t kHeld = 130;  // choices of vertices to grasp: this and the next

  /// Rounds whose edit follows the copies' deeds, and takes away what some of them hold.
  static bool removes_held(int round) { return round % 12 == 3; }

  [[nodiscard]] static std::uint64_t random(int round, std::uint64_t what) {
    return random_bits(7, static_cast<std::uint64_t>(round), what) >> 8;
  }

  [[nodiscard]] static std::vector<Eigen::Vector3f> scaled(std::vector<Eigen::Vector3f> values,
                                                           float scale) {
    for (Eigen::Vector3f& value : values) {
      value *= scale;
    }
    return values;
  }

  [[nodiscard]] static ToolPose pose(int round, Index which) {
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(1e-3F * static_cast<float>(which),
                                         0.018F - 4e-4F * static_cast<float>(round % 10), 0.006F);
    return pose;
  }

  [[nodiscard]] Index vertex(const Solver& solver, int round, std::uint64_t what) const {
    const auto count = static_cast<Index>(rest_.size());
    Index v = static_cast<Index>(random(round, what) % rest_.size());
    while (!solver.tissue().has_tissue(v)) {
      v = (v + 1) % count;
    }
    return v;
  }

  void grasp(Solver& solver, int round, Index tool, Index copy) const {
    solver.release(ToolId(tool), copy);
    std::vector<Index> held{vertex(solver, round, kHeld), vertex(solver, round, kHeld + 1)};
    if (held[0] == held[1]) {
      held.pop_back();
    }
    solver.grasp(ToolId(tool), held, tool == 0 ? 0 : 1e-4F, copy);
  }

  std::vector<Eigen::Vector3f> rest_;
  Capsule capsule_{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
};

struct CopiesComparison {
  std::string difference;  ///< the first, in words; empty if there is none
  Index contacts = 0;      ///< of all copies and steps
  int forces = 0;          ///< tools that feel one, likewise
};

inline std::string describe(const std::vector<Eigen::Vector3f>& copy,
                            const std::vector<Eigen::Vector3f>& single) {
  std::ostringstream text;
  text.precision(9);
  int count = 0;
  for (std::size_t v = 0; v < single.size(); ++v) {
    if (copy[v] != single[v] && count++ == 0) {
      text << "vertex " << v << " is at " << copy[v].transpose() << " in place of "
           << single[v].transpose() << ", apart by " << 1e9F * (copy[v] - single[v]).transpose()
           << " nm; ";
    }
  }
  text << count << " of " << single.size() << " positions differ";
  return text.str();
}

/// Every other copy has a gravity of its own, and a material where the options allow that.
inline CopyFactors factors_of(Index copy, const SolverOptions& options) {
  if (copy % 2 == 0) {
    return {};
  }
  const float more = 1 + 0.1F * static_cast<float>(copy % 7);
  return options.mode == ProjectionMode::fraction
             ? CopyFactors{.gravity = more}
             : CopyFactors{.stiffness = 0.7F * more, .density = 1 / more, .gravity = more};
}

/// @param options  of the solver of copies
/// @param alone    of the solvers of one
inline CopiesComparison compare_copies(const Scene& scene, SolverOptions options,
                                       const SolverOptions& alone, Index copies, int rounds) {
  options.copies = copies;
  const CopiesProgram program(scene);
  Solver solver(scene, options);
  std::vector<std::unique_ptr<Solver>> singles;
  program.begin(solver);
  for (Index i = 0; i < copies; ++i) {
    singles.push_back(std::make_unique<Solver>(scene, alone));
    program.begin(*singles.back());
    solver.set_factors(factors_of(i, options), i);
    singles.back()->set_factors(factors_of(i, options));
  }

  CopiesComparison result;
  std::ostringstream text;
  const auto differ = [&](int round) {
    const bool edits_first = round % 2 == 0;
    const auto edit = [&] {
      if (round % 4 >= 2) {
        program.edit(solver, round);
        for (const auto& single : singles) {
          program.edit(*single, round);
        }
      }
    };
    if (edits_first) {
      edit();
    }
    for (Index i = 0; i < copies; ++i) {
      program.act(solver, round, i, i);
      program.act(*singles[i], round, i, 0);
      program.load(solver, round, i, i);
      program.load(*singles[i], round, i, 0);
    }
    if (!edits_first) {
      edit();
    }
    const StepReport report = solver.step(kEventfulTimeStep);
    StepReport expected;
    for (Index i = 0; i < copies; ++i) {
      const StepReport single = singles[i]->step(kEventfulTimeStep);
      expected.inverted_tets += single.inverted_tets;
      expected.contacts += single.contacts;
      expected.dropped_contacts += single.dropped_contacts;
      expected.distance_residual = std::max(expected.distance_residual, single.distance_residual);
      expected.volume_residual = std::max(expected.volume_residual, single.volume_residual);
    }
    result.contacts += expected.contacts;
    for (Index i = 0; i < copies; ++i) {
      text << "round " << round << ", copy " << i << ": ";
      if (!equal(solver.last_report(i), singles[i]->last_report())) {
        text << "reports differ; " << describe(solver.positions(i), singles[i]->positions());
        return true;
      }
      if (!std::ranges::equal(solver.watched_positions(i), singles[i]->watched_positions())) {
        text << "watched positions differ; "
             << describe(solver.positions(i), singles[i]->positions());
        return true;
      }
      if (round % 3 == 0 && solver.state_hash(i) != singles[i]->state_hash()) {
        text << describe(solver.positions(i), singles[i]->positions());
        return true;
      }
      for (Index tool = 0; tool < (round < CopiesProgram::kThirdTool ? 2 : 3); ++tool) {
        const Eigen::Vector3f force = solver.tool_force(ToolId(tool), i);
        result.forces += force.isZero() ? 0 : 1;
        if (force != singles[i]->tool_force(ToolId(tool))) {
          text << "tool " << tool << " feels " << force.transpose() << " N in place of "
               << singles[i]->tool_force(ToolId(tool)).transpose() << "; "
               << describe(solver.positions(i), singles[i]->positions());
          return true;
        }
      }
      text.str({});
    }
    if (!equal(report, expected)) {
      text << "round " << round << ": the report says " << report.inverted_tets << ", "
           << report.non_finite_vertices << ", " << report.contacts << ", "
           << report.dropped_contacts.total() << ", " << report.distance_residual << ", "
           << report.volume_residual << " in place of " << expected.inverted_tets << ", 0, "
           << expected.contacts << ", " << expected.dropped_contacts.total() << ", "
           << expected.distance_residual << ", " << expected.volume_residual;
      return true;
    }
    return false;
  };
  for (int round = 0; round < rounds; ++round) {
    if (differ(round)) {
      result.difference = std::string(solver.backend_name()) + ", " + text.str();
      return result;
    }
  }
  for (Index i = 0; i < copies; ++i) {
    if (solver.state_hash(i) != singles[i]->state_hash()) {
      result.difference = "at the end, copy " + std::to_string(i) + ": " +
                          describe(solver.positions(i), singles[i]->positions());
      return result;
    }
  }
  return result;
}

}  // namespace pbdsurg::testing
