// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/tool_buffers.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <tuple>

#include "pbdsurg/cuda/device.h"

#include "cuda/solver/longest_wait.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg::cuda {

ToolBuffers::CopyTools ToolBuffers::find_tools(const SolverData& data, const CopyState& copy) {
  struct Hold {
    Index place, turn, entry;
  };
  CopyTools tools;
  std::vector<Hold> holds;
  const auto add_hold = [&](Index vertex, Index entry) {
    holds.push_back({data.place_of_vertex[vertex], static_cast<Index>(holds.size()), entry});
  };
  for (const ToolState& tool : copy.tools) {
    tools.attachment_count += static_cast<Index>(tool.attachments.size());
  }
  Index attachment = 0;
  for (Index t = 0; t < static_cast<Index>(copy.tools.size()); ++t) {
    const ToolState& tool = copy.tools[t];
    if (is_meeter(copy, t)) {
      tools.meeters.push_back(t);
      tools.has_springs = tools.has_springs || tool.is_coupled();
      tools.swept_count += static_cast<Index>(tool.capsules.size());
      tools.half_space_count += static_cast<Index>(tool.half_spaces.size());
    }
    if (is_pusher(copy, t)) {
      ++tools.pusher_count;
      tools.capsule_count += static_cast<Index>(tool.capsules.size());
    }
    for (const Attachment& held : tool.attachments) {
      add_hold(held.vertex, attachment++);
    }
    if (tool.grip.points.empty()) {
      continue;
    }
    const auto grip = static_cast<Index>(tools.grips.size());
    tools.grips.push_back(t);
    for (const GripPoint& point : tool.grip.points) {
      // projections draw points, vertex blocks the vertices of these
      for (int k = 0; moves_vertices(data.options) && k < corner_count(point.at); ++k) {
        if (point.at.weights[k] > 0) {
          add_hold(point.at.vertices[k],
                   tools.attachment_count + static_cast<Index>(tools.grip_holds.size()));
          tools.grip_holds.push_back({grip, tools.grip_point_count, k});
        }
      }
      ++tools.grip_point_count;
    }
    tools.grip_corner_count += static_cast<Index>(tool.grip.corners.size());
  }
  std::ranges::sort(holds, {}, [](const Hold& hold) { return std::tie(hold.place, hold.turn); });
  for (const Hold& hold : holds) {
    if (tools.held.empty() || tools.held.back().place != hold.place) {
      tools.held.push_back({hold.place, static_cast<Index>(tools.held_order.size()), 0, 0});
    }
    ++tools.held.back().count;
    tools.held_order.push_back(hold.entry);
  }
  return tools;
}

void ToolBuffers::take_over(const SolverData& data, Index vertex_room, cudaStream_t stream) {
  const auto copy_count = static_cast<std::size_t>(data.copy_count());
  copies_.resize(copy_count);
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    // A recorded step stays as it is while there is room, and also once the last tool lets go:
    // kernels then find nothing to do.
    const CopyTools& tools = copies_[copy] = find_tools(data, data.copy(copy));
    has_pushers_ = has_pushers_ || tools.pusher_count > 0;
    has_attachments_ = has_attachments_ || tools.attachment_count > 0;
    has_meeters_ = has_meeters_ || !tools.meeters.empty();
    arrays_.grip_room = std::max(arrays_.grip_room, static_cast<Index>(tools.grips.size()));
    arrays_.point_room = std::max(arrays_.point_room, tools.grip_point_count);
    has_springs_ = has_springs_ || tools.has_springs;
    meeter_room_ = std::max(meeter_room_, static_cast<Index>(tools.meeters.size()));
    half_space_room_ = std::max(half_space_room_, tools.half_space_count);
    arrays_.pusher_room = std::max(arrays_.pusher_room, tools.pusher_count);
    arrays_.attachment_room = std::max(arrays_.attachment_room, tools.attachment_count);
  }

  const auto places = static_cast<std::size_t>(vertex_room);
  const std::size_t words = (places + 31) / 32;
  const std::size_t room =
      std::min(places, static_cast<std::size_t>(data.options.contact_capacity));
  const std::size_t pushers = copy_count * static_cast<std::size_t>(arrays_.pusher_room);
  arrays_ = {touched_.reserve(pushers * words),
             planes_.reserve(pushers * places),
             contact_multipliers_.reserve(pushers * places),
             contact_points_.reserve(pushers * places),
             contact_places_.reserve(pushers * room),
             contact_counts_.reserve(pushers),
             attachment_multipliers_.reserve(copy_count *
                                             static_cast<std::size_t>(arrays_.attachment_room)),
             static_cast<Index>(words),
             static_cast<Index>(room),
             arrays_.pusher_room,
             arrays_.attachment_room,
             told_grips_.reserve(copy_count * static_cast<std::size_t>(arrays_.grip_room)),
             told_points_.reserve(copy_count * static_cast<std::size_t>(arrays_.point_room)),
             arrays_.grip_room,
             arrays_.point_room,
             {},
             {},
             nullptr,
             nullptr,
             0};
  vertex_room_ = vertex_room;
  follow_surfaces(data, stream);
}

