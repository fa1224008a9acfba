// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/compaction.h"

#include <algorithm>
#include <new>
#include <span>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/solver/coarse_choice.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/solver_input.h"
#include "lib/solver/state/state_follower.h"
#include "lib/solver/state/told_contacts.h"
#include "lib/solver/substep_rule.h"
#include "lib/tissue/compact.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

StepReport renumbered(StepReport report, const Renumbering& ids) {
  report.first_non_finite = new_id(report.first_non_finite, ids.vertices);
  return report;
}

// @param places  [place] where it is now, or kInvalidIndex
void renumber(std::vector<RememberedContact>& contacts, const std::vector<Index>& places) {
  std::erase_if(contacts, [&](RememberedContact& contact) {
    bool is_lost = false;
    for (int k = 0, count = contact.feature.count(); k < count; ++k) {
      Index& place = contact.feature.places[k];
      place = places[place];
      is_lost = is_lost || place == kInvalidIndex;
    }
    contact.feature.sort();
    return is_lost;
  });
  std::ranges::sort(contacts, {}, &RememberedContact::feature);
}

// @param places  as above
void renumber(std::vector<RememberedTouch>& touches, const std::vector<Index>& places,
              const std::vector<Index>& bodies) {
  std::erase_if(touches, [&](RememberedTouch& touch) {
    TouchSlot& slot = touch.slot;
    slot.place = places[slot.place];
    bool is_lost = slot.place == kInvalidIndex;
    if (slot.has_edges()) {
      for (Index& end : slot.edges) {
        end = places[end];
        is_lost = is_lost || end == kInvalidIndex;
      }
    } else {
      slot.body = bodies[slot.body];
      is_lost = is_lost || slot.body == kInvalidIndex;
    }
    if (!is_lost && slot.has_edges()) {
      touch.sort_edges();
    } else if (!is_lost) {
      slot = slot_of_vertex(slot.place, slot.body);
    }
    return is_lost;
  });
  std::ranges::sort(touches, {}, &RememberedTouch::slot);
}

// @param vertices  their ids now, of those before; points that are held are of living ones
void renumber(ToolGrip& grip, const std::vector<Index>& vertices) {
  for (GripPoint& point : grip.points) {
    const std::span<Index> corners(point.at.vertices.data(),
                                   static_cast<std::size_t>(corner_count(point.at)));
    std::ranges::transform(corners, corners.begin(), [&](Index v) { return vertices[v]; });
  }
  if (!grip.points.empty()) {
    grip.find_corners();
  }
  std::ranges::transform(grip.torn, grip.torn.begin(), [&](Index v) { return vertices[v]; });
  std::erase(grip.torn, kInvalidIndex);
  std::ranges::sort(grip.torn);
}

void move_pairs(const ContactBodies& from, ContactBodies& to, const std::vector<Index>& bodies) {
  std::vector<ContactPair> pairs;
  for (const ContactPair& pair : from.pairs()) {
    const Index first = bodies[pair.first], second = bodies[pair.second];
    if (first != kInvalidIndex && second != kInvalidIndex) {
      pairs.push_back({std::min(first, second), std::max(first, second), pair.contact});
    }
  }
  to.replace(std::move(pairs));
}

