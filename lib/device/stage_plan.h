// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From the phases of a plan to the stages of a device. Stages of the vertex-block method are its
/// colours, then strain limits and stiff links; there are records of all constraints, for the
/// report.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/record_table.h"
#include "lib/device/stage_records.h"
#include "lib/device/stages.h"
#include "lib/solver/state/changes.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// Stages that constraints may join have spare records where the options ask for room, or edits
/// have brought constraints before: an edit is then followed record by record, until a stage has
/// none left.
class StagePlan {
 public:
  StagePlan() = default;

  /// @param records    filled
  /// @param has_grown  whether edits brought constraints before: more are expected
  StagePlan(const SolverData& data, StageRecords& records, bool has_grown = false);

  [[nodiscard]] std::span<const Stage> stages() const noexcept { return stages_; }

  /// Without those that wait for their first constraint, which edits open.
  [[nodiscard]] std::span<const Stage> open_stages() const noexcept { return open_stages_; }

  /// Changes with these.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  /// Finds what to write where, so that records follow changes of constraints and tetrahedra. Cost:
  /// proportional to the changes.
  /// @param words  appended to; where one is listed twice, both are alike
  /// @return       false if the plan has to be made anew, and follows no more: a stage has no spare
  ///               record left, or there is none for a group; a serial phase has changed; rows of
  ///               vertices were laid out anew; or damping came, or went
  [[nodiscard]] bool follow(const SolverData& data, const Changes& changes,
                            std::vector<WordChange>& words);

 private:
  class Builder;
  // An edge in the record of a tetrahedron that owns it, or did.
  struct TetEdge {
    Index tet, edge;
  };

  [[nodiscard]] Index pool_of(const SolverData& data, const Changes::Constraint& change) const;
  bool set_colors(const VertexBlocks& blocks);  // whether stages are others now
  void keep_stages_after_vertices();
  void list_open_stages();
  void note_owner(const SolverData& data, Index distance);
  void write_records(const SolverData& data, std::vector<WordChange>& words) const;
  void write_edges(const SolverData& data, std::vector<WordChange>& words) const;

  // One that has no constraint yet.
  struct WaitingStage {
    Index stage, pool;
  };

  std::vector<Stage> stages_;
  Index color_stages_ = 0;                    // of vertices
  std::vector<WaitingStage> waiting_stages_;  // ascending
  std::vector<Stage> open_stages_;
  std::uint64_t revision_ = 0;
  bool is_damped_ = false;
  RecordTable table_;
  std::array<std::vector<Index>, kHolderCount> pools_;  // [holder][group], or what stands for one
  Index tube_pool_ = kNoPool;
  std::vector<Index> owners_;  // [distance] the tetrahedron whose record has it, or kInvalidIndex
  std::vector<TetEdge> touched_edges_;
};

}  // namespace pbdsurg::cuda
