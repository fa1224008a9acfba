// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// State of all copies on a device: in the order of places, as on the host, with room for more.

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "cuda/buffer.cuh"
#include "cuda/solver/word_kernels.h"
#include "lib/device/device_arrays.h"
#include "lib/solver/state/solver_state.h"

namespace pbdsurg::cuda {

class StateBuffers {
 public:
  /// With the room that options ask for; nothing is there yet.
  explicit StateBuffers(const SolverState& solver);

  [[nodiscard]] const DeviceState& arrays() const noexcept { return arrays_; }

  /// [vertex_count] of a copy
  [[nodiscard]] const Particle* particles(Index copy) const noexcept {
    return arrays_.particles + start(copy);
  }

  /// Makes room for all vertices that there are now. Where there is too little, all arrays are
  /// others then, with what was there; waits.
  void make_room(const SolverState& solver, cudaStream_t stream);

  /// Enqueues what Changes says of the state: of copies that were rewritten, of vertices that
  /// moved, and of forces and gravities. There must be room, and inverse masses that changed must
  /// be there. No such work may be under way. Cost: of copies, of the first forces and of gravities
  /// O(vertex_count) each, else proportional to what moved and to forces that are others.
  void take_over(const SolverState& solver, cudaStream_t stream);

  /// Copies positions, velocities, carries and BDF2's past of a copy to the host, whose inverse
  /// masses stay: of places taken over that are still there. Waits.
  void fetch(SolverState& solver, Index copy, cudaStream_t stream);

  /// Reads positions of a copy at some places. Waits.
  /// @param out  [places.size()] m
  void read(Index copy, std::span<const Index> places, std::span<Eigen::Vector3f> out,
            cudaStream_t stream);

  /// Enqueues a read of how vertices of all copies move at some places. Waits only where there is
  /// no room for so many: 1024 over all copies, or the most there ever were.
  void ask_for_motion(std::span<const Index> places, cudaStream_t stream);

  /// What was asked for last, of a copy. Waits.
  /// @param out  [places.size()]
  void collect_motion(Index copy, std::span<VertexMotion> out, cudaStream_t stream);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  /// [copy][capacity]
  struct Arrays {
    DeviceBuffer<Particle> particles, previous, displacements, flights;
    DeviceBuffer<Particle> end_ways, end_gives, end_shears;
    DeviceBuffer<Velocity> velocities, velocities_before;
    DeviceBuffer<Carry> carries;
    DeviceBuffer<Way> ways;
    DeviceBuffer<Load> forces;
    DeviceBuffer<Load> gravities;  // [capacity]
    DeviceBuffer<FixedPoint> fixed_points;
    DeviceBuffer<Index> vertex_of_place;  // [capacity]

    DeviceState reserve(const SolverState& solver, std::size_t capacity);
  };

  void upload(const CopyState& state, Index copy, cudaStream_t stream);
  void upload_gravities(const SolverState& solver, cudaStream_t stream);
  void upload_forces(const SolverState& solver, cudaStream_t stream);
  void upload_moved(const SolverState& solver, cudaStream_t stream);
  void reserve_motion(std::size_t size);

  /// Where a copy's part of an array starts.
  [[nodiscard]] std::size_t start(Index copy) const noexcept {
    return static_cast<std::size_t>(copy) * static_cast<std::size_t>(arrays_.capacity);
  }

  [[nodiscard]] std::size_t all_places(Index capacity) const noexcept {
    return static_cast<std::size_t>(copy_count_) * static_cast<std::size_t>(capacity);
  }

  Arrays buffers_;
  DeviceState arrays_{};
  Index copy_count_;
  std::size_t count_ = 0;            // of vertices, as taken over
  PinnedBuffer<MovedVertex> moved_;  // [copy][moved]
  PinnedBuffer<PlacedForce> placed_forces_;
  PinnedBuffer<Index> read_places_;
  PinnedBuffer<Vec3<float>> read_positions_;
  DeviceBuffer<Index> asked_places_;
  PinnedBuffer<VertexMotion> motion_;  // [copy][asked]
  std::size_t motion_room_ = 0;
  PinnedBuffer<Particle> fetched_particles_;
};

}  // namespace pbdsurg::cuda
