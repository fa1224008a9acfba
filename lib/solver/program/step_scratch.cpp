// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/program/step_scratch.h"

#include <algorithm>

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

template <class T>
std::size_t bytes_of(const std::vector<T>& list) {
  return list.capacity() * sizeof(T);
}

// With as much room as another list has, so that both grow together.
template <class T>
void fit_list(std::vector<T>& list, std::size_t size, std::size_t capacity, const T& value = {}) {
  list.reserve(capacity);
  list.resize(size, value);
}

}  // namespace

void StepScratch::fit(const SolverData& data) {
  const std::size_t places = data.particles.size(), room = data.particles.capacity();
  fit_list(has_displacements(data.options) ? displacements : previous, places, room);
  data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
    auto& groups = multipliers.of<Constraint>();
    // what an undo closes, edits open again
    groups.resize(std::max(groups.size(), static_cast<std::size_t>(slots.group_count())));
    for (Index group = 0; group < slots.group_count(); ++group) {
      fit_list(groups[group], slots.blocks(group).size(), slots.block_capacity(group));
    }
  });
  triangles_at_tool.reserve(data.surface.slot_count());
  if (!moves_vertices(data.options)) {
    return;
  }
  fit_list(flights, places, room);
  fit_list(fixed_points, places, room);
  fit_list(first_holds, places, room, kInvalidIndex);
  held.resize(static_cast<std::size_t>(data.vertex_blocks.block_count()), 0);
  reserve_holds(data);
  if (has_coarse_correction(data.options)) {
    coarse.fit(data);
    coarse.held.reserve(holds.capacity() + data.custom.places().size());
  }
  fit_ends(data);
}

void StepScratch::fit_ends(const SolverData& data) {
  if (!data.custom.empty() || !data.contact_bodies.empty()) {
    pushed.fit(data.free_pieces, data.particles.size());
  }
  if (!data.contact_bodies.empty()) {
    meeting.fit(data.free_pieces, data.particles.size());
  }
  const auto& links = data.sets.of<StiffLinkConstraint>();
  if (links.group_count() == 0 && data.custom.empty() && data.contact_bodies.empty()) {
    return;
  }
  const std::size_t places = data.particles.size(), room = data.particles.capacity();
  for (std::vector<Particle>* const list : {&end_ways, &end_gives, &end_shears}) {
    fit_list(*list, places, room);
  }
  linked.assign(static_cast<std::size_t>(data.vertex_blocks.block_count()), 0);
  lone_ends.clear();
  const auto add = [&](ParticleOffset corner) {
    const auto [block, lane] = data.vertex_blocks.place_of(place_at(corner));
    if (block == kInvalidIndex) {
      lone_ends.push_back(corner);
    } else {
      linked[block] |= LaneBits{1} << lane;
    }
  };
  for (Index group = 0; group < links.group_count(); ++group) {
    for (Index slot = 0; slot < links.size(group); ++slot) {
      for (const auto& corners : links.blocks(group)[slot / kBlockLanes].corners) {
        add(corners[slot % kBlockLanes]);
      }
    }
  }
  for (const Index place : data.custom.places()) {
    add(offset_of(place));
  }
  if (!data.custom.empty()) {
    guards.resize(linked.size());
  }
}

void StepScratch::reserve_holds(const SolverData& data) {
  std::size_t most = 0, most_rigid = 0;
  for (Index i = 0; i < data.copy_count(); ++i) {
    std::size_t sum = 0, rigid = 0;
    for (const ToolState& tool : data.copy(i).tools) {
      rigid += tool.surface_contacts.capacity();
      sum += tool.attachments.size() + 3 * tool.grip.points.size() + tool.contacts.capacity() +
             3 * tool.surface_contacts.capacity();
    }
    const std::size_t touches = data.copy(i).touches.contacts.capacity();
    sum += TissueTouch::kCorners * touches;
    rigid += 2 * touches;
    most = std::max(most, sum);
    most_rigid = std::max(most_rigid, rigid);
  }
  holds.reserve(most);
  gives.reserve(most);
  likely_pushes.weights.reserve(most);
  likely_pushes.of_holds.reserve(most);
  contact_entries.reserve(most);
  group_contacts.reserve(most_rigid);
  group_answers.reserve(most_rigid);
  group_bodies.reserve(GroupSpace::kMostPieces);
  group_space.resize(1);
  piece_pairs.reserve(most_rigid);
}

void StepScratch::fit_beside(const SolverData& data) {
  fit(data);
  const bool is_current = has_own_rows && rows_revision == data.rows_revision;
  has_own_rows = data.vertex_blocks.has_damping();
  rows_revision = data.rows_revision;
  if (has_own_rows && !is_current) {
    const VertexBlocks::Arrays rows = data.vertex_blocks.arrays();
    springs.assign(rows.springs.begin(), rows.springs.end());
    volumes.assign(rows.volumes.begin(), rows.volumes.end());
    hinges.assign(rows.hinges.begin(), rows.hinges.end());
    strips.assign(rows.strips.begin(), rows.strips.end());
    triangles.assign(rows.triangles.begin(), rows.triangles.end());
  }
}

std::size_t StepScratch::memory_bytes() const noexcept {
  std::size_t bytes =
      bytes_of(previous) + bytes_of(displacements) + bytes_of(flights) + bytes_of(fixed_points) +
      bytes_of(triangles_at_tool) + bytes_of(first_holds) + bytes_of(holds) + bytes_of(gives) +
      bytes_of(likely_pushes.weights) + bytes_of(likely_pushes.of_holds) + bytes_of(walls_at_tool) +
      bytes_of(stopped) + bytes_of(held) + bytes_of(contact_entries) + bytes_of(group_answers) +
      bytes_of(group_space) + bytes_of(group_contacts) + bytes_of(group_bodies) +
      bytes_of(piece_pairs) + touched.memory_bytes() + bytes_of(end_ways) + bytes_of(end_gives) +
      bytes_of(end_shears) + bytes_of(linked) + bytes_of(lone_ends) + coarse.memory_bytes() +
      pushed.memory_bytes() + meeting.memory_bytes() + bytes_of(guards) + bytes_of(springs) +
      bytes_of(volumes) + bytes_of(hinges) + bytes_of(strips) + bytes_of(triangles);
  multipliers.for_each([&](const auto& groups) {
    for (const auto& blocks : groups) {
      bytes += bytes_of(blocks);
    }
  });
  return bytes;
}

}  // namespace pbdsurg
