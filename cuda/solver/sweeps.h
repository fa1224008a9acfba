// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The strategies of sweeping on a device.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/solver/solver_options.h"

#include "cuda/solver/step_kernels.h"
#include "lib/device/device_arrays.h"
#include "lib/device/stage_plan.h"
#include "lib/device/stages.h"
#include "lib/solver/state/changes.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// What sweeps work on. All pointers stay what they are until a step is recorded again.
struct SweepArrays {
  DeviceState state;
  ConstraintArrays constraints;
  ToolArrays tools;
  StepInput* input = nullptr;
  std::span<const Stage> stages;
  bool has_pushers = false;
  bool has_attachments = false;
  bool has_meeters = false;  ///< tools that meet surfaces
  bool has_grips = false;    ///< jaws that hold with a limit
  bool has_touches = false;  ///< bodies that meet each other
  VertexArrays vertices{};
  Index sweep_count = 1;         ///< of a substep
  bool has_stiff_links = false;  ///< that live: else some stages have none left
  FreePieceArrays free_pieces{};
  CoarseArrays coarse{};
  std::uint64_t stages_revision = 0;  ///< changes with the stages
  std::span<const FillingArrays> fillings{};
  std::uint64_t fillings_revision = 0;  ///< changes with these

  /// Or what acts where they do.
  [[nodiscard]] bool has_tools() const noexcept {
    return has_pushers || has_attachments || has_meeters || has_grips || has_touches;
  }
  /// Of each substep, after its first sweep.
  [[nodiscard]] bool has_correction() const noexcept {
    return coarse.node_count > 0 && sweep_count > 1;
  }

  bool operator==(const SweepArrays& other) const {
    return state == other.state && constraints == other.constraints && tools == other.tools &&
           input == other.input && stages.data() == other.stages.data() &&
           stages.size() == other.stages.size() && has_pushers == other.has_pushers &&
           has_attachments == other.has_attachments && has_meeters == other.has_meeters &&
           has_grips == other.has_grips && has_touches == other.has_touches &&
           vertices == other.vertices && sweep_count == other.sweep_count &&
           has_stiff_links == other.has_stiff_links && free_pieces == other.free_pieces &&
           coarse == other.coarse && stages_revision == other.stages_revision &&
           fillings_revision == other.fillings_revision;
  }
};

/// Those of the two compilations that options ask for.
[[nodiscard]] inline const StepKernels& kernels_of(const SolverOptions& options) noexcept {
  return options.math == MathMode::strict ? strict_kernels : fast_kernels;
}

class Sweeps {
 public:
  virtual ~Sweeps() = default;

  /// Takes the stages over, the first time or when all were made anew. Waits.
  /// @param stages  of a cluster with those that wait for constraints
  /// @return        whether it can sweep them
  virtual bool take_over(const SolverData& data, std::span<const Stage> stages,
                         const StageRecords& records, cudaStream_t stream) = 0;

  /// Lists what to write into its own arrays, if it has any, so that they follow the records and
  /// the rows of vertices. A step may be running.
  /// @param data    with the changes that these follow
  /// @param stages  those that are open
  /// @param words   changes of records; appended to: changes of its arrays
  /// @return        false if it cannot: then it has to take over the stages anew
  [[nodiscard]] virtual bool follow(const SolverData& /*data*/, std::span<const Stage> /*stages*/,
                                    std::vector<WordChange>& /*words*/) {
    return true;
  }

  /// Makes room for so many vertices of a copy, if it keeps any, and for what it followed. While no
  /// step runs.
  /// @return  whether it works otherwise from now on: then a step has to be recorded again
  virtual bool make_room(std::size_t /*vertices*/, cudaStream_t /*stream*/) { return false; }

  /// Enqueues what follows rows of vertices that were written, before the next step.
  virtual void follow_rows(const VertexArrays& /*vertices*/, const Launch& /*launch*/) {}

  /// Where one of its arrays starts that changes between steps; null for others.
  [[nodiscard]] virtual std::uint32_t* start(DeviceArray /*array*/) const noexcept {
    return nullptr;
  }

  /// Enqueues all sweeps of one substep, with what tools do in them and with its correction. Called
  /// while a graph records the stream, so it neither waits nor allocates.
  /// @param substep  0 to substeps - 1
  virtual void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) = 0;

  /// Whether it does all substeps of a step at once, with all that belongs to them, and as many as
  /// StepInput says.
  /// @param changes_lengths  after the first substep
  [[nodiscard]] virtual bool takes_whole_step(const SweepArrays& /*arrays*/, int /*substeps*/,
                                              bool /*changes_lengths*/) const {
    return false;
  }

  /// Then: how often a vertex moves in a substep, which StepInput::moves_before counts.
  [[nodiscard]] virtual Index moves_in_substep(const SweepArrays& /*arrays*/) const { return 0; }

  /// Enqueues what is to come before the first of several such steps, between which nothing
  /// changes.
  virtual void begin_steps(const SweepArrays& /*arrays*/, const Launch& /*launch*/) {}

  /// Enqueues one of them.
  virtual void enqueue_step(const SweepArrays& /*arrays*/, const Launch& /*launch*/) {}

  /// Bytes on the device.
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept { return 0; }
};

/// One launch a stage.
std::unique_ptr<Sweeps> make_launched_sweeps(const SolverData& data);

/// Whether a cluster, if it can take the stages, is likely to be faster than launches.
[[nodiscard]] bool is_for_cluster(std::span<const Stage> stages) noexcept;

/// One launch a substep, of one cluster of blocks.
std::unique_ptr<Sweeps> make_cluster_sweeps(const SolverData& data);

/// One launch a substep, of as many blocks as the device has at once, for vertices.
std::unique_ptr<Sweeps> make_cooperative_sweeps(const SolverData& data);

}  // namespace pbdsurg::cuda
