// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One number for all that a solver holds, for telling whether anything differs.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

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

/// Vertices colour by colour, and their rows; not in which lanes these lie, which nothing depends
/// on.
inline void mix_vertices(Digest& digest, const VertexBlocks& vertices) {
  const VertexBlocks::Arrays rows = vertices.arrays();
  for (Index color = 0; color < vertices.color_count(); ++color) {
    std::vector<Index> places;
    const auto [first, count] = vertices.blocks(color);
    for (const VertexBlock& block : rows.blocks.subspan(first, count)) {
      std::transform(block.corners, block.corners + block.lane_count, std::back_inserter(places),
                     [](ParticleOffset corner) { return place_at(corner); });
    }
    std::ranges::sort(places);
    digest.mix_all(places);
    for (const Index place : places) {
      const VertexBlocks::Place at = vertices.place_of(place);
      const VertexBlock& block = rows.blocks[at.block];
      const Index lane = at.lane;  // no structured binding: Clang before 16 captures none
      const auto is_padding = [&](const auto& neighbors) {
        return neighbors[lane] == block.corners[lane];
      };
      for (const PullRow& row : rows.pulls.subspan(block.pulls.first, block.pulls.count)) {
        if (!is_padding(row.neighbors)) {
          digest.mix(row.neighbors[lane]);
          digest.mix(row.weights[lane]);
        }
      }
      for (Index i = block.springs.first; i < block.springs.first + block.springs.count; ++i) {
        if (is_padding(rows.springs[i].neighbors)) {
          continue;
        }
        digest.mix(rows.springs[i].neighbors[lane]);
        if (rows.damped_springs.empty()) {  // else each substep makes them anew
          digest.mix(rows.springs[i].stiffness[lane]);
          digest.mix(rows.springs[i].rest[lane]);
        } else {
          digest.mix(rows.damped_springs[i].target[lane]);
          digest.mix(rows.damped_springs[i].damping[lane]);
        }
      }
      for (Index i = block.volumes.first; i < block.volumes.first + block.volumes.count; ++i) {
        if (is_padding(rows.volumes[i].face[0])) {
          continue;
        }
        for (const auto& corners : rows.volumes[i].face) {
          digest.mix(corners[lane]);
        }
        if (rows.damped_volumes.empty()) {
          digest.mix(rows.volumes[i].stiffness[lane]);
          digest.mix(rows.volumes[i].target[lane]);
        }
      }
      for (Index i = block.hinges.first; i < block.hinges.first + block.hinges.count; ++i) {
        if (is_padding(rows.hinges[i].neighbors[0])) {
          continue;
        }
        for (const auto& corners : rows.hinges[i].neighbors) {
          digest.mix(corners[lane]);
        }
        digest.mix(rows.hinges[i].is_opposite[lane]);
        digest.mix(rows.hinges[i].moment[lane]);
        digest.mix(rows.hinges[i].stiffness[lane]);
        digest.mix(rows.hinges[i].rest[lane]);
        digest.mix(rows.hinges[i].damping[lane]);
      }
      for (const TriangleRow& row :
           rows.triangles.subspan(block.triangles.first, block.triangles.count)) {
        if (!is_padding(row.neighbors[0])) {
          digest.mix(row.neighbors[0][lane]);
          digest.mix(row.neighbors[1][lane]);
          digest.mix(row.weights[0][lane]);
          digest.mix(row.weights[1][lane]);
        }
      }
      for (const FibreRow& row : rows.fibres.subspan(block.fibres.first, block.fibres.count)) {
        if (!is_padding(row.neighbors[0])) {
          for (int k = 0; k < 3; ++k) {
            digest.mix(row.neighbors[k][lane]);
            digest.mix(row.shares[k][lane]);
          }
          digest.mix(row.stiffness[lane]);
        }
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
  digest.mix_all(data.tissue->triangles());
  digest.mix_all(tissue.triangle_alive.values());
  digest.mix_all(data.tissue->edges());
  digest.mix_all(data.tissue->tet_edges());
  digest.mix_all(data.tissue->edge_tets());
  for (Index v = 0; v < static_cast<Index>(data.particles.size()); ++v) {
    digest.mix_all(data.tissue->tets_at(v));
    digest.mix_all(data.tissue->links_at(v));
    digest.mix_all(data.tissue->hinges_at(v));
    digest.mix_all(data.tissue->triangles_at(v));
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
  digest.mix_all(tissue.fixed.values());
  digest.mix_all(tissue.stiffnesses.values());
  digest.mix_all(tissue.triangle_stiffnesses.values());
  for (const Fibre& fibre : tissue.fibres.values()) {
    digest.mix_all(fibre.direction);
    digest.mix(fibre.stiffness);
  }
  digest.mix_all(data.place_of_vertex);
  for (const Link& link : data.tissue->links()) {
    digest.mix(link.first);
    digest.mix(link.second);
    digest.mix(link.rest_length);
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
  mix_vertices(digest, data.vertex_blocks);
  for (const CoarseVertex& vertex : data.coarse_space.vertices()) {
    digest.mix_all(vertex.nodes);
    digest.mix_all(vertex.weights);
    digest.mix_all(vertex.place);
  }
  for (Index node = 0; node < data.coarse_space.node_count(); ++node) {
    digest.mix_all(data.coarse_space.members(node).places);
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
    for (const Load& force : copy.forces) {
      digest.mix_all(std::array{force.x, force.y, force.z});
    }
    digest.mix(copy.attachment_colors);
    for (const ToolState& tool : copy.tools) {
      for (const Attachment& attachment : tool.attachments) {
        digest.mix(attachment.vertex);
        digest.mix(attachment.color);
        digest.mix_all(attachment.anchor);
      }
      digest.mix(tool.grip.state);
      for (const GripPoint& point : tool.grip.points) {
        digest.mix_all(point.at.vertices);
        digest.mix_all(point.anchor);
      }
    }
  }
  for (const ContactPair& pair : data.contact_bodies.pairs()) {
    digest.mix(pair.first);
    digest.mix(pair.second);
    digest.mix(pair.contact.thickness);
    digest.mix(pair.contact.friction);
  }
  for (const Load& gravity : data.gravities) {
    digest.mix_all(std::array{gravity.x, gravity.y, gravity.z});
  }
  return digest.value();
}

}  // namespace pbdsurg::testing
