// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/constraint_buffers.h"

#include <type_traits>

#include "lib/device/record_table.h"

namespace pbdsurg::cuda {

void ConstraintBuffers::upload(const StageRecords& records, bool remembers, Index copy_count,
                               cudaStream_t stream) {
  constexpr std::size_t kPerJoint = 7;  // six edges and the volume
  arrays_ = {};
  const std::size_t of_joints = remembers ? kPerJoint * records.joints.size() : 0;
  const auto multipliers_of = [&]<class Constraint>(const std::vector<Record<Constraint>>& list) {
    constexpr bool kIsJoint = std::is_same_v<Constraint, StiffLinkConstraint>;  // see begin_joints
    const bool is_kept = kIsJoint || (remembers && KindOf<Constraint>::kHasCompliance);
    return is_kept ? Constraint::kMultiplierCount * list.size() : 0;
  };
  arrays_.multiplier_count = of_joints;
  records.for_each_list(
      [&](const auto& list) { arrays_.multiplier_count += multipliers_of(list); });
  float* next =
      multipliers_.reserve(static_cast<std::size_t>(copy_count) * arrays_.multiplier_count);
  const auto take_multipliers = [&](std::size_t count) {
    float* const taken = next;
    next += count;
    return count > 0 ? taken : nullptr;
  };
  records.for_each_list([&]<class Constraint>(const std::vector<Record<Constraint>>& list) {
    KindArrays<Constraint>& kind = arrays_;
    kind.records = std::get<DeviceBuffer<Record<Constraint>>>(records_).upload(list, stream);
    kind.count = static_cast<Index>(list.size());
    kind.multipliers = take_multipliers(multipliers_of(list));
  });
  arrays_.distance_damping = distance_damping_.upload(records.distance_damping, stream);
  arrays_.joints = joints_.upload(records.joints, stream);
  arrays_.joint_multipliers = take_multipliers(of_joints);
  arrays_.joint_count = static_cast<Index>(records.joints.size());
  arrays_.tubes = tubes_.upload(records.tubes, stream);
  arrays_.tube_count = static_cast<Index>(records.tubes.size());
  arrays_.level_ends = level_ends_.upload(records.level_ends, stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the caller's records may go
}

std::uint32_t* ConstraintBuffers::start(DeviceArray array) const noexcept {
  const auto words = [](auto* records) { return reinterpret_cast<std::uint32_t*>(records); };
  if (array == DeviceArray::distance_damping) {
    return words(distance_damping_.get());
  }
  if (array == DeviceArray::joints) {
    return words(joints_.get());
  }
  if (array == DeviceArray::tubes) {
    return words(tubes_.get());
  }
  std::uint32_t* found = nullptr;
  const auto look = [&]<class Constraint>(const DeviceBuffer<Record<Constraint>>& buffer) {
    if (array == array_of(KindOf<Constraint>::kPhase)) {
      found = words(buffer.get());
    }
  };
  std::apply([&](const auto&... buffers) { (look(buffers), ...); }, records_);
  return found;
}

std::size_t ConstraintBuffers::memory_bytes() const noexcept {
  const std::size_t of_kinds =
      std::apply([](const auto&... buffers) { return (... + buffers.memory_bytes()); }, records_);
  return of_kinds + distance_damping_.memory_bytes() + joints_.memory_bytes() +
         tubes_.memory_bytes() + level_ends_.memory_bytes() + multipliers_.memory_bytes();
}

}  // namespace pbdsurg::cuda
