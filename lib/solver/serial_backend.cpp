// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "pbdsurg/constraints/attachment.h"
#include "pbdsurg/constraints/contact.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/core/vec3.h"

#include "solver/backend.h"
#include "solver/contact_stage.h"
#include "solver/solver_data.h"

namespace pbdsurg {
namespace {

Vec3<float> load(const Particle& p) {
  return {p.x, p.y, p.z};
}
Vec3<float> load(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

void store(Particle& p, const Vec3<float>& x) {
  p.x = x.x;
  p.y = x.y;
  p.z = x.z;
}

// External force, damping and prediction. Damping is implicit, so no value of it reverses a motion,
// and leaves the kick of the force alone, so that what rests on a tool weighs what it should.
void predict(SolverData& data, float h) {
  const Eigen::Vector3f kick = h * data.gravity;
  const float keep = 1 / (1 + data.options.damping * h);
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    Particle& p = data.particles[v];
    data.previous[v] = {p.x, p.y, p.z};
    if (p.w > 0) {
      const Eigen::Vector3f velocity = keep * data.velocities[v] + kick;
      p.x += h * velocity.x();
      p.y += h * velocity.y();
      p.z += h * velocity.z();
    }
  }
}

template <class Constraint, ProjectionMode kMode, std::size_t kArity>
void project_group(std::vector<Particle>& particles, ConstraintSlots<kArity>& slots, Index group,
                   float inverse_dt_squared) {
  Particle* const x = particles.data();
  const std::span<const ConstraintRecord<kArity>> records = slots.records(group);
  float* const multipliers = slots.multipliers(group).data();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const ConstraintRecord<kArity>& record = records[i];
    Vec3<float> points[kArity];
    float weights[kArity];
    for (std::size_t k = 0; k < kArity; ++k) {
      const Particle& p = x[record.vertices[k]];
      points[k] = load(p);
      weights[k] = p.w;
    }
    if constexpr (kMode == ProjectionMode::fraction) {
      float unused = 0;  // this mode has no memory
      Constraint::template project<kMode>(points, weights, record.rest, record.stiffness, unused);
    } else {
      Constraint::template project<kMode>(points, weights, record.rest,
                                          record.stiffness * inverse_dt_squared, multipliers[i]);
    }
    for (std::size_t k = 0; k < kArity; ++k) {
      store(x[record.vertices[k]], points[k]);
    }
  }
}

// Tetrahedra of one colour share no vertex: all edges at one place, then those at the next, give
// the bits of one tetrahedron after the other, and the processor something to overlap.
template <ProjectionMode kMode>
void project_joint(SolverData& data, Index color, float inverse_dt_squared) {
  for (Index place = 0; place < 6; ++place) {
    project_group<DistanceConstraint, kMode>(data.particles, data.distances,
                                             data.joint_group(color, place), inverse_dt_squared);
  }
  project_group<VolumeConstraint, kMode>(data.particles, data.volumes, color, inverse_dt_squared);
}

void project_attachments(SolverData& data, Index color, float inverse_dt_squared) {
  for (ToolState& tool : data.tools) {
    for (Attachment& attachment : tool.attachments) {
      if (attachment.color != color) {
        continue;
      }
      Particle& p = data.particles[attachment.vertex];
      Vec3<float> x = load(p);
      Vec3<float> multiplier = load(attachment.multiplier);
      AttachmentConstraint::project<ProjectionMode::compliance>(
          x, p.w, load(attachment.target), attachment.compliance * inverse_dt_squared, multiplier);
      store(p, x);
      attachment.multiplier = {multiplier.x, multiplier.y, multiplier.z};
    }
  }
}

void project_contacts(SolverData& data, Index tool) {
  for (Contact& contact : data.tools[tool].contacts) {
    Particle& p = data.particles[contact.vertex];
    Vec3<float> x = load(p);
    ContactConstraint::project(x, p.w, load(contact.normal), contact.offset, contact.multiplier);
    store(p, x);
  }
}

template <ProjectionMode kMode>
void sweep(SolverData& data, float inverse_dt_squared) {
  for (const Phase& phase : data.plan.phases) {
    switch (phase.kind) {
      case PhaseKind::distance:
        project_group<DistanceConstraint, kMode>(data.particles, data.distances, phase.color,
                                                 inverse_dt_squared);
        break;
      case PhaseKind::volume:
        project_group<VolumeConstraint, kMode>(data.particles, data.volumes, phase.color,
                                               inverse_dt_squared);
        break;
      case PhaseKind::joint:
        project_joint<kMode>(data, phase.color, inverse_dt_squared);
        break;
      case PhaseKind::neo_hookean:
      case PhaseKind::strain_limit:
      case PhaseKind::vertex:
        break;  // not in any plan yet
      case PhaseKind::attachment:
        project_attachments(data, phase.color, inverse_dt_squared);
        break;
      case PhaseKind::contact:
        project_contacts(data, phase.color);
        break;
    }
  }
}

void update_velocities(SolverData& data, float h) {
  const float inverse_h = 1 / h;
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    const Particle& p = data.particles[v];
    data.velocities[v] = inverse_h * (Eigen::Vector3f(p.x, p.y, p.z) - data.previous[v]);
  }
}

