// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a device needs for tools that meet surfaces, and what these touch.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

class SurfaceBuffers {
 public:
  struct Room {
    Index vertices, meeters, half_spaces;  ///< of a copy, all of its meeters' half spaces together
    bool has_springs;                      ///< whether one is coupled

    bool operator==(const Room&) const = default;
  };

  /// Makes room, and follows triangles and firmness. Cost: O(triangles + vertices)
  /// when these have changed; waits then. No step may be at work.
  void take_over(const SolverData& data, const Room& room, cudaStream_t stream);

  /// After a part of a step: what tools touched, and what the next substep has to know of that.
  /// @param meeters  those that meet surfaces
  void take_contacts(Index copy, std::span<const Index> meeters, CopyState& state) const;

  [[nodiscard]] const SurfaceArrays& arrays() const noexcept { return arrays_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void make_room(const SolverData& data, const Room& room, cudaStream_t stream);
  void upload_triangles(const TissueSurface& surface, Index vertex_room, cudaStream_t stream);
  void upload_firmness(const ContactFirmness& firmness, cudaStream_t stream);

  Room room_{};
  std::optional<std::uint64_t> seen_surface_, seen_firmness_;  // revisions

  DeviceBuffer<Index> triangles_, thin_, around_, first_around_;
  DeviceBuffer<float> firmness_;
  DeviceBuffer<DeviceContact> found_, contacts_;
  DeviceBuffer<unsigned char> list_memory_;
  DeviceBuffer<Index> met_counts_, ends_, levels_, level_counts_, holds_, roots_;
  DeviceBuffer<HoldRange> holds_at_;
  DeviceBuffer<float> pushes_;
  DeviceBuffer<HandedForce> handed_;
  DeviceBuffer<Index> passed_;
  DeviceBuffer<DeviceStopped> stopped_;
  DeviceBuffer<ToolSpring> springs_;
  DeviceBuffer<RememberedContact> remembered_;
  DeviceBuffer<Index> remembered_ends_;
  PinnedBuffer<SurfaceContact> told_;
  PinnedBuffer<RememberedContact> told_remembered_;
  PinnedBuffer<Index> told_ends_;
  PinnedBuffer<ToolSpring> told_springs_;
  SurfaceArrays arrays_{};
};

}  // namespace pbdsurg::cuda
