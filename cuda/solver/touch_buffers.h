// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a device needs for bodies that meet each other, and what these touch.

#include <cstddef>
#include <cstdint>
#include <optional>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"
#include "lib/device/touch_lists.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

class TouchBuffers {
 public:
  /// Makes room, and follows bodies. Cost: O(n log n) of their vertices, triangles and edges when
  /// these have changed; waits then. No step may be at work.
  /// @param vertex_room  at least as many as there are
  void take_over(const SolverData& data, Index vertex_room, cudaStream_t stream);

  /// After a part of a step: what bodies touched, and what the next substep has to know of that.
  void take_contacts(Index copy, CopyState& state) const;

  /// Empty while no bodies meet.
  [[nodiscard]] const TouchArrays& arrays() const noexcept { return arrays_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void upload(const ContactBodies& bodies, cudaStream_t stream);
  void make_room(const SolverData& data, Index vertex_room, cudaStream_t stream);

  std::optional<std::uint64_t> seen_;  // revision
  Index vertex_room_ = 0, copy_count_ = 0;

  DeviceBuffer<TouchVertex> vertices_;
  DeviceBuffer<TouchBody> bodies_;
  DeviceBuffer<TouchPair> pairs_;
  DeviceBuffer<TouchTriangle> triangles_;
  DeviceBuffer<CrossingEdge> edges_;
  DeviceBuffer<Index> edge_bodies_, edge_groups_;
  DeviceBuffer<std::uint8_t> joined_;
  DeviceBuffer<Vec3<float>> rest_;
  DeviceBuffer<Index> first_neighbors_, neighbors_;
  DeviceBuffer<GroupBox> boxes_;
  DeviceBuffer<TouchSearchState> searches_;
  DeviceBuffer<Vec3<float>> seen_positions_;
  DeviceBuffer<std::uint8_t> is_met_;
  DeviceBuffer<std::uint64_t> crossings_;
  DeviceBuffer<TissueTouch> found_, contacts_;
  DeviceBuffer<Index> near_, last_holds_, order_, counts_, level_counts_, holds_, roots_, befores_,
      levels_, remembered_counts_;
  DeviceBuffer<HoldRange> holds_at_;
  DeviceBuffer<float> pushes_;
  DeviceBuffer<RememberedTouch> remembered_;
  PinnedBuffer<TissueTouch> told_;
  PinnedBuffer<RememberedTouch> told_remembered_;
  PinnedBuffer<Index> told_counts_;
  TouchArrays arrays_{};
};

}  // namespace pbdsurg::cuda
