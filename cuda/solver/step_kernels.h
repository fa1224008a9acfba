// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The kernels of a step, compiled twice from one source (all_kernels.cuh): strict, with the bits
/// of the serial backend, and fast. Each function enqueues one kernel, if it does not say
/// otherwise.

#include <cstdint>

#include <cuda_runtime_api.h>

#include "lib/device/cluster_layout.h"
#include "lib/device/device_arrays.h"
#include "lib/device/filling_sweep.h"
#include "lib/device/stages.h"

namespace pbdsurg::cuda {

class SideStream;

/// How to launch.
struct Launch {
  cudaStream_t stream;
  /// Whether a kernel may be brought to the device while the one before it is at work. Kernels then
  /// wait by themselves for what they need. What comes before must be a kernel, too.
  bool overlaps;
  Index copies = 1;  ///< of the scene, each with as many blocks: the second index of a block
  const SideStream* side = nullptr;  ///< for side_by_side(); without, one follows the other
};

/// How a stage is projected.
struct Projection {
  ProjectionMode mode;
  bool is_damped;
  bool takes_multipliers;   ///< of the sweep before; else they are zero
  bool leaves_multipliers;  ///< to the next sweep
};

/// One of the sweeps of the vertex-block method.
struct VertexSweep {
  Index substep;     ///< 0 to substeps - 1
  float relaxation;  ///< see relaxation_of()
  bool has_tools;    ///< whether any touch or hold something
  bool holds_only;   ///< whether only those vertices move that tools touch or hold
};

/// Threads of a block that moves vertices: a colour is small, see kStageThreads.
inline constexpr Index kBlockThreads = 64;

/// How much of a step of the vertex-block method one kernel takes.
enum class Reach : std::uint8_t {
  substep,          ///< its sweeps
  held_substep,     ///< likewise, with what tools do in them
  gripped_substep,  ///< and jaws that hold with a limit
  met_substep,      ///< and bodies that meet each other
  step,  ///< StepInput::substep_count substeps, from the state at the start to that at the end
};

/// Sweeps of a substep of the vertex-block method, or all of a step.
struct VertexSweeps {
  Reach reach;
  Index substep;          ///< 0 to substeps - 1
  Index count;            ///< of sweeps in a substep
  Index first, end;       ///< which of these; of a step all
  float over_relaxation;  ///< see relaxation_of()
  Index block_count;      ///< of threads, for each copy: all copies' are on the device at once
};

/// How to launch all substeps of a part of an explicit step, StepInput::substep_count of them.
struct ExplicitSubsteps {
  Index block_count;  ///< as in VertexSweeps
  bool stays;         ///< whether these have a warp for each tile
};

/// What a kernel that sweeps by a cluster knows: each what those before do, too.
enum class ClusterTissue : std::uint8_t {
  springs,  ///< distances, volumes, strain limits
  solids,   ///< Neo-Hookean tetrahedra, hinges
  all,      ///< triangles, fibres
};

/// Which of the kernels that sweep by a cluster.
struct ClusterKind {
  ProjectionMode mode;
  bool is_damped;
  ClusterTissue tissue;
  Index thread_count;     ///< of a block, that project: kFewClusterThreads or kManyClusterThreads
  bool has_extra_phases;  ///< whether bodies meet each other, or jaws hold with a limit
};

struct StepKernels {
  /// What the code that the current device runs was compiled for, 90 of compute capability 9.0.
  int (*code_architecture)();

  /// Ends a substep, begins one with a prediction, or both; with what BDF2 remembers of it.
  void (*advance)(const DeviceState&, const StepInput*, bool ends, bool begins, const Launch&);

  /// Finds the contacts of a substep, at most the contact capacity a tool.
  void (*find_contacts)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                        const Launch&);

  // Of tools that meet surfaces, likewise.

