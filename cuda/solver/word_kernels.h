// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Small changes of device memory, and small parts of it.

#include <cuda_runtime_api.h>

#include "pbdsurg/core/vec3.h"

#include "solver/particle.h"
#include "solver/stages.h"

namespace pbdsurg::cuda {

/// Where the arrays that change start.
struct ArrayStarts {
  std::uint32_t* starts[kDeviceArrayCount];
  /// Words from one copy's part of an array to the next; zero for arrays that copies share.
  std::size_t strides[kDeviceArrayCount];
  Index copy_count;
};

/// @throws DeviceError  if this library has no code for the current device
void check_device_code();

/// Writes words, for all copies; those listed twice must be alike.
/// @param changes  [count] on the device
void write_words(const ArrayStarts& arrays, const WordChange* changes, Index count,
                 cudaStream_t stream);

/// Copies the positions at some places.
/// @param places  [count] on the device
/// @param out     [count] m
void gather_positions(const Particle* particles, const Index* places, Vec3<float>* out, Index count,
                      cudaStream_t stream);

/// How vertices of all copies move.
struct MotionArrays {
  const Particle* particles;   ///< [copy][place_count]
  const Velocity* velocities;  ///< likewise
  const float* falling;        ///< likewise, or null for none: zero then
  Index place_count, copy_count;
};

/// Copies how vertices move at some places.
/// @param places  [count] on the device
/// @param out     [copy][count]
void gather_motion(const MotionArrays& arrays, const Index* places, VertexMotion* out, Index count,
                   cudaStream_t stream);

}  // namespace pbdsurg::cuda
