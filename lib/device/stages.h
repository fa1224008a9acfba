// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A sweep as a device executes it: stage by stage, with constraints in that order.
///
/// A stage is what one launch projects: the phases of one level, kind and ordinal of all domains,
/// which share no vertex. A serial phase is cut into levels: a constraint's is one more than the
/// highest of those before it that share a vertex with it. Level by level, constraints meet in the
/// order of the phase wherever that matters, and so the bits are the same.

#include <cstdint>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_plan.h"

namespace pbdsurg::cuda {

/// Arrays on the device that change between steps.
enum class DeviceArray : std::uint32_t {
  distances,
  distance_damping,  ///< float[distance] s
  volumes,
  joints,
  neo_hookeans,
  fibres,
  membranes,
  strain_limits,
  bendings,
  stiff_links,
  tubes,
  particles,
  velocities,
  cluster,  ///< what sweeps on a cluster made of constraints
  vertex_blocks,
  pull_rows,
  spring_rows,
  volume_rows,
  hinge_rows,
  triangle_rows,
  fibre_rows,
  damped_spring_rows,
  damped_volume_rows,
  damped_triangle_rows,
  lane_of_place,     ///< of vertices in blocks
  stiffness_shares,  ///< of explicit steps
  tile_blocks,       ///< of one kernel for all sweeps: see VertexTiles
  tile_neighbors,
  coarse_vertices,  ///< of a coarse correction, as the following: see CoarseArrays
  coarse_own_counts,
  coarse_own_places,
  coarse_member_counts,
  coarse_member_places,
  coarse_member_shares,
};
inline constexpr int kDeviceArrayCount = 35;

/// One 4-byte word that changes.
struct WordChange {
  DeviceArray array;
  std::uint32_t word;
  std::uint32_t value;
};

/// What one launch projects: records [first, first + count) of its kind; or blocks of vertices that
/// it moves.
struct Stage {
  PhaseKind kind;
  Index first;
  Index count;
  /// Of a serial stage: levels [first_level, first_level + level_count) of all; else none.
  Index first_level = 0;
  Index level_count = 0;
  /// Of the records at its end, those that were of no constraint when the stage was made.
  Index spare = 0;
};

}  // namespace pbdsurg::cuda
