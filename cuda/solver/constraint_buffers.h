// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints on a device, in the order of the stages.

#include <cstddef>
#include <tuple>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"
#include "lib/device/stage_plan.h"

namespace pbdsurg::cuda {

class ConstraintBuffers {
 public:
  /// Copies all to the device. Waits.
  /// @param remembers   whether multipliers of projections pass from sweep to sweep
  /// @param copy_count  how many copies of the scene have such multipliers
  void upload(const StageRecords& records, bool remembers, Index copy_count, cudaStream_t stream);

  [[nodiscard]] const ConstraintArrays& arrays() const noexcept { return arrays_; }

  /// Where an array that edits change starts; null for others.
  [[nodiscard]] std::uint32_t* start(DeviceArray array) const noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  template <class... Constraints>
  using Buffers = std::tuple<DeviceBuffer<Record<Constraints>>...>;

  ForAllConstraints<Buffers> records_;
  DeviceBuffer<float> distance_damping_;
  DeviceBuffer<JointRecord> joints_;
  DeviceBuffer<TubeRecord> tubes_;
  DeviceBuffer<Index> level_ends_;
  DeviceBuffer<float> multipliers_;  // of all kinds
  ConstraintArrays arrays_{};
};

}  // namespace pbdsurg::cuda
