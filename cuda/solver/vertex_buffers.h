// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The rows of the vertex-block method on a device. Empty for other methods.

#include <cstddef>
#include <cstdint>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"
#include "lib/device/stages.h"
#include "lib/device/vertex_counts.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// Arrays have room for more where it is expected: what outgrows it moves, and nothing else does.
class VertexBuffers {
 public:
  /// Copies all to the device. Waits.
  /// @param has_grown  whether edits brought vertices before: more are expected
  void upload(const SolverData& data, bool has_grown, cudaStream_t stream);

  /// Notes how much there is after an edit, whose words are written later. A step may be running.
  void follow(const SolverData& data) noexcept { counts_.include(VertexCounts(data)); }

  /// Before a step: makes room for what was noted, and enqueues that nothing guards vertices. Where
  /// there is too little, some arrays are others then, with what was there; waits.
  void make_room(const SolverData& data, cudaStream_t stream);

  [[nodiscard]] const VertexArrays& arrays() const noexcept { return arrays_; }

  /// Where an array that edits change starts; null for others.
  [[nodiscard]] std::uint32_t* start(DeviceArray array) const noexcept;

  /// Words from one copy's part of such an array to the next; zero where copies share it.
  [[nodiscard]] std::size_t stride(DeviceArray array) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void enlarge(const SolverData& data, cudaStream_t stream);
  void point(const SolverData& data);
  [[nodiscard]] std::size_t lane_room() const {
    return room_.blocks * static_cast<std::size_t>(kBlockLanes);
  }

  DeviceBuffer<VertexBlock> blocks_;
  DeviceBuffer<PullRow> pulls_;
  DeviceBuffer<SpringRow> springs_;
  DeviceBuffer<VolumeRow> volumes_;
  DeviceBuffer<HingeRow> hinges_;
  DeviceBuffer<TriangleRow> triangles_;
  DeviceBuffer<FibreRow> fibres_;
  DeviceBuffer<DampedRow> damped_springs_, damped_volumes_, damped_triangles_;
  DeviceBuffer<Index> holds_;
  DeviceBuffer<float> guards_;
  DeviceBuffer<Index> lane_of_place_;
  DeviceBuffer<float> shares_;
  VertexCounts counts_, room_;
  VertexArrays arrays_{};
};

/// The lists of FreePieces on a device.
class FreePieceBuffers {
 public:
  /// Copies them, if they are others than before. Waits then.
  /// @param vertex_room  at least as many as there are
  void take_over(const SolverData& data, Index vertex_room, cudaStream_t stream);

  [[nodiscard]] const FreePieceArrays& arrays() const noexcept { return arrays_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return firsts_.memory_bytes() + places_.memory_bytes() + groups_.memory_bytes() +
           meeting_.memory_bytes() + pieces_.memory_bytes() + touched_.memory_bytes() +
           sums_.memory_bytes();
  }

 private:
  void upload(const PieceLists& pieces, Index vertex_room, cudaStream_t stream);

  DeviceBuffer<Index> firsts_, places_, groups_, meeting_, pieces_, touched_;
  DeviceBuffer<MomentumSums> sums_;
  std::uint64_t revision_ = 0;  // without pieces
  Index vertex_room_ = 0;
  FreePieceArrays arrays_{};
};

}  // namespace pbdsurg::cuda