void move_state(const SolverData& from, SolverData& to, const Renumbering& ids) {
  for (Index i = 0; i < from.copy_count(); ++i) {
    const CopyState& before = from.copy(i);
    CopyState& now = to.copy(i);
    std::vector<Index> places(before.particles.size(), kInvalidIndex);  // now, of those before
    now.forces.assign(before.forces.empty() ? 0 : now.particles.size(), {});
    for (std::size_t v = 0; v < ids.vertices.size(); ++v) {
      if (ids.vertices[v] == kInvalidIndex) {
        continue;
      }
      const Index old_place = from.place_of_vertex[v];
      const Index place = places[old_place] = to.place_of_vertex[ids.vertices[v]];
      const Particle& p = before.particles[old_place];
      now.particles[place] = {p.x, p.y, p.z, now.particles[place].w};
      now.velocities[place] = before.velocities[old_place];
      if (!now.carries.empty()) {
        now.carries[place] = before.carries[old_place];
      }
      if (!now.ways.empty()) {
        now.ways[place] = before.ways[old_place];
        now.velocities_before[place] = before.velocities_before[old_place];
      }
      if (!before.forces.empty()) {
        now.forces[place] = before.forces[old_place];
      }
    }
    now.past_substep = before.past_substep;
    now.factors = before.factors;
    now.tools = before.tools;
    for (std::size_t t = 0; t < now.tools.size(); ++t) {
      ToolState& tool = now.tools[t];
      tool.told = contacts_of_tool(from, before, before.tools[t]);
      renumber(tool.told, ids.vertices);
      for (Attachment& held : tool.attachments) {
        held.vertex = ids.vertices[held.vertex];
      }
      renumber(tool.grip, ids.vertices);
      tool.contacts.clear();  // of a substep, by places
      tool.surface_contacts.clear();
      renumber(tool.remembered, places);
    }
    now.touches.remembered = before.touches.remembered;
    renumber(now.touches.remembered, places, ids.bodies);
    now.touches.told = contacts_of_bodies(from, before);
    renumber(now.touches.told, ids.vertices, ids.bodies);
    now.attachment_colors = before.attachment_colors;
    now.watched_positions = before.watched_positions;
    now.last_report = renumbered(before.last_report, ids);
  }
  to.gravity = from.gravity;
  std::vector<Eigen::Vector3f> gravities = from.body_gravities;
  if (!gravities.empty()) {
    renumber_values(gravities, ids.bodies, to.tissue->bodies().size());
  }
  to.set_body_gravities(*to.tissue, std::move(gravities));
  to.reserve_tools();
  move_pairs(from.contact_bodies, to.contact_bodies, ids.bodies);
  if (!to.contact_bodies.empty()) {
    to.reserve_touches();
  }
  to.step_in_flight = from.step_in_flight;
  to.report = renumbered(from.report, ids);
  set_substep_rule(to.substep_rule, to);
  to.rebuild_plan();
  to.plan.phases.reserve(to.plan.phases.size() + static_cast<std::size_t>(from.custom.count()));
}

// What of a solver a new one is made of.
struct Origin {
  SolverOptions options;
  SubstepRule substep_rule;
  ConstraintData constraints;
  VertexBlocks rows;
  std::vector<Eigen::Vector3f> positions;  // m, of the first copy
};

// As before; and where some piece now has no node of a coarse correction, as what moves by sweeps
// alone needs, or as finely as automatic numbers go.
SubstepRule rule_of(const Origin& origin, const Tissue& compacted) {
  if (!has_coarse_correction(origin.options) || has_node_for_each_piece(compacted)) {
    return origin.substep_rule;
  }
  try {
    return both(origin.substep_rule, substep_rule(compacted, origin.options));
  } catch (const InvalidArgument&) {
    return both(origin.substep_rule, {origin.options.longest_step / kMostAutomatic, 0});
  }
}

// @param compacted  what lives, with the new ids
SolverInput input_of(const Origin& origin, const Tissue& compacted, const Renumbering& ids) {
  SolverInput input;
  input.options = origin.options;
  input.substep_rule = rule_of(origin, compacted);
  const auto vertex_count = static_cast<std::size_t>(compacted.vertex_count());
  input.positions = moved<Eigen::Vector3d>(ids.vertices, vertex_count, [&](Index v) {
    const Eigen::Vector3f& x = origin.positions[v];
    return x.allFinite() ? Eigen::Vector3d(x.cast<double>())
                         : Eigen::Vector3d(Eigen::Vector3d::Zero());
  });
  const std::size_t tet_count = compacted.tets().size();
  input.numbers.tets = moved<TetNumbers>(
      ids.tets, tet_count, [&](Index t) { return origin.constraints.numbers_of_tet(t); });
  if (moves_vertices(origin.options)) {
    input.vertex_tets =
        moved<VertexTet>(ids.tets, tet_count, [&](Index t) { return origin.rows.tet(t); });
  }
  input.numbers.edges = moved<EdgeNumbers>(ids.edges, compacted.edges().size(), [&](Index e) {
    return origin.constraints.numbers_of_edge(e);
  });
  input.numbers.triangles =
      moved<TriangleNumbers>(ids.triangles, compacted.triangles().size(),
                             [&](Index t) { return origin.constraints.numbers_of_triangle(t); });
  input.numbers.hinges = moved<HingeNumbers>(ids.hinges, compacted.hinges().size(), [&](Index h) {
    return origin.constraints.numbers_of_hinge(h);
  });
  input.numbers.stiff_links =
      moved<StiffLinkNumbers>(ids.links, compacted.links().size(),
                              [&](Index l) { return origin.constraints.numbers_of_link(l); });
  return input;
}

}  // namespace