void ToolBuffers::follow_surfaces(const SolverData& data, cudaStream_t stream) {
  if (has_meeters_) {
    surfaces_.take_over(data, {vertex_room_, meeter_room_, half_space_room_, has_springs_}, stream);
    arrays_.surfaces = surfaces_.arrays();
  }
  touches_.take_over(data, vertex_room_, stream);
  arrays_.touches = touches_.arrays();
  const Index groups = arrays_.surfaces.contact_room + arrays_.touches.contact_room;
  if (moves_vertices(data.options) && groups != arrays_.group_room) {
    const std::size_t room = copies_.size() * static_cast<std::size_t>(groups);
    arrays_.group_contacts = group_contacts_.reserve(room);
    arrays_.group_answers = group_answers_.reserve(room);
    arrays_.group_room = groups;
  }
}

// Sets the counts and tables of a copy, in bytes from its input.
// @param end  bytes from the start of all inputs to where there is room
// @return     bytes to where there is room then
std::size_t ToolBuffers::lay_out(const SolverData& data, std::size_t copy, std::size_t end,
                                 StepInput& input) const {
  const CopyTools& tools = copies_[copy];
  const auto substeps = static_cast<std::size_t>(data.part.division.substeps);
  const auto attachments = static_cast<std::size_t>(tools.attachment_count);
  const auto place = [&](std::size_t bytes) {
    const std::size_t offset = end - copy * sizeof(StepInput);
    end += (bytes + sizeof(Word) - 1) / sizeof(Word) * sizeof(Word);
    return static_cast<std::uint32_t>(offset);
  };
  input.pusher_count = tools.pusher_count;
  input.capsule_count = tools.capsule_count;
  input.attachment_count = tools.attachment_count;
  input.held_count = static_cast<Index>(tools.held.size());
  input.meeter_count = static_cast<Index>(tools.meeters.size());
  input.swept_count = tools.swept_count;
  input.half_space_count = tools.half_space_count;
  input.grip_count = static_cast<Index>(tools.grips.size());
  input.grip_point_count = tools.grip_point_count;
  input.tools = place(data.tools.size() * sizeof(ToolInput));
  input.wrenches = place(data.tools.size() * sizeof(Wrench));
  input.origins = place(substeps * data.tools.size() * sizeof(Vec3<float>));
  input.pushers =
      place(substeps * static_cast<std::size_t>(tools.pusher_count) * sizeof(PusherInput));
  input.capsules =
      place(substeps * static_cast<std::size_t>(tools.capsule_count) * sizeof(PlacedCapsule));
  input.attachments = place(substeps * attachments * sizeof(AttachmentInput));
  input.held = place(tools.held.size() * sizeof(HeldInput));
  input.held_order = place(tools.held_order.size() * sizeof(Index));
  input.grips = place(tools.grips.size() * sizeof(GripInput));
  input.grip_points =
      place(static_cast<std::size_t>(tools.grip_point_count) * sizeof(GripPointInput));
  input.grip_corners =
      place(static_cast<std::size_t>(tools.grip_corner_count) * sizeof(GripCornerInput));
  input.grip_holds = place(tools.grip_holds.size() * sizeof(GripHold));
  input.grip_poses = place(substeps * tools.grips.size() * sizeof(GripPose));
  input.meeters = place(substeps * tools.meeters.size() * sizeof(MeeterInput));
  input.swept =
      place(substeps * static_cast<std::size_t>(tools.swept_count) * sizeof(SweptCapsule));
  input.half_spaces =
      place(substeps * static_cast<std::size_t>(tools.half_space_count) * sizeof(SweptHalfSpace));
  std::size_t remembered = 0;
  for (const Index tool : tools.meeters) {
    remembered += data.copy(static_cast<Index>(copy)).tools[tool].remembered.size();
  }
  input.remembered = place(remembered * sizeof(RememberedContact));
  const std::vector<RememberedTouch>& touches =
      data.copy(static_cast<Index>(copy)).touches.remembered;
  input.touch_count = static_cast<Index>(touches.size());
  input.touches = place(touches.size() * sizeof(RememberedTouch));
  return end;
}

