// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/step_start.h"

namespace pbdsurg::cuda {
namespace {

constexpr unsigned kThreads = 128;

template <class Record>
__device__ void copy_record(const Record* from, Record* to, std::size_t i) {
  static_assert(sizeof(Record) == sizeof(float4));
  if (to != nullptr) {
    reinterpret_cast<float4*>(to)[i] = reinterpret_cast<const float4*>(from)[i];
  }
}

__global__ void __launch_bounds__(kThreads)
    copy_state(KeptState from, KeptState to, std::size_t count) {
  const std::size_t i = std::size_t{blockIdx.x} * kThreads + threadIdx.x;
  if (i < count) {
    copy_record(from.particles, to.particles, i);
    copy_record(from.velocities, to.velocities, i);
    copy_record(from.carries, to.carries, i);
    copy_record(from.ways, to.ways, i);
    copy_record(from.velocities_before, to.velocities_before, i);
  }
}

void copy(const KeptState& from, const KeptState& to, const DeviceState& state, std::size_t copies,
          cudaStream_t stream) {
  const std::size_t count = copies * static_cast<std::size_t>(state.capacity);
  if (count > 0) {
    copy_state<<<static_cast<unsigned>((count + kThreads - 1) / kThreads), kThreads, 0, stream>>>(
        from, to, count);
    PBDSURG_CUDA_CHECK(cudaGetLastError());
  }
}

KeptState kept_part(const DeviceState& state) {
  return {state.particles, state.velocities, state.carries, state.ways, state.velocities_before};
}

}  // namespace

KeptState StepStart::make_room(const DeviceState& state, std::size_t copies) {
  const std::size_t count = copies * static_cast<std::size_t>(state.capacity);
  return {particles_.reserve(count), velocities_.reserve(count), carries_.reserve(count),
          state.ways == nullptr ? nullptr : ways_.reserve(count),
          state.ways == nullptr ? nullptr : velocities_before_.reserve(count)};
}

std::size_t StepStart::memory_bytes() const noexcept {
  return particles_.memory_bytes() + velocities_.memory_bytes() + carries_.memory_bytes() +
         ways_.memory_bytes() + velocities_before_.memory_bytes();
}

void keep_state(const DeviceState& state, const KeptState& to, std::size_t copies,
                cudaStream_t stream) {
  copy(kept_part(state), to, state, copies, stream);
}

void bring_back_state(const DeviceState& state, const KeptState& from, std::size_t copies,
                      cudaStream_t stream) {
  copy(from, kept_part(state), state, copies, stream);
}

}  // namespace pbdsurg::cuda
