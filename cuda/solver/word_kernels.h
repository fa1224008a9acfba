// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Small changes of device memory, and small parts of it.

#include <cuda_runtime_api.h>

#include "pbdsurg/base/vec3.h"

#include "lib/device/device_arrays.h"
#include "lib/device/stages.h"
#include "lib/solver/state/particle.h"

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
/// @param changes  [count] that the device reads; they stay until it has
void write_words(const ArrayStarts& arrays, const WordChange* changes, Index count,
                 cudaStream_t stream);

/// Copies the positions at some places.
/// @param places  [count] on the device
/// @param out     [count] m
void gather_positions(const Particle* particles, const Index* places, Vec3<float>* out, Index count,
                      cudaStream_t stream);

/// Copies how vertices of all copies move at some places.
/// @param places  [count] on the device
/// @param out     [copy][count]
void gather_motion(const DeviceState& state, Index copy_count, const Index* places,
                   VertexMotion* out, Index count, cudaStream_t stream);

/// A vertex that an edit brought, or set in motion again.
struct MovedVertex {
  VertexMotion motion;
  Load force, gravity;  ///< of no account where the state has none
  float w;              ///< 1/kg
  Index place;
  Index vertex;  ///< of the scene
};

/// Writes vertices of all copies to their places.
/// @param moved  [copy][count]
void write_vertices(const DeviceState& state, Index copy_count, const MovedVertex* moved,
                    Index count, cudaStream_t stream);

/// A force that is another.
struct PlacedForce {
  Load force;
  Index copy, place;
};

/// Writes forces to their places; there is room for them. Those listed twice must be alike.
/// @param placed  [count] that the device reads; they stay until it has
void write_forces(const DeviceState& state, const PlacedForce* placed, Index count,
                  cudaStream_t stream);

}  // namespace pbdsurg::cuda