// Where tools are in a substep is in the copy.
void ToolBuffers::write_substep(const CopyState& copy, const CopyTools& tools, Index substep,
                                StepInput* input) {
  PusherInput* pusher = table<PusherInput>(input, input->pushers) + substep * input->pusher_count;
  PlacedCapsule* const capsules =
      table<PlacedCapsule>(input, input->capsules) + substep * input->capsule_count;
  AttachmentInput* attachment =
      table<AttachmentInput>(input, input->attachments) + substep * input->attachment_count;
  Vec3<float>* origin = table<Vec3<float>>(input, input->origins) + substep * input->tool_count;
  GripPose* pose = table<GripPose>(input, input->grip_poses) + substep * input->grip_count;
  for (const Index t : tools.grips) {
    *pose++ = grip_pose(copy.tools[t].grip, copy.tools[t].placed);
  }
  Index capsule = 0;
  for (Index t = 0; t < static_cast<Index>(copy.tools.size()); ++t) {
    const ToolState& tool = copy.tools[t];
    if (is_pusher(copy, t)) {
      *pusher++ = {contact_box(tool.placed_capsules), capsule,
                   static_cast<Index>(tool.capsules.size())};
      for (const Capsule& placed : tool.placed_capsules) {
        capsules[capsule++] = pbdsurg::placed(placed);
      }
    }
    for (const Attachment& held : tool.attachments) {
      *attachment++ = {load(held.target), copy.grasp_compliance(held)};
    }
    *origin++ = load(Eigen::Vector3f(tool.placed.translation()));
  }
}

// Likewise of those that meet surfaces.
void ToolBuffers::write_meeters(const CopyState& copy, const CopyTools& tools, Index substep,
                                StepInput* input) {
  MeeterInput* meeter = table<MeeterInput>(input, input->meeters) + substep * input->meeter_count;
  SweptCapsule* const swept =
      table<SweptCapsule>(input, input->swept) + substep * input->swept_count;
  SweptHalfSpace* const half_spaces =
      table<SweptHalfSpace>(input, input->half_spaces) + substep * input->half_space_count;
  Index capsule = 0, half_space = 0, remembered = 0;
  for (const Index index : tools.meeters) {
    const ToolState& tool = copy.tools[index];
    const auto remembered_count = static_cast<Index>(tool.remembered.size());
    *meeter++ = {swept_box(tool),
                 capsule,
                 static_cast<Index>(tool.capsules.size()),
                 half_space,
                 static_cast<Index>(tool.half_spaces.size()),
                 remembered,
                 remembered_count,
                 tool.spring.displacement,
                 tool.is_coupled() ? copy.spring_compliance(tool) : 0.0F,
                 tool.stride(),
                 way_of(tool),
                 told_way(tool),
                 tool.surface.friction,
                 tool.meets_triangles()};
    remembered += remembered_count;
    for (std::size_t c = 0; c < tool.capsules.size(); ++c) {
      swept[capsule++] = swept_capsule(tool, c);
    }
    for (const HalfSpace& each : tool.half_spaces) {
      half_spaces[half_space++] = swept_half_space(tool, each);
    }
  }
}