  /// @param has_pushers  whether find_contacts() has counted others
  void (*find_surface_contacts)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                                bool has_pushers, const Launch&);
  /// Of vertex blocks, before the sweeps: how stiffly contacts are met.
  void (*begin_surface_contacts)(const DeviceState&, const VertexArrays&, const ToolArrays&,
                                 StepInput*, Index substep, const Launch&);
  /// After a sweep of projections; or, after all of vertex blocks, of what is still inside of
  /// tools.
  void (*project_surface_contacts)(const DeviceState&, const ToolArrays&, bool settles,
                                   const Launch&);
  /// After a sweep of vertex blocks, once pieces are balanced: takes over the forces of contacts,
  /// and turns their planes.
  void (*answer_surface_contacts)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                                  const Launch&);
  /// Once all else has moved vertices.
  void (*stop_passing)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                       const Launch&);
  /// After all sweeps: for the next substep and, if it tells, for the host.
  void (*begin_grips)(const DeviceState&, StepInput*, Index substep, bool slides, const Launch&);
  void (*answer_grips)(const DeviceState&, const VertexArrays&, const ToolArrays&, StepInput*,
                       Index substep, const Launch&);
  void (*project_grips)(const DeviceState&, StepInput*, Index substep, const Launch&);
  void (*end_grips)(const DeviceState&, const ToolArrays&, StepInput*, Index substep, bool tells,
                    const Launch&);
  void (*remember_surface_contacts)(const DeviceState&, const ToolArrays&, StepInput*,
                                    Index substep, bool tells, const Launch&);
  /// See ease_contacts().
  void (*ease_surface_contacts)(const DeviceState&, const ToolArrays&, StepInput*, const Launch&);

  // Of free pieces that contacts touch, with surfaces or between bodies; nothing without pieces.

  /// After a sweep of vertex blocks.
  void (*balance_pieces)(const DeviceState&, const FreePieceArrays&, const ToolArrays&, StepInput*,
                         const Launch&);
  /// After all sweeps: which of them keep their momentum together, as bodies have pushed them.
  void (*join_pieces)(const DeviceState&, const FreePieceArrays&, const ToolArrays&, const Launch&);
  /// Before contacts are eased.
  void (*ease_pieces)(const DeviceState&, const FreePieceArrays&, const ToolArrays&, StepInput*,
                      Index substep, const Launch&);

  // Of bodies that meet each other, likewise.

  void (*find_touches)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                       const Launch&);
  /// Of vertex blocks, before the sweeps: how stiffly they meet.
  void (*begin_touches)(const DeviceState&, const VertexArrays&, const ToolArrays&, StepInput*,
                        Index substep, const Launch&);
  /// After a sweep of projections; or, after all of vertex blocks, what is still too near.
  void (*project_touches)(const DeviceState&, const ToolArrays&, bool settles, const Launch&);
  /// After a sweep of vertex blocks, which they answer; or where vertices moved without one.
  void (*see_touches)(const DeviceState&, const ToolArrays&, StepInput*, bool answers,
                      const Launch&);
  void (*remember_touches)(const DeviceState&, const ToolArrays&, StepInput*, bool tells,
                           const Launch&);
  void (*ease_touches)(const DeviceState&, const ToolArrays&, StepInput*, const Launch&);

  void (*project)(const Stage&, const Projection&, const DeviceState&, const ConstraintArrays&,
                  const StepInput*, const Launch&);

  /// @param is_first  of the sweeps of a substep
  void (*project_attachments)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                              bool is_first, const Launch&);
  void (*project_contacts)(const DeviceState&, const ToolArrays&, const StepInput*, const Launch&);

  /// @param is_first  whether a substep begins: see cuda::project_filling()
  void (*project_filling)(const FillingArrays&, const DeviceState&, const VertexArrays&,
                          const FreePieceArrays&, const StepInput*, bool is_first, const Launch&);

  /// Before the sweeps of a substep: damping, and what tools touch and hold, if there are any.
  void (*prepare_vertices)(const DeviceState&, const VertexArrays&, const ToolArrays&, StepInput*,
                           bool has_tools, const Launch&);

  /// After these, before the sweeps: finds how vertices give way to their stiff links.
  void (*find_loose_ends)(Index substep, bool has_tools, const DeviceState&,
                          const ConstraintArrays&, const VertexArrays&, const ToolArrays&,
                          StepInput*, const Launch&);

  /// From these, finds the forces of one stage of stiff links.
  void (*begin_joints)(const Stage&, const DeviceState&, const ConstraintArrays&, const StepInput*,
                       const Launch&);

  /// With find_loose_ends(), likewise: how a wall gives way to what fills it. Then
  /// project_filling() finds its pressure.
  void (*find_wall_ends)(const FillingArrays&, Index substep, bool has_tools, const DeviceState&,
                         const VertexArrays&, const ToolArrays&, StepInput*, const Launch&);

  /// Moves the vertices of one stage, with what tools do to them.
  void (*solve_vertices)(const Stage&, const VertexSweep&, const DeviceState&, const VertexArrays&,
                         const ToolArrays&, StepInput*, const Launch&);

  /// Of explicit steps: moves all vertices, with what tools do to them.
  void (*push_vertices)(const DeviceState&, const VertexArrays&, const ToolArrays&, StepInput*,
                        Index substep, bool has_tools, const Launch&);

  /// Likewise: finds the stiffest vertex after a part of a step.
  void (*measure_stiffness)(const DeviceState&, const VertexArrays&, StepInput*, const Launch&);

  /// Makes ready for sweep_vertices(). Enqueues nothing.
  /// @return  how many blocks of threads the current device runs at a time; 0 if it cannot
  Index (*prepare_sweep_of_vertices)(const TileArrays&);

  /// Makes records of the rows of some blocks.
  /// @param which  [count > 0] these, or null for the first ones
  void (*pack_rows)(const VertexArrays&, const TileArrays&, const Index* which, Index count,
                    const Launch&);

  /// Likewise of all, where no row has come or gone, but damping has changed their numbers.
  void (*pack_numbers)(const VertexArrays&, const TileArrays&, const Launch&);

  /// Moves all vertices, colour by colour and sweep by sweep. Points count the sweeps of a substep
  /// before.
  /// @param Mailboxes  of a step: as the last one or fill_mailboxes() left them
  void (*sweep_vertices)(const VertexSweeps&, const VertexColors&, const DeviceState&,
                         const VertexArrays&, const TileArrays&, const ToolArrays&,
                         const Mailboxes&, StepInput*, const Launch&);

  /// Before a step that one kernel takes, unless the step before was such a step and nothing has
  /// changed since.
  void (*fill_mailboxes)(const DeviceState&, const Mailboxes&, const StepInput*, const Launch&);

  /// Makes ready for step_explicitly(). Enqueues nothing.
  /// @return  as prepare_sweep_of_vertices()
  Index (*prepare_explicit_step)(const TileArrays&);

  /// All substeps of a part of an explicit step in which no tool touches or holds anything, from
  /// the state at its start to that at its end. See sweep_vertices() for mailboxes.
  void (*step_explicitly)(const ExplicitSubsteps&, const DeviceState&, const VertexArrays&,
                          const TileArrays&, const Mailboxes&, StepInput*, const Launch&);

  // Of a coarse correction, between two sweeps of a substep: finds residuals, moves vertices by
  // modes, finds residuals again, and turns back what went too far. See coarse_correction.h. The
  // last two functions enqueue a few kernels each.

  /// By rows of vertices.
  void (*find_residuals)(const DeviceState&, const VertexArrays&, const CoarseArrays&,
                         const StepInput*, bool has_tools, const Launch&);
  /// Makes ready for find_residuals_by_tiles(). Enqueues nothing.
  /// @return  as prepare_sweep_of_vertices()
  Index (*prepare_residuals)(const TileArrays&);
  /// By records of tiles.
  void (*find_residuals_by_tiles)(const DeviceState&, const VertexArrays&, const TileArrays&,
                                  const CoarseArrays&, StepInput*, bool has_tools, const Launch&);
  /// After these, of a wall: what a correction keeps to, or that it leaves its vertices out.
  /// @param wide  below CoarseArrays::wide_count
  void (*sum_wall)(const FillingArrays&, Index wide, const CoarseArrays&, const Launch&);
  void (*leave_out_wall)(const FillingArrays&, const VertexArrays&, const CoarseArrays&,
                         const Launch&);
  void (*move_by_modes)(const DeviceState&, const CoarseArrays&, const StepInput*, bool has_tools,
                        const Launch&);
  void (*turn_back_moves)(const DeviceState&, const CoarseArrays&, const StepInput*, const Launch&);

  /// Makes ready for sweep_cluster(). Enqueues nothing.
  /// @return  how many such clusters the current device runs at a time
  Index (*prepare_cluster)(const ClusterKind&, const ClusterArrays&);

  /// All sweeps of a substep, with what tools do in them.
  void (*sweep_cluster)(const ClusterKind&, const ClusterArrays&, const DeviceState&,
                        const ToolArrays&, StepInput*, const ClusterSweep&, const Launch&);

  /// After the sweeps, of pieces that no tool touches or holds.
  void (*keep_momentum)(const DeviceState&, const VertexArrays&, const FreePieceArrays&,
                        const ToolArrays&, bool has_tools, const Launch&);

  /// Adds a substep's share to the forces and torques on tools.
  void (*collect_forces)(const DeviceState&, const ToolArrays&, StepInput*, Index substep,
                         const Launch&);

  /// Of BDF2, at the end of a substep: what tools push does not spring back. There are pushers.
  void (*ease_contacts)(const DeviceState&, const ToolArrays&, const StepInput*, const Launch&);

  /// Of BDF2, between the first substep and the second: their numbers are not the same.
  void (*take_later_lengths)(StepInput*, const Launch&);

  void (*report)(const DeviceState&, const ConstraintArrays&, StepInput*, const StepOutput&,
                 const Launch&);
};

/// @throws DeviceError  from their functions, if a kernel cannot be launched
extern const StepKernels strict_kernels;
extern const StepKernels fast_kernels;

}  // namespace pbdsurg::cuda
