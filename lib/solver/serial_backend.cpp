// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>

#include "solver/contact_stage.h"
#include "solver/host_backends.h"
#include "solver/load_store.h"
#include "solver/serial_phases.h"
#include "solver/solver_data.h"
#include "solver/state_report.h"
#include "solver/vertex_method.h"

namespace pbdsurg {
namespace {

// External force, damping and prediction. Damping is implicit, so no value of it reverses a motion,
// and leaves the kick of the force alone, so that what rests on a tool weighs what it should.
void predict(SolverData& data, float h) {
  const Vec3<float> kick = h * load(data.gravity);
  const float keep = 1 / (1 + data.options.damping * h);
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    Particle& p = data.particles[v];
    data.previous[v] = p;
    if (p.w > 0) {
      const Velocity& velocity = data.velocities[v];
      store(p, load(p) + h * (keep * Vec3<float>{velocity.x, velocity.y, velocity.z} + kick));
    }
  }
}

template <class Constraint>
void reset_multipliers(ConstraintSlots<Constraint>& slots) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    const auto blocks = slots.multipliers(group);
    std::fill(blocks.begin(), blocks.end(), MultiplierBlock<Constraint>{});
  }
}

void update_velocities(SolverData& data, float h) {
  const float inverse_h = 1 / h;
  for (std::size_t v = 0; v < data.particles.size(); ++v) {
    const Vec3<float> velocity = inverse_h * (load(data.particles[v]) - load(data.previous[v]));
    data.velocities[v] = {velocity.x, velocity.y, velocity.z};
  }
}

class SerialBackend final : public Backend {
 public:
  [[nodiscard]] const char* name() const noexcept override { return "serial"; }

  void start_step(SolverData& data, float dt) override { report_ = step(data, dt); }
  StepReport finish_step(SolverState& /*state*/) override { return report_; }

  [[nodiscard]] Maker maker() const override {
    return [](const SolverData&) { return make_serial_backend(); };
  }

 private:
  static StepReport step(SolverData& data, float dt) {
    StepReport report;
    const int substeps = data.options.substeps;
    const float h = dt / static_cast<float>(substeps);
    const Substep<float> lengths{1 / h, 1 / (h * h)};
    begin_tools(data);
    for (int substep = 1; substep <= substeps; ++substep) {
      predict(data, h);
      begin_vertices(data, lengths);
      if (data.options.mode == ProjectionMode::compliance &&
          data.options.method == SolverMethod::projection) {
        data.sets.for_each_set([]<class Constraint>(ConstraintSlots<Constraint>& slots) {
          if constexpr (KindOf<Constraint>::kHasCompliance) {
            reset_multipliers(slots);
          }
        });
      }
      place_tools(data, static_cast<float>(substep) / static_cast<float>(substeps));
      find_contacts(data, report);
      hold_vertices(data);
      prepare_vertices(data, lengths);
      for (int iteration = 0; iteration < data.options.iterations; ++iteration) {
        const VertexState state =
            vertex_state(data, lengths, relaxation_of(data.options, iteration));
        for (const Phase& phase : data.plan.phases) {
          if (phase.kind == PhaseKind::vertex) {
            solve_vertices(data, state, phase.color);
          } else {
            project_serially(data, phase, lengths);
          }
        }
      }
      end_vertices(data, lengths);
      update_velocities(data, h);
      collect_tool_forces(data, lengths.inverse_dt_squared / static_cast<float>(substeps));
    }
    end_tools(data);
    report_vertices(data, report);
    report_constraints(data, report);
    report_tubes(data, report);
    return report;
  }

  StepReport report_;
};

}  // namespace

std::unique_ptr<Backend> make_serial_backend() {
  return std::make_unique<SerialBackend>();
}

}  // namespace pbdsurg