// As they are when a part of a step begins: before tools are placed in its substeps.
void ToolBuffers::write_grips(const SolverData& data, const CopyState& copy, const CopyTools& tools,
                              StepInput* input) {
  GripInput* grips = table<GripInput>(input, input->grips);
  GripPointInput* const points = table<GripPointInput>(input, input->grip_points);
  GripCornerInput* const corners = table<GripCornerInput>(input, input->grip_corners);
  Index point_count = 0, corner_total = 0;
  for (const Index t : tools.grips) {
    const ToolGrip& grip = copy.tools[t].grip;
    *grips++ = {point_count,
                static_cast<Index>(grip.points.size()),
                corner_total,
                static_cast<Index>(grip.corners.size()),
                limit_of(copy, grip),
                compliance_of(copy, grip),
                load(grip.slide),
                load(grip.pull),
                grip.slid};
    for (const GripPoint& from : grip.points) {
      GripPointInput& point = points[point_count++];
      point = {{kInvalidIndex, kInvalidIndex, kInvalidIndex},
               {kInvalidIndex, kInvalidIndex, kInvalidIndex},
               {from.at.weights[0], from.at.weights[1], from.at.weights[2]},
               load(from.anchor),
               {},
               {},
               load(from.force)};
      for (int k = 0; k < corner_count(from.at); ++k) {
        const Index vertex = from.at.vertices[k];
        const auto corner = std::ranges::lower_bound(grip.corners, vertex, {}, &GripCorner::vertex);
        point.places[k] = data.place_of_vertex[vertex];
        point.corners[k] = static_cast<Index>(corner - grip.corners.begin());
      }
    }
    for (const GripCorner& corner : grip.corners) {
      corners[corner_total++] = {data.place_of_vertex[corner.vertex], corner.share};
    }
  }
  std::ranges::copy(tools.grip_holds, table<GripHold>(input, input->grip_holds));
}

void ToolBuffers::write_tools(const SolverData& data, CopyState& copy, const CopyTools& tools,
                              StepInput* input) {
  const StepPart& part = data.part;
  Index pusher = 0;
  Index meeter = 0;
  Index grip = 0;
  Index attachment = 0;
  for (ToolState& tool : copy.tools) {
    if (part.is_first()) {
      begin_grip(tool.grip);
    }
  }
  write_grips(data, copy, tools, input);
  for (Index t = 0; t < static_cast<Index>(copy.tools.size()); ++t) {
    const ToolState& tool = copy.tools[t];
    const auto held = static_cast<Index>(tool.attachments.size());
    table<ToolInput>(input, input->tools)[t] = {is_pusher(copy, t) ? pusher++ : kInvalidIndex,
                                                is_meeter(copy, t) ? meeter++ : kInvalidIndex,
                                                tool.grip.points.empty() ? kInvalidIndex : grip++,
                                                attachment, held};
    table<Wrench>(input, input->wrenches)[t] =
        part.is_first() ? Wrench{} : Wrench{load(tool.force), load(tool.torque)};
    attachment += held;
  }
  for (int substep = 0; substep < part.division.substeps && !copy.tools.empty(); ++substep) {
    place_tools(copy, part.done_after(substep), part.done_after(substep - 1));
    write_substep(copy, tools, substep, input);
    write_meeters(copy, tools, substep, input);
  }
  RememberedContact* remembered = table<RememberedContact>(input, input->remembered);
  for (const Index tool : tools.meeters) {
    remembered = std::ranges::copy(copy.tools[tool].remembered, remembered).out;
  }
  std::ranges::copy(copy.touches.remembered, table<RememberedTouch>(input, input->touches));
  std::ranges::copy(tools.held, table<HeldInput>(input, input->held));
  std::ranges::copy(tools.held_order, table<Index>(input, input->held_order));
}

namespace {

bool are_alike(const FreeMotion<float>& a, const FreeMotion<float>& b) {
  return a.h == b.h && a.keep == b.keep && a.kick_time == b.kick_time && a.kick.x == b.kick.x &&
         a.kick.y == b.kick.y && a.kick.z == b.kick.z;
}

// Of the first substep and of later ones.
// @return  whether these differ
bool write_lengths(const SolverData& data, const CopyState& copy, StepInput& input) {
  const StepPart& part = data.part;
  const SubstepNumbers first = substep_numbers(data, copy, part.h, 0);
  const SubstepNumbers later = substep_numbers(data, copy, part.h, 1);
  input.motion = first.motion;
  input.substep = first.lengths;
  input.past_share = first.past_share;
  input.force_per_multiplier =
      copy.factors.stiffness * part.force_per_multiplier(first.lengths.inverse_dt_squared);
  input.later_motion = later.motion;
  input.later_substep = later.lengths;
  input.later_past_share = later.past_share;
  input.later_force_per_multiplier =
      copy.factors.stiffness * part.force_per_multiplier(later.lengths.inverse_dt_squared);
  return part.division.substeps > 1 &&
         (!are_alike(first.motion, later.motion) || first.lengths != later.lengths ||
          first.past_share != later.past_share);
}

}  // namespace

