// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// State of all copies on a device: in the order of places, as on the host.

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "buffer.cuh"
#include "solver/device_arrays.h"
#include "solver/solver_data.h"

namespace pbdsurg::cuda {

class StateBuffers {
 public:
  /// @param motion_room  at least, see motion_room()
  StateBuffers(const SolverData& data, std::size_t motion_room, cudaStream_t stream);

  [[nodiscard]] const DeviceState& arrays() const noexcept { return arrays_; }

  /// Copies particles, velocities and `falling` of a copy to the device.
  void upload(const SolverData& data, Index copy, cudaStream_t stream);

  /// Copies positions, velocities and `falling` of a copy to the host, whose inverse masses stay.
  /// Waits.
  void fetch(SolverData& data, Index copy, cudaStream_t stream);

  /// Reads positions of a copy at some places. Waits.
  /// @param out  [places.size()] m
  void read(Index copy, std::span<const Index> places, std::span<Eigen::Vector3f> out,
            cudaStream_t stream);

  /// Enqueues a read of how vertices of all copies move at some places. Waits only where there is
  /// no room for so many.
  void ask_for_motion(std::span<const Index> places, cudaStream_t stream);

  /// What was asked for last, of a copy. Waits.
  /// @param out  [places.size()]
  void collect_motion(Index copy, std::span<VertexMotion> out, cudaStream_t stream);

  /// How many vertices it can be asked about without a wait, over all copies: 1024, or the most
  /// there ever were.
  [[nodiscard]] std::size_t motion_room() const noexcept { return motion_room_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void reserve_motion(std::size_t size);

  /// Where a copy's part of an array starts.
  [[nodiscard]] std::size_t start(Index copy) const noexcept {
    return static_cast<std::size_t>(copy) * static_cast<std::size_t>(arrays_.count);
  }

  DeviceBuffer<Particle> particles_, previous_, flights_;
  DeviceBuffer<Velocity> velocities_;
  DeviceBuffer<float> falling_;
  DeviceBuffer<Index> vertex_of_place_, read_places_;
  PinnedBuffer<Vec3<float>> read_positions_;
  DeviceBuffer<Index> asked_places_;
  PinnedBuffer<VertexMotion> motion_;  // [copy][asked]
  std::size_t motion_room_ = 0;
  PinnedBuffer<Particle> fetched_particles_;
  DeviceState arrays_{};
  Index copy_count_;
};

}  // namespace pbdsurg::cuda