struct Compaction::Parts {
  static constexpr const char* kWho = "a compaction";

  std::shared_ptr<const char> solver;  // its identity
  TissueVersion version;               // of the tissue
  Backend::Maker make_backend;
  std::unique_ptr<TissueData> tissue_copy;
  Origin origin;

  std::unique_ptr<Tissue> compacted;
  std::unique_ptr<SolverData> built;  // later what it took the place of
  Renumbering ids;
  bool is_used = false;
};

Compaction::Compaction(const Solver& solver) : parts_(std::make_unique<Parts>()) {
  parts_->origin.positions = solver.positions();
  const SolverData& data = solver_data(solver);
  parts_->solver = data.identity;
  parts_->version = data.tissue->identified_version();
  parts_->make_backend = data.backend->maker();
  parts_->tissue_copy = copy_of_elements(tissue_data(*data.tissue));
  parts_->origin.options = data.options;
  parts_->origin.substep_rule = data.substep_rule;
  parts_->origin.constraints = data.sets;
  parts_->origin.rows = data.vertex_blocks;
}

Compaction::~Compaction() = default;
Compaction::Compaction(Compaction&&) noexcept = default;
Compaction& Compaction::operator=(Compaction&&) noexcept = default;

void Compaction::build() {
  Renumbering ids;
  std::unique_ptr<Tissue> compacted = make_tissue(compact(*parts_->tissue_copy, ids));
  std::unique_ptr<SolverData> built =
      build_solver_data(*compacted, input_of(parts_->origin, *compacted, ids));
  built->set_backend(parts_->make_backend(*built));
  reserve_spare_room(*compacted, parts_->origin.options.spare);
  ids.version_before = parts_->version.number;
  parts_->ids = std::move(ids);
  parts_->compacted = std::move(compacted);
  parts_->built = std::move(built);
}

Renumbering Compaction::finish(Solver& solver) {
  if (parts_->built == nullptr || parts_->is_used) {
    throw InvalidArgument("a compaction is finished once, after build()");
  }
  Tissue& tissue = solver.tissue();
  SolverData& data = *solver.data_;
  if (data.identity != parts_->solver || tissue.identified_version() != parts_->version) {
    throw InvalidArgument("the compaction is of topology version " +
                          std::to_string(parts_->version.number) +
                          " of a solver; this is another, or was edited since and is at " +
                          std::to_string(tissue.version()));
  }
  TissueData& live = tissue_data(tissue);
  int solvers = 0;
  live.followers->for_each([&](const FollowerList::Entry& entry) {
    solvers += dynamic_cast<const StateFollower*>(entry.follower) != nullptr ? 1 : 0;
  });
  if (solvers > 1) {
    throw InvalidArgument("another solver follows the tissue, which cannot go along");
  }
  data.finish_running_step();
  const std::vector<Index> vertex_at = data.vertices_at_places();
  SolverData& built = *parts_->built;
  built.watched_places.clear();
  for (const Index place : data.watched_places) {
    const Index v = vertex_at[place];
    if (parts_->ids.vertices[v] == kInvalidIndex) {
      throw InvalidArgument("vertex " + std::to_string(v) +
                            " is watched and has no tissue; watch others first");
    }
    built.watched_places.push_back(built.place_of_vertex[parts_->ids.vertices[v]]);
  }
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    data.fetch_state(copy);
  }
  parts_->ids.version = live.last_version + 1;
  move_state(data, built, parts_->ids);
  if (data.surface.has_begun()) {
    built.surface.begin(*parts_->compacted);
  }
  parts_->is_used = true;  // nothing fails from here on
  replace(live, std::move(tissue_data(*parts_->compacted)), parts_->ids.version);
  built.tissue = &tissue;
  built.identity = data.identity;
  built.own_tissue = std::move(data.own_tissue);
  data.leave_tissue();
  built.follow_tissue(&data);
  built.custom.take(data.custom);
  built.rebuild_plan();
  parts_->built = solver.data_.exchange(std::move(parts_->built));
  live.followers->for_each(
      [&](const FollowerList::Entry& entry) { entry.follower->renumber(tissue, parts_->ids); });
  try {
    built.free_pieces.refresh(tissue, built.place_of_vertex);
  } catch (const std::bad_alloc&) {  // the next step asks again
  }
  return parts_->ids;
}

}  // namespace pbdsurg
