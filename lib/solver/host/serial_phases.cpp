// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/serial_phases.h"

#include <algorithm>
#include <type_traits>

#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/attachment.h"
#include "pbdsurg/constraints/contact.h"

#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

template <class Constraint, ProjectionMode kMode, bool kDamped>
void project_group(const StepContext& step, const ConstraintSlots<Constraint>& slots, Index group,
                   const Substep<float>& substep) {
  constexpr int kVertices = Constraint::kVertexCount;
  constexpr bool kDisplaces = kMode == ProjectionMode::compliance;
  constexpr bool kIsJoint = std::is_same_v<Constraint, StiffLinkConstraint>;
  const MovingVertices vertices = moving_vertices(step);
  const auto* const blocks = slots.blocks(group).data();
  auto* const multiplier_blocks = step.scratch.multipliers.of<Constraint>()[group].data();
  const Index count = slots.size(group);
  for (Index first = 0; first < count; first += kBlockLanes) {
    const auto& block = blocks[first / kBlockLanes];
    [[maybe_unused]] auto& stored = multiplier_blocks[first / kBlockLanes].values;
    const Index lanes = std::min(kBlockLanes, count - first);
    for (Index lane = 0; lane < lanes; ++lane) {
      Vec3<float> moving[kVertices];
      float weights[kVertices];
      for (int k = 0; k < kVertices; ++k) {
        const Particle& p = at(vertices.moving, block.corners[k][lane]);
        moving[k] = load(p);
        weights[k] = p.w;
      }
      Vec3<float> bases[kVertices];
      Vec3<float> seen[kVertices];
      if constexpr (kDisplaces) {
        for (int k = 0; k < kVertices; ++k) {
          bases[k] = load(at(vertices.bases, block.corners[k][lane]));
        }
        see_corners(bases, moving, seen);
      } else {
        std::ranges::copy(moving, seen);
      }
      float parameters[Constraint::kParameterCount];
      for (int p = 0; p < Constraint::kParameterCount; ++p) {
        parameters[p] = block.parameters[p][lane];
      }
      float multipliers[Constraint::kMultiplierCount] = {};
      Moves<float, kVertices> moves;
      [[maybe_unused]] Vec3<float> force_before;
      if constexpr (!kRemembers<Constraint, kMode>) {
        moves = Constraint::template move<kMode>(seen, weights, parameters, substep, multipliers);
      } else {
        for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
          multipliers[m] = stored[m][lane];
        }
        if constexpr (kIsJoint) {
          force_before = StiffLinkConstraint::force_of(multipliers);
        }
        if constexpr (kDamped) {
          Vec3<float> roundings[kVertices];
          for (int k = 0; k < kVertices; ++k) {
            roundings[k] = load(at(step.copy.carries.data(), block.corners[k][lane]));
          }
          Damped<float, kVertices> damping;
          see_corners(bases, roundings, damping.start);
          moves = Constraint::template move<kMode>(seen, weights, parameters, substep, multipliers,
                                                   damping);
        } else {
          moves = Constraint::template move<kMode>(seen, weights, parameters, substep, multipliers);
        }
        for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
          stored[m][lane] = multipliers[m];
        }
      }
      if constexpr (kIsJoint) {
        const Vec3<float> change = StiffLinkConstraint::force_of(multipliers) - force_before;
        Particle* const flights = step.scratch.flights.data();
        push_flight(at(flights, block.corners[0][lane]), change, weights[0],
                    substep.inverse_dt_squared);
        push_flight(at(flights, block.corners[1][lane]), -1.0F * change, weights[1],
                    substep.inverse_dt_squared);
      }
      for (int k = 0; k < kVertices; ++k) {
        const Vec3<float> moved = moving[k] + moves.of[k];
        store(at(vertices.moving, block.corners[k][lane]), moved);
        if constexpr (kDisplaces && KindOf<Constraint>::kIsOfVertexBlocks) {
          if (vertices.points != nullptr) {
            FixedPoint& point = at(vertices.points, block.corners[k][lane]);
            point = moved_point(point, moving[k], moved);
          }
        }
      }
    }
  }
}

