// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools of all copies on a device: what the host tells of them in a step, and what they touch.

#include <cstddef>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/surface_buffers.h"
#include "cuda/solver/touch_buffers.h"
#include "lib/device/device_arrays.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// A tool that has capsules and holds nothing pushes what it touches, unless it is a jaw of a grip.
inline bool is_pusher(const CopyState& copy, Index tool) {
  return copy.pushes(tool) && !copy.tools[tool].has_surface();
}

/// Likewise one that meets surfaces, which may also have half spaces.
inline bool is_meeter(const CopyState& copy, Index tool) {
  return copy.pushes(tool) && copy.tools[tool].has_surface();
}

class ToolBuffers {
 public:
  /// Follows tools that are new or hold something else, and room for more vertices.
  /// @param vertex_room  at least as many as there are
  void take_over(const SolverData& data, Index vertex_room, cudaStream_t stream);

  /// Follows triangles, if a tool meets surfaces, and bodies that meet each other. Cost:
  /// O(triangles), O(n log n) of these bodies, when these have changed.
  void follow_surfaces(const SolverData& data, cudaStream_t stream);

  /// What tools touched, and what became of grips, when the device has done a part of a step.
  void take_contacts(SolverState& state) const;

  /// Computes what the host tells about a part of a step, and enqueues its copy. No step may be at
  /// work. Forces of tools go on from those that they have, but for the first part.
  /// @param before  [copy] of the part before; not read for the first
  /// @param moves_before  see StepInput
  /// @return        whether numbers of a copy change after the first substep
  bool upload(SolverData& data, const StepSums* before, Index moves_before, cudaStream_t stream);

  /// As taken over.
  [[nodiscard]] Index vertex_room() const noexcept { return vertex_room_; }

  [[nodiscard]] const ToolArrays& arrays() const noexcept { return arrays_; }
  [[nodiscard]] StepInput* input() const noexcept {
    return reinterpret_cast<StepInput*>(device_input_.get());
  }
  /// Whether any copy has some.
  [[nodiscard]] bool has_pushers() const noexcept { return has_pushers_; }
  [[nodiscard]] bool has_attachments() const noexcept { return has_attachments_; }
  [[nodiscard]] bool has_meeters() const noexcept { return has_meeters_; }
  [[nodiscard]] bool has_grips() const noexcept { return arrays_.grip_room > 0; }
  /// Whether bodies meet each other.
  [[nodiscard]] bool has_touches() const noexcept { return arrays_.touches.pair_count > 0; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  struct alignas(16) Word {
    std::byte bytes[16];
  };

  /// The tools of one copy.
  struct CopyTools {
    std::vector<HeldInput> held;
    std::vector<Index> held_order;
    Index pusher_count = 0;
    Index capsule_count = 0;  // of pushers
    Index attachment_count = 0;
    std::vector<Index> meeters;  // tools
    std::vector<Index> grips;    // likewise
    std::vector<GripHold> grip_holds;
    Index grip_point_count = 0, grip_corner_count = 0;
    Index swept_count = 0, half_space_count = 0, remembered_count = 0;
    bool has_springs = false;
  };

  static CopyTools find_tools(const SolverData& data, const CopyState& copy);
  std::size_t lay_out(const SolverData& data, std::size_t copy, std::size_t end,
                      StepInput& input) const;
  static void write_tools(const SolverData& data, CopyState& copy, const CopyTools& tools,
                          StepInput* input);
  static void write_substep(const CopyState& copy, const CopyTools& tools, Index substep,
                            StepInput* input);
  static void write_meeters(const CopyState& copy, const CopyTools& tools, Index substep,
                            StepInput* input);
  static void write_grips(const SolverData& data, const CopyState& copy, const CopyTools& tools,
                          StepInput* input);

  std::vector<CopyTools> copies_;
  Index vertex_room_ = 0, meeter_room_ = 0, half_space_room_ = 0;

  bool has_pushers_ = false;
  bool has_attachments_ = false;
  bool has_meeters_ = false;
  bool has_springs_ = false;

  PinnedBuffer<Word> host_input_;
  DeviceBuffer<Word> device_input_;
  DeviceBuffer<std::uint32_t> touched_;
  DeviceBuffer<CapsulePlane> planes_;
  DeviceBuffer<float> contact_multipliers_;
  DeviceBuffer<Vec3<float>> contact_points_;
  DeviceBuffer<Index> contact_places_, contact_counts_;
  DeviceBuffer<Vec3<float>> attachment_multipliers_;
  PinnedBuffer<GripInput> told_grips_;
  PinnedBuffer<GripPointInput> told_points_;
  DeviceBuffer<GroupContact> group_contacts_;
  DeviceBuffer<GroupAnswer> group_answers_;
  SurfaceBuffers surfaces_;
  TouchBuffers touches_;
  ToolArrays arrays_{};
};

}  // namespace pbdsurg::cuda
