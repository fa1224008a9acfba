// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools on a device: what the host tells of them in a step, and what they touch.

#include <cstddef>
#include <vector>

#include "device_buffer.cuh"
#include "solver/device_arrays.h"
#include "solver/pinned_buffer.h"
#include "solver/solver_data.h"

namespace pbdsurg::cuda {

/// A tool that has capsules and holds nothing pushes what it touches.
inline bool is_pusher(const ToolState& tool) {
  return !tool.capsules.empty() && tool.attachments.empty();
}

class ToolBuffers {
 public:
  /// Follows tools that are new or hold something else.
  void take_over(const SolverData& data);

  /// Computes what the host tells about a step, and enqueues its copy. No step may be at work.
  void upload(SolverData& data, float dt, cudaStream_t stream);

  [[nodiscard]] const ToolArrays& arrays() const noexcept { return arrays_; }
  [[nodiscard]] StepInput* input() const noexcept {
    return reinterpret_cast<StepInput*>(device_input_.get());
  }
  [[nodiscard]] bool has_pushers() const noexcept { return pusher_count_ > 0; }
  [[nodiscard]] bool has_attachments() const noexcept { return attachment_count_ > 0; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  struct alignas(16) Word {
    std::byte bytes[16];
  };

  std::size_t lay_out(const SolverData& data, StepInput& input) const;
  void write_substep(const SolverData& data, Index substep, StepInput* input) const;

  // what tools hold
  std::vector<HeldInput> held_;
  std::vector<Index> held_order_;
  Index pusher_count_ = 0;
  Index capsule_count_ = 0;  // of pushers
  Index attachment_count_ = 0;

  PinnedBuffer<Word> host_input_;
  DeviceBuffer<Word> device_input_;
  DeviceBuffer<std::uint32_t> touched_;
  DeviceBuffer<ContactPlane> planes_;
  DeviceBuffer<float> contact_multipliers_;
  DeviceBuffer<Index> contact_places_, contact_counts_;
  DeviceBuffer<Vec3<float>> attachment_multipliers_;
  ToolArrays arrays_{};
};

}  // namespace pbdsurg::cuda