bool ToolBuffers::upload(SolverData& data, const StepSums* before, Index moves_before,
                         cudaStream_t stream) {
  StepInput header{};
  header.unit = data.vertex_blocks.unit();
  header.h = data.part.h;
  header.inverse_h = 1 / data.part.h;
  header.per_step = data.part.per_step;
  header.heading = is_explicit(data.options) ? data.stable_substep.heading() : 0;
  header.substep_count = data.part.division.substeps;
  header.moves_before = moves_before;
  header.longest_wait = longest_wait;
  header.vertex_count = static_cast<Index>(data.particles.size());
  header.contact_capacity = data.options.contact_capacity;
  header.tool_count = static_cast<Index>(data.tools.size());
  header.watched_count = static_cast<Index>(data.watched_places.size());
  header.sums.first_non_finite = std::numeric_limits<Index>::max();
  std::size_t size = copies_.size() * sizeof(StepInput);
  for (std::size_t copy = 0; copy < copies_.size(); ++copy) {
    size = lay_out(data, copy, size, header);
  }
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw DeviceError("the tools of " + std::to_string(copies_.size()) + " copies take " +
                      std::to_string(size) + " bytes a step; a device takes 4 GiB");
  }

  // grasps come and go without a step being recorded anew
  const std::size_t room = std::bit_ceil(size / sizeof(Word));
  StepInput* const inputs = reinterpret_cast<StepInput*>(host_input_.reserve(room));
  size = copies_.size() * sizeof(StepInput);
  bool changes_lengths = false;
  for (std::size_t copy = 0; copy < copies_.size(); ++copy) {
    CopyState& state = data.copy(static_cast<Index>(copy));
    size = lay_out(data, copy, size, header);
    changes_lengths = write_lengths(data, state, header) || changes_lengths;
    header.density = state.factors.density;
    header.sums.dropped_contacts =
        data.part.is_first() ? DroppedContacts{} : before[copy].dropped_contacts;
    write_tools(data, state, copies_[copy], new (inputs + copy) StepInput(header));
  }
  PBDSURG_CUDA_CHECK(
      cudaMemcpyAsync(device_input_.reserve(room), inputs, size, cudaMemcpyHostToDevice, stream));
  return changes_lengths;
}

void ToolBuffers::take_contacts(SolverState& state) const {
  for (Index copy = 0; copy < state.copy_count() && has_meeters_; ++copy) {
    surfaces_.take_contacts(copy, copies_[copy].meeters, state.copy(copy));
  }
  for (Index copy = 0; copy < state.copy_count(); ++copy) {
    touches_.take_contacts(copy, state.copy(copy));
  }
  for (Index copy = 0; copy < state.copy_count() && has_grips(); ++copy) {
    const GripInput* told = arrays_.told_grips + copy * arrays_.grip_room;
    const GripPointInput* point = arrays_.told_points + copy * arrays_.point_room;
    for (const Index t : copies_[copy].grips) {
      ToolGrip& grip = state.copy(copy).tools[t].grip;
      grip.slide = vector_of(told->slide);
      grip.pull = vector_of(told->pull);
      grip.slid = told->slid;
      ++told;
      for (GripPoint& own : grip.points) {
        own.anchor = vector_of(point->anchor);
        own.force = vector_of(point->force);
        ++point;
      }
    }
  }
}

std::size_t ToolBuffers::memory_bytes() const noexcept {
  return device_input_.memory_bytes() + touched_.memory_bytes() + planes_.memory_bytes() +
         contact_multipliers_.memory_bytes() + contact_points_.memory_bytes() +
         surfaces_.memory_bytes() + touches_.memory_bytes() + group_contacts_.memory_bytes() +
         group_answers_.memory_bytes() + contact_places_.memory_bytes() +
         contact_counts_.memory_bytes() + attachment_multipliers_.memory_bytes();
}

}  // namespace pbdsurg::cuda
