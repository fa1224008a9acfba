// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The coarse correction on a device. Empty where there is none.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"
#include "lib/device/stages.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

class CoarseBuffers {
 public:
  /// Copies the space to the device, with room for more. Waits.
  /// @param capacity  vertices of a copy that the state has room for
  void upload(const SolverData& data, std::size_t capacity, cudaStream_t stream);

  /// Lists what changed in the space since the last call; where there is no room for it, uploads
  /// all. While no step runs.
  /// @param words  appended to
  void follow(SolverData& data, std::size_t capacity, std::vector<WordChange>& words,
              cudaStream_t stream);

  /// Before a step: says how many constraints of many neighbours there are, and makes room for
  /// them, or for kMostWides of them.
  void set_wides(Index count);

  /// Enqueues it. After an edit: of vertices that no block has any more nobody finds residuals.
  void clear_residuals(cudaStream_t stream);

  [[nodiscard]] const CoarseArrays& arrays() const noexcept { return arrays_; }

  /// Where an array that edits change starts; null for others.
  [[nodiscard]] std::uint32_t* start(DeviceArray array) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  DeviceBuffer<CoarseVertex> vertices_;
  DeviceBuffer<Index> own_counts_, own_places_, member_counts_, member_places_, pieces_;
  DeviceBuffer<CoarseShares> member_shares_;
  DeviceBuffer<float> stiffnesses_, modes_, numbers_;
  DeviceBuffer<Particle> residuals_, moves_;
  DeviceBuffer<NodeSums> part_sums_, sums_;
  DeviceBuffer<double> part_gains_, gains_before_;
  DeviceBuffer<AffineNumbers> moves_of_nodes_;
  DeviceBuffer<Turn> turns_;
  DeviceBuffer<float> amplitudes_, hold_modes_;
  DeviceBuffer<double> hold_parts_;
  DeviceBuffer<CoarseHolds> holds_;
  DeviceBuffer<CoarseShares> hold_sums_;
  DeviceBuffer<Index> hold_counts_;
  DeviceBuffer<AffineNumbers> wide_sums_;
  DeviceBuffer<float> wide_compliances_;
  std::size_t copy_count_ = 0;
  CoarseArrays arrays_{};
};

}  // namespace pbdsurg::cuda
