// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a step started from: kept where blocks wait for each other, which may have to give up.

#include <cstddef>

#include "cuda/buffer.cuh"
#include "lib/device/device_arrays.h"

namespace pbdsurg::cuda {

/// The part of DeviceState that outlives steps.
struct KeptState {
  Particle* particles = nullptr;  ///< [copy][capacity], as the following
  Velocity* velocities = nullptr;
  Carry* carries = nullptr;
  Way* ways = nullptr;                    ///< of BDF2, else null
  Velocity* velocities_before = nullptr;  ///< likewise

  bool operator==(const KeptState&) const = default;
};

class StepStart {
 public:
  /// Makes room for a state of the vertex-block method.
  KeptState make_room(const DeviceState& state, std::size_t copies);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  DeviceBuffer<Particle> particles_;
  DeviceBuffer<Velocity> velocities_, velocities_before_;
  DeviceBuffer<Carry> carries_;
  DeviceBuffer<Way> ways_;
};

/// Enqueues a copy of that part.
void keep_state(const DeviceState& state, const KeptState& to, std::size_t copies,
                cudaStream_t stream);

/// And the way back.
void bring_back_state(const DeviceState& state, const KeptState& from, std::size_t copies,
                      cudaStream_t stream);

}  // namespace pbdsurg::cuda
