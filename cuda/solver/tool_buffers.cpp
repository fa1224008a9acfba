// SPDX-License-Identifier: Apache-2.0
#include "solver/tool_buffers.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <tuple>

#include "solver/contact_stage.h"
#include "solver/load_store.h"

namespace pbdsurg::cuda {

void ToolBuffers::take_over(const SolverData& data) {
  struct Hold {
    Index place, color, attachment;
  };
  std::vector<Hold> holds;
  pusher_count_ = capsule_count_ = 0;
  for (const ToolState& tool : data.tools) {
    if (is_pusher(tool)) {
      ++pusher_count_;
      capsule_count_ += static_cast<Index>(tool.capsules.size());
    }
    for (const Attachment& attachment : tool.attachments) {
      holds.push_back({data.place_of_vertex[attachment.vertex], attachment.color,
                       static_cast<Index>(holds.size())});
    }
  }
  attachment_count_ = static_cast<Index>(holds.size());
  std::ranges::sort(holds, {}, [](const Hold& hold) { return std::tie(hold.place, hold.color); });
  held_.clear();
  held_order_.clear();
  for (const Hold& hold : holds) {
    if (held_.empty() || held_.back().place != hold.place) {
      held_.push_back({hold.place, static_cast<Index>(held_order_.size()), 0, 0});
    }
    ++held_.back().count;
    held_order_.push_back(hold.attachment);
  }

  const std::size_t places = data.particles.size();
  const std::size_t words = (places + 31) / 32;
  const std::size_t room =
      std::min(places, static_cast<std::size_t>(data.options.contact_capacity));
  const auto pushers = static_cast<std::size_t>(pusher_count_);
  arrays_ = {touched_.reserve(pushers * words),
             planes_.reserve(pushers * places),
             contact_multipliers_.reserve(pushers * places),
             contact_places_.reserve(pushers * room),
             contact_counts_.reserve(pushers),
             attachment_multipliers_.reserve(static_cast<std::size_t>(attachment_count_)),
             static_cast<Index>(words),
             static_cast<Index>(room)};
}

std::size_t ToolBuffers::lay_out(const SolverData& data, StepInput& input) const {
  const auto substeps = static_cast<std::size_t>(data.options.substeps);
  const auto attachments = static_cast<std::size_t>(attachment_count_);
  std::size_t size = sizeof(StepInput);
  const auto place = [&](std::size_t bytes) {
    const std::size_t offset = size;
    size += (bytes + sizeof(Word) - 1) / sizeof(Word) * sizeof(Word);
    return static_cast<std::uint32_t>(offset);
  };
  input.tools = place(data.tools.size() * sizeof(ToolInput));
  input.forces = place(data.tools.size() * sizeof(Vec3<float>));
  input.pushers = place(substeps * static_cast<std::size_t>(pusher_count_) * sizeof(PusherInput));
  input.capsules =
      place(substeps * static_cast<std::size_t>(capsule_count_) * sizeof(PlacedCapsule));
  input.attachments = place(substeps * attachments * sizeof(AttachmentInput));
  input.held = place(held_.size() * sizeof(HeldInput));
  input.held_order = place(attachments * sizeof(Index));
  return size;
}

// Where tools are in a substep is in the data.
void ToolBuffers::write_substep(const SolverData& data, Index substep, StepInput* input) const {
  PusherInput* pusher = table<PusherInput>(input, input->pushers) + substep * pusher_count_;
  PlacedCapsule* const capsules =
      table<PlacedCapsule>(input, input->capsules) + substep * capsule_count_;
  AttachmentInput* attachment =
      table<AttachmentInput>(input, input->attachments) + substep * attachment_count_;
  Index capsule = 0;
  for (const ToolState& tool : data.tools) {
    if (is_pusher(tool)) {
      *pusher++ = {contact_box(tool.placed_capsules), capsule,
                   static_cast<Index>(tool.capsules.size())};
      for (const Capsule& placed : tool.placed_capsules) {
        capsules[capsule++] = {load(placed.start), placed.radius, load(placed.end)};
      }
    }
    for (const Attachment& held : tool.attachments) {
      *attachment++ = {load(held.target), held.compliance};
    }
  }
}

void ToolBuffers::upload(SolverData& data, float dt, cudaStream_t stream) {
  const int substeps = data.options.substeps;
  const float h = dt / static_cast<float>(substeps);
  StepInput header{};
  header.h = h;
  header.keep = 1 / (1 + data.options.damping * h);
  header.kick = h * load(data.gravity);
  header.substep = {1 / h, 1 / (h * h)};
  header.force_per_multiplier = header.substep.inverse_dt_squared / static_cast<float>(substeps);
  header.contact_capacity = data.options.contact_capacity;
  header.tool_count = static_cast<Index>(data.tools.size());
  header.pusher_count = pusher_count_;
  header.capsule_count = capsule_count_;
  header.attachment_count = attachment_count_;
  header.held_count = static_cast<Index>(held_.size());
  header.watched_count = static_cast<Index>(data.watched_places.size());
  header.sums.first_non_finite = std::numeric_limits<Index>::max();
  const std::size_t size = lay_out(data, header);
  const std::size_t words = size / sizeof(Word);

  StepInput* const input = new (host_input_.reserve(words)) StepInput(header);
  Index pusher = 0;
  Index attachment = 0;
  for (std::size_t t = 0; t < data.tools.size(); ++t) {
    const ToolState& tool = data.tools[t];
    const auto held = static_cast<Index>(tool.attachments.size());
    table<ToolInput>(input, input->tools)[t] = {is_pusher(tool) ? pusher++ : kInvalidIndex,
                                                attachment, held, 0};
    table<Vec3<float>>(input, input->forces)[t] = {};
    attachment += held;
  }
  for (int substep = 0; substep < substeps && !data.tools.empty(); ++substep) {
    place_tools(data, static_cast<float>(substep + 1) / static_cast<float>(substeps));
    write_substep(data, substep, input);
  }
  std::ranges::copy(held_, table<HeldInput>(input, input->held));
  std::ranges::copy(held_order_, table<Index>(input, input->held_order));
  PBDSURG_CUDA_CHECK(
      cudaMemcpyAsync(device_input_.reserve(words), input, size, cudaMemcpyHostToDevice, stream));
}

std::size_t ToolBuffers::memory_bytes() const noexcept {
  return device_input_.memory_bytes() + touched_.memory_bytes() + planes_.memory_bytes() +
         contact_multipliers_.memory_bytes() + contact_places_.memory_bytes() +
         contact_counts_.memory_bytes() + attachment_multipliers_.memory_bytes();
}

}  // namespace pbdsurg::cuda