template <class Constraint>
void project_group(const StepContext& step, const ConstraintSlots<Constraint>& slots, Index group,
                   const Substep<float>& substep) {
  using Kind = KindOf<Constraint>;
  if constexpr (Kind::kHasFraction) {
    if (step.data.options.mode == ProjectionMode::fraction) {
      project_group<Constraint, ProjectionMode::fraction, false>(step, slots, group, substep);
      return;
    }
  }
  if constexpr (Kind::kHasCompliance) {
    if (step.data.sets.has_damping) {
      project_group<Constraint, ProjectionMode::compliance, true>(step, slots, group, substep);
      return;
    }
  }
  project_group<Constraint, ProjectionMode::compliance, false>(step, slots, group, substep);
}

void project_attachments(const StepContext& step, Index color, const Substep<float>& substep) {
  const MovingVertices vertices = moving_vertices(step);
  for (ToolState& tool : step.copy.tools) {
    for (Attachment& attachment : tool.attachments) {
      if (attachment.color != color) {
        continue;
      }
      const Index place = step.data.place_of_vertex[attachment.vertex];
      Particle& p = vertices.moving[place];
      Vec3<float> x = load(p);
      Vec3<float> multiplier = load(attachment.multiplier);
      AttachmentConstraint::project<ProjectionMode::compliance>(
          x, p.w, load(attachment.target) - vertices.base(place),
          step.copy.grasp_compliance(attachment) * substep.inverse_dt_squared, multiplier);
      store(p, x);
      attachment.multiplier = {multiplier.x, multiplier.y, multiplier.z};
    }
  }
}

void project_contacts(const StepContext& step, Index tool) {
  const MovingVertices vertices = moving_vertices(step);
  for (Contact& contact : step.copy.tools[tool].contacts) {
    Particle& p = vertices.moving[contact.place];
    Vec3<float> x = load(p);
    const Vec3<float> normal = load(contact.normal);
    ContactConstraint::project(x, p.w, normal,
                               contact.offset - dot(normal, vertices.base(contact.place)),
                               contact.multiplier);
    store(p, x);
  }
}

}  // namespace

void project_serially(const StepContext& step, const Phase& phase, const Substep<float>& substep) {
  switch (phase.kind) {
    case PhaseKind::distance:
    case PhaseKind::volume:
    case PhaseKind::neo_hookean:
    case PhaseKind::fibre:
    case PhaseKind::membrane:
    case PhaseKind::strain_limit:
    case PhaseKind::bending:
    case PhaseKind::stiff_link:
      step.data.sets.visit_set(
          phase.kind, [&](auto& slots) { project_group(step, slots, phase.color, substep); });
      break;
    case PhaseKind::joint:
      // Tetrahedra of one colour share no vertex: all edges at one place, then those at the next,
      // give the bits of one tetrahedron after the other, and the processor something to overlap.
      for (Index place = 0; place < 6; ++place) {
        project_group(step, step.data.sets.of<DistanceConstraint>(),
                      step.data.sets.joint_group(phase.color, place), substep);
      }
      project_group(step, step.data.sets.of<VolumeConstraint>(), phase.color, substep);
      break;
    case PhaseKind::vertex:
      break;  // see solve_vertices()
    case PhaseKind::custom:
      break;  // see project_custom()
    case PhaseKind::attachment:
      project_attachments(step, phase.color, substep);
      break;
    case PhaseKind::contact:
      if (moves_vertices(step.data.options)) {
        answer_surface_contacts(step, substep);
      } else {
        project_contacts(step, phase.color);
        project_surface_contacts(step, phase.color);
      }
      break;
    case PhaseKind::grip:
      if (moves_vertices(step.data.options)) {
        answer_grips(step, substep);
      } else {
        project_grips(step, substep);
      }
      break;
    case PhaseKind::body_contact:
      answer_touches(step, substep);
      break;
  }
}

}  // namespace pbdsurg
