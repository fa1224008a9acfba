// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>

#include "solver/contact_stage.h"
#include "solver/host_backends.h"
#include "solver/load_store.h"
#include "solver/serial_phases.h"
#include "solver/solver_data.h"
#include "solver/state_report.h"
#include "solver/step_program.h"
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
void clear_multipliers(ConstraintSlots<Constraint>& slots) {
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

// What each operation of a step means.
class SerialStep {
 public:
  SerialStep(SolverData& data, float dt)
      : data_(data),
        h_(dt / static_cast<float>(data.options.substeps)),
        lengths_{1 / h_, 1 / (h_ * h_)} {}

  StepReport run() {
    begin_tools(data_);
    run_step(step_program(data_.options),
             [&](StepOperation operation, int substep) { run(operation, substep); });
    end_tools(data_);
    report_vertices(data_, report_);
    report_constraints(data_, report_);
    report_tubes(data_, report_);
    return report_;
  }

 private:
  void run(StepOperation operation, int substep) {
    const auto substeps = static_cast<float>(data_.options.substeps);
    switch (operation) {
      case StepOperation::predict:
        predict(data_, h_);
        break;
      case StepOperation::extrapolate:
        extrapolate_vertices(data_, lengths_);
        break;
      case StepOperation::clear_multipliers:
        data_.sets.for_each_set([]<class Constraint>(ConstraintSlots<Constraint>& slots) {
          if constexpr (KindOf<Constraint>::kHasCompliance) {
            clear_multipliers(slots);
          }
        });
        break;
      case StepOperation::find_contacts:
        place_tools(data_, static_cast<float>(substep + 1) / substeps);
        find_contacts(data_, report_);
        break;
      case StepOperation::gather_holds:
        gather_holds(data_);
        break;
      case StepOperation::damp_rows:
        damp_rows(data_, lengths_);
        break;
      case StepOperation::sweep:
        for (int iteration = 0; iteration < data_.options.iterations; ++iteration) {
          sweep(iteration);
        }
        break;
      case StepOperation::collect_forces:
        collect_tool_forces(data_, lengths_.inverse_dt_squared / substeps);
        break;
      case StepOperation::measure_fall:
        measure_fall(data_, lengths_);
        break;
      case StepOperation::update_velocities:
        update_velocities(data_, h_);
        break;
    }
  }

  void sweep(int iteration) {
    const VertexState state =
        vertex_state(data_, lengths_, relaxation_of(data_.options, iteration));
    for (const Phase& phase : data_.plan.phases) {
      if (phase.kind == PhaseKind::vertex) {
        solve_vertices(data_, state, phase.color);
      } else {
        project_serially(data_, phase, lengths_);
      }
    }
  }

  SolverData& data_;
  float h_;  // s
  Substep<float> lengths_;
  StepReport report_;
};

class SerialBackend final : public Backend {
 public:
  [[nodiscard]] const char* name() const noexcept override { return "serial"; }

  void start_step(SolverData& data, float dt) override { report_ = SerialStep(data, dt).run(); }
  StepReport finish_step(SolverState& /*state*/) override { return report_; }

  [[nodiscard]] Maker maker() const override {
    return [](const SolverData&) { return make_serial_backend(); };
  }

 private:
  StepReport report_;
};

}  // namespace

std::unique_ptr<Backend> make_serial_backend() {
  return std::make_unique<SerialBackend>();
}

}  // namespace pbdsurg
