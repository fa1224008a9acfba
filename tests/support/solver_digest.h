// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One number for all that a solver holds, for telling whether anything differs.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tests/support/digest.h"
#include "tests/support/inspect.h"

namespace pbdsurg::testing {

/// Groups, their order and the numbers in them.
template <class Constraint>
void mix_slots(Digest& digest, const ConstraintSlots<Constraint>& slots) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    digest.mix_all(slots.ids(group));
    for (const Index id : slots.ids(group)) {
      digest.mix_all(slots.record(id).places);
      digest.mix_all(slots.record(id).parameters);
    }
    for (const auto& block : slots.blocks(group)) {  // idle lanes, too
      for (const auto& corners : block.corners) {
        digest.mix_all(corners);
      }
    }
  }
}

/// Topology, constraints, their order, masses, plan, and the state and tools of all copies. What is
/// kept within a substep or by a backend alone is left out.
inline std::uint64_t digest_of(const SolverData& data) {
  const TissueData& tissue = inspect(*data.tissue);
  Digest digest;
  digest.mix_all(data.tissue->tets());
  digest.mix_all(data.tissue->edges());
  digest.mix_all(data.tissue->tet_edges());
  digest.mix_all(data.tissue->edge_tets());
  for (Index v = 0; v < static_cast<Index>(data.particles.size()); ++v) {
    digest.mix_all(data.tissue->tets_at(v));
    digest.mix_all(data.tissue->links_at(v));
    digest.mix_all(data.tissue->hinges_at(v));
  }
  digest.mix(data.sets.distance_ids.count());
  digest.mix_all(tissue.tet_alive.values());
  digest.mix(data.tissue->bodies().size());
  digest.mix_all(tissue.tissue_counts.values());
  digest.mix_all(tissue.later_vertex_bodies.values());
  digest.mix_all(tissue.later_tet_bodies.values());
  digest.mix(data.sets.has_damping);
  digest.mix_all(tissue.tet_masses.values());
  digest.mix_all(data.tissue->masses());
  digest.mix_all(data.place_of_vertex);
  for (const Link& link : data.tissue->links()) {
    digest.mix(link.first);
    digest.mix(link.second);
  }
  data.sets.for_each_set([&](const auto& slots) { mix_slots(digest, slots); });
  for (std::size_t edge = 0; edge < data.tissue->edges().size(); ++edge) {
    digest.mix(data.sets.edge_owners[static_cast<Index>(edge)]);
  }
  for (const Phase& phase : data.sets.phases) {
    digest.mix(static_cast<int>(phase.kind));
    digest.mix(phase.color);
    digest.mix(phase.level);
    digest.mix(phase.domain);
  }
  for (const Phase& phase : data.plan.phases) {
    digest.mix(static_cast<int>(phase.kind));
    digest.mix(phase.color);
  }
  const VertexBlocks::Arrays rows = data.vertex_blocks.arrays();
  for (const VertexBlock& block : rows.blocks) {
    digest.mix_all(block.corners);
    digest.mix(block.pulls.count);
    for (const PullRow& row : rows.pulls.subspan(block.pulls.first, block.pulls.count)) {
      digest.mix_all(row.neighbors);
      digest.mix_all(row.weights);
    }
    digest.mix(block.springs.count);
    for (Index i = block.springs.first; i < block.springs.first + block.springs.count; ++i) {
      digest.mix_all(rows.springs[i].neighbors);
      if (rows.damped_springs.empty()) {  // else each substep makes them anew
        digest.mix_all(rows.springs[i].stiffness);
        digest.mix_all(rows.springs[i].rest);
      } else {
        digest.mix_all(rows.damped_springs[i].target);
        digest.mix_all(rows.damped_springs[i].damping);
      }
    }
    digest.mix(block.volumes.count);
    for (Index i = block.volumes.first; i < block.volumes.first + block.volumes.count; ++i) {
      for (const auto& corners : rows.volumes[i].face) {
        digest.mix_all(corners);
      }
      if (rows.damped_volumes.empty()) {
        digest.mix_all(rows.volumes[i].stiffness);
        digest.mix_all(rows.volumes[i].target);
      }
    }
    digest.mix(block.hinges.count);
    for (Index i = block.hinges.first; i < block.hinges.first + block.hinges.count; ++i) {
      for (const auto& corners : rows.hinges[i].neighbors) {
        digest.mix_all(corners);
      }
      digest.mix_all(rows.hinges[i].is_opposite);
      if (rows.damped_hinges.empty()) {
        digest.mix_all(rows.hinges[i].stiffness);
        digest.mix_all(rows.hinges[i].rest);
      }
    }
  }
  for (Index i = 0; i < data.copy_count(); ++i) {
    const CopyState& copy = data.copy(i);
    if (copy.is_state_current) {
      for (const Particle& p : copy.particles) {
        digest.mix_all(std::array{p.x, p.y, p.z, p.w});
      }
      for (const Velocity& v : copy.velocities) {
        digest.mix_all(std::array{v.x, v.y, v.z});
      }
      for (const Carry& carry : copy.carries) {
        digest.mix_all(std::array{carry.x, carry.y, carry.z, carry.falling});
      }
    } else {  // the backend has it: what is here of it is what was read last
      for (const Particle& p : copy.particles) {
        digest.mix(p.w);
      }
    }
    digest.mix(copy.attachment_colors);
    for (const ToolState& tool : copy.tools) {
      for (const Attachment& attachment : tool.attachments) {
        digest.mix(attachment.vertex);
        digest.mix(attachment.color);
        digest.mix_all(attachment.anchor);
      }
    }
  }
  return digest.value();
}

}  // namespace pbdsurg::testing
