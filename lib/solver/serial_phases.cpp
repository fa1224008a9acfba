// SPDX-License-Identifier: Apache-2.0
#include "solver/serial_phases.h"

#include <algorithm>

#include "pbdsurg/constraints/attachment.h"
#include "pbdsurg/constraints/contact.h"
#include "pbdsurg/core/vec3.h"

#include "solver/load_store.h"

namespace pbdsurg {
namespace {

template <class Constraint, ProjectionMode kMode, bool kDamped>
void project_group(SolverData& data, ConstraintSlots<Constraint>& slots, Index group,
                   const Substep<float>& substep) {
  constexpr int kVertices = Constraint::kVertexCount;
  Particle* const particles = data.particles.data();
  const auto* const blocks = slots.blocks(group).data();
  auto* const multiplier_blocks = slots.multipliers(group).data();
  const Index count = slots.size(group);
  for (Index first = 0; first < count; first += kBlockLanes) {
    const auto& block = blocks[first / kBlockLanes];
    [[maybe_unused]] auto& stored = multiplier_blocks[first / kBlockLanes].values;
    const Index lanes = std::min(kBlockLanes, count - first);
    for (Index lane = 0; lane < lanes; ++lane) {
      Vec3<float> points[kVertices];
      float weights[kVertices];
      for (int k = 0; k < kVertices; ++k) {
        const Particle& p = at(particles, block.corners[k][lane]);
        points[k] = load(p);
        weights[k] = p.w;
      }
      float parameters[Constraint::kParameterCount];
      for (int p = 0; p < Constraint::kParameterCount; ++p) {
        parameters[p] = block.parameters[p][lane];
      }
      float multipliers[Constraint::kMultiplierCount] = {};
      if constexpr (kMode == ProjectionMode::fraction) {  // has no memory
        Constraint::template project<kMode>(points, weights, parameters, substep, multipliers);
      } else {
        for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
          multipliers[m] = stored[m][lane];
        }
        if constexpr (kDamped) {
          Damped<float, kVertices> damping;
          for (int k = 0; k < kVertices; ++k) {
            damping.start[k] = load(at(data.previous.data(), block.corners[k][lane]));
          }
          Constraint::template project<kMode>(points, weights, parameters, substep, multipliers,
                                              damping);
        } else {
          Constraint::template project<kMode>(points, weights, parameters, substep, multipliers);
        }
        for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
          stored[m][lane] = multipliers[m];
        }
      }
      for (int k = 0; k < kVertices; ++k) {
        store(at(particles, block.corners[k][lane]), points[k]);
      }
    }
  }
}

template <class Constraint>
void project_group(SolverData& data, ConstraintSlots<Constraint>& slots, Index group,
                   const Substep<float>& substep) {
  using Kind = KindOf<Constraint>;
  if constexpr (Kind::kHasFraction) {
    if (!Kind::kHasCompliance || data.options.mode == ProjectionMode::fraction) {
      project_group<Constraint, ProjectionMode::fraction, false>(data, slots, group, substep);
      return;
    }
  }
  if constexpr (Kind::kHasCompliance) {
    if (data.sets.has_damping) {
      project_group<Constraint, ProjectionMode::compliance, true>(data, slots, group, substep);
    } else {
      project_group<Constraint, ProjectionMode::compliance, false>(data, slots, group, substep);
    }
  }
}

void project_attachments(SolverData& data, Index color, const Substep<float>& substep) {
  for (ToolState& tool : data.tools) {
    for (Attachment& attachment : tool.attachments) {
      if (attachment.color != color) {
        continue;
      }
      Particle& p = data.particle(attachment.vertex);
      Vec3<float> x = load(p);
      Vec3<float> multiplier = load(attachment.multiplier);
      AttachmentConstraint::project<ProjectionMode::compliance>(
          x, p.w, load(attachment.target), attachment.compliance * substep.inverse_dt_squared,
          multiplier);
      store(p, x);
      attachment.multiplier = {multiplier.x, multiplier.y, multiplier.z};
    }
  }
}

void project_contacts(SolverData& data, Index tool) {
  for (Contact& contact : data.tools[tool].contacts) {
    Particle& p = data.particles[contact.place];
    Vec3<float> x = load(p);
    ContactConstraint::project(x, p.w, load(contact.normal), contact.offset, contact.multiplier);
    store(p, x);
  }
}

}  // namespace

void project_serially(SolverData& data, const Phase& phase, const Substep<float>& substep) {
  switch (phase.kind) {
    case PhaseKind::distance:
    case PhaseKind::volume:
    case PhaseKind::neo_hookean:
    case PhaseKind::strain_limit:
    case PhaseKind::bending:
      data.sets.visit_set(phase.kind,
                          [&](auto& slots) { project_group(data, slots, phase.color, substep); });
      break;
    case PhaseKind::joint:
      // Tetrahedra of one colour share no vertex: all edges at one place, then those at the next,
      // give the bits of one tetrahedron after the other, and the processor something to overlap.
      for (Index place = 0; place < 6; ++place) {
        project_group(data, data.sets.of<DistanceConstraint>(),
                      data.sets.joint_group(phase.color, place), substep);
      }
      project_group(data, data.sets.of<VolumeConstraint>(), phase.color, substep);
      break;
    case PhaseKind::vertex:
      break;  // see solve_vertices()
    case PhaseKind::attachment:
      project_attachments(data, phase.color, substep);
      break;
    case PhaseKind::contact:
      project_contacts(data, phase.color);
      break;
  }
}

}  // namespace pbdsurg
