// SPDX-License-Identifier: Apache-2.0
#include "solver/constraint_buffers.h"

#include "pbdsurg/constraints/neo_hookean.h"

namespace pbdsurg::cuda {

void ConstraintBuffers::upload(const StageRecords& records, bool remembers, Index copy_count,
                               cudaStream_t stream) {
  constexpr std::size_t kPerJoint = 7;  // six edges and the volume
  const std::size_t distances = records.distances.size();
  const std::size_t volumes = records.volumes.size();
  const std::size_t joints = kPerJoint * records.joints.size();
  const std::size_t neo_hookeans =
      NeoHookeanConstraint::kMultiplierCount * records.neo_hookeans.size();
  const std::size_t before_bendings = distances + volumes + joints + neo_hookeans;
  const std::size_t multiplier_count = remembers ? before_bendings + records.bendings.size() : 0;
  float* const multipliers =
      multipliers_.reserve(static_cast<std::size_t>(copy_count) * multiplier_count);
  const auto part = [&](std::size_t first) { return remembers ? multipliers + first : nullptr; };
  arrays_ = {distances_.upload(records.distances, stream),
             distance_damping_.upload(records.distance_damping, stream),
             part(0),
             volumes_.upload(records.volumes, stream),
             part(distances),
             joints_.upload(records.joints, stream),
             part(distances + volumes),
             neo_hookeans_.upload(records.neo_hookeans, stream),
             part(distances + volumes + joints),
             strain_limits_.upload(records.strain_limits, stream),
             bendings_.upload(records.bendings, stream),
             part(before_bendings),
             tubes_.upload(records.tubes, stream),
             level_ends_.upload(records.level_ends, stream),
             static_cast<Index>(records.distances.size()),
             static_cast<Index>(records.volumes.size()),
             static_cast<Index>(records.joints.size()),
             static_cast<Index>(records.neo_hookeans.size()),
             static_cast<Index>(records.bendings.size()),
             static_cast<Index>(records.tubes.size()),
             multiplier_count};
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the caller's records may go
}

std::uint32_t* ConstraintBuffers::start(DeviceArray array) const noexcept {
  const auto words = [](auto* records) { return reinterpret_cast<std::uint32_t*>(records); };
  switch (array) {
    case DeviceArray::distances:
      return words(distances_.get());
    case DeviceArray::distance_damping:
      return words(distance_damping_.get());
    case DeviceArray::volumes:
      return words(volumes_.get());
    case DeviceArray::joints:
      return words(joints_.get());
    case DeviceArray::neo_hookeans:
      return words(neo_hookeans_.get());
    case DeviceArray::strain_limits:
      return words(strain_limits_.get());
    case DeviceArray::bendings:
      return words(bendings_.get());
    case DeviceArray::tubes:
      return words(tubes_.get());
    case DeviceArray::particles:
    case DeviceArray::velocities:
    case DeviceArray::cluster:
    case DeviceArray::vertex_blocks:
    case DeviceArray::pull_rows:
    case DeviceArray::spring_rows:
    case DeviceArray::volume_rows:
    case DeviceArray::hinge_rows:
    case DeviceArray::damped_spring_rows:
    case DeviceArray::damped_volume_rows:
    case DeviceArray::damped_hinge_rows:
      break;
  }
  return nullptr;
}

std::size_t ConstraintBuffers::memory_bytes() const noexcept {
  return distances_.memory_bytes() + distance_damping_.memory_bytes() + volumes_.memory_bytes() +
         joints_.memory_bytes() + neo_hookeans_.memory_bytes() + strain_limits_.memory_bytes() +
         bendings_.memory_bytes() + tubes_.memory_bytes() + level_ends_.memory_bytes() +
         multipliers_.memory_bytes();
}

}  // namespace pbdsurg::cuda