void report_vertices(const SolverData& data, StepReport& report) {
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    const Particle& p = data.particles[v];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      if (report.non_finite_vertices++ == 0) {
        report.first_non_finite = static_cast<Index>(v);
      }
    }
  }
}

template <class Constraint, std::size_t kArity, class Visit>
void for_each_value(const SolverData& data, const ConstraintSlots<kArity>& slots, Visit visit) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    for (const ConstraintRecord<kArity>& record : slots.records(group)) {
      Vec3<float> points[kArity];
      for (std::size_t k = 0; k < kArity; ++k) {
        points[k] = load(data.particles[record.vertices[k]]);
      }
      visit(Constraint::value(points, record.rest), record.rest);
    }
  }
}

// A residual that is not a number counts as infinite: it must not hide behind the finite ones.
void raise(float& largest, float value) {
  largest =
      std::isfinite(value) ? std::max(largest, value) : std::numeric_limits<float>::infinity();
}

void report_constraints(const SolverData& data, StepReport& report) {
  for_each_value<DistanceConstraint>(data, data.distances, [&](float value, float rest) {
    if (rest > 0) {
      raise(report.distance_residual, std::abs(value) / rest);
    }
  });
  for_each_value<VolumeConstraint>(data, data.volumes, [&](float value, float rest) {
    raise(report.volume_residual, std::abs(value) / rest);
    report.inverted_tets += value + rest < 0;
  });
  // tubes have no volume constraints, but can be inverted all the same
  for (const Body& body : data.bodies) {
    if (body.material.has_volume_constraints) {
      continue;
    }
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      Vec3<float> points[4];
      for (int k = 0; k < 4; ++k) {
        points[k] = load(data.particles[data.tets[t][k]]);
      }
      report.inverted_tets += data.tet_alive[t] && VolumeConstraint::value(points, 0.0F) < 0;
    }
  }
}

class SerialBackend final : public Backend {
 public:
  [[nodiscard]] const char* name() const noexcept override { return "serial"; }

  StepReport step(SolverData& data, float dt) override {
    StepReport report;
    const int substeps = data.options.substeps;
    const float h = dt / static_cast<float>(substeps);
    const float inverse_dt_squared = 1 / (h * h);
    begin_tools(data);
    for (int substep = 1; substep <= substeps; ++substep) {
      predict(data, h);
      if (data.options.mode == ProjectionMode::compliance) {
        data.distances.reset_multipliers();
        data.volumes.reset_multipliers();
      }
      place_tools(data, static_cast<float>(substep) / static_cast<float>(substeps));
      find_contacts(data, report);
      for (int iteration = 0; iteration < data.options.iterations; ++iteration) {
        if (data.options.mode == ProjectionMode::fraction) {
          sweep<ProjectionMode::fraction>(data, inverse_dt_squared);
        } else {
          sweep<ProjectionMode::compliance>(data, inverse_dt_squared);
        }
      }
      update_velocities(data, h);
      collect_tool_forces(data, inverse_dt_squared / static_cast<float>(substeps));
    }
    end_tools(data);
    report_vertices(data, report);
    report_constraints(data, report);
    return report;
  }
};

}  // namespace

std::unique_ptr<Backend> make_serial_backend() {
  return std::make_unique<SerialBackend>();
}

}  // namespace pbdsurg
