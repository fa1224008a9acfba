// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fills closed surfaces, on a device.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/solver/custom_constraints.h"

#include "cuda/buffer.cuh"
#include "lib/device/filling_sweep.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// The sets of custom constraints of a solver, all of them a Filling.
class FillingBuffers {
 public:
  /// Takes over what there is for a step, and enqueues the copy of its numbers. No step may be at
  /// work.
  void take_over(const SolverData& data, cudaStream_t stream);

  /// After the step that followed: tells the sets what has become of their contents.
  void give_back();

  /// Of those that have a wall.
  [[nodiscard]] Index wall_count() const noexcept;

  /// In the order of the sets.
  [[nodiscard]] std::span<const FillingArrays> arrays() const noexcept { return arrays_; }
  /// Changes with these.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  struct Buffers {
    std::shared_ptr<CustomConstraints> set;
    std::uint64_t version = 0;  // of the surface that was uploaded
    std::vector<Index> wall;    // places of its vertices, if there is one
    DeviceBuffer<Index> places, firsts, triangles_at, hole_ends, is_shared, pieces;
    DeviceBuffer<FillingTriangle> triangles;
    DeviceBuffer<Vec3<double>> ways, caps;
    DeviceBuffer<double> volumes;
    DeviceBuffer<Vec3<float>> thirds, gradients;
    DeviceBuffer<float> gives;
    // of a step: written here, read there
    PinnedBuffer<FillingInput> host_input;
    PinnedBuffer<FillingCopy> host_copies;
    DeviceBuffer<FillingInput> input;
    DeviceBuffer<FillingCopy> copies;
    PinnedBuffer<FillingState> results;
  };

  static FillingArrays upload_surface(const SolverData& data, Buffers& buffers,
                                      cudaStream_t stream);
  void upload_ties(const SolverData& data, cudaStream_t stream);
  static void upload_numbers(const SolverData& data, Buffers& buffers, cudaStream_t stream);

  std::vector<Buffers> buffers_;       // [set]
  std::vector<FillingArrays> arrays_;  // [set]
  std::size_t copy_count_ = 0;
  std::uint64_t revision_ = 0;
  std::uint64_t pieces_revision_ = 0;  // of the free pieces that ties are of
  bool has_ties_ = false;              // of all surfaces as they are
};

}  // namespace pbdsurg::cuda
