// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>

#include "lib/solver/host/host_backends.h"
#include "lib/solver/host/serial_step.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/state_report.h"

namespace pbdsurg {
namespace {

class SerialBackend final : public Backend {
 public:
  [[nodiscard]] const char* name() const noexcept override { return "serial"; }

  void start_step(SolverData& data) override {
    data.step_scratch.fit(data);
    for (Index i = 0; i < data.copy_count(); ++i) {
      data.copy(i).last_report = {};
    }
    step_part(data);
    while (!data.part.is_last()) {
      data.go_on(stiffest(data));
      step_part(data);
    }
    report_ = {};
    for (Index i = 0; i < data.copy_count(); ++i) {
      report_copy(i, data.copy(i).last_report, data.copy(i), report_);
    }
  }
  StepReport finish_step(SolverState& /*state*/) override { return report_; }

  [[nodiscard]] Maker maker() const override {
    return [](const SolverData&) { return make_serial_backend(); };
  }

 private:
  void step_part(SolverData& data) {
    for (Index i = 0; i < data.copy_count(); ++i) {
      step_serially({data, data.copy(i), data.step_scratch, i}, data.copy(i).last_report);
    }
  }

  StepReport report_;
};

}  // namespace

float Backend::stiffest(SolverData& data) {
  float largest = 0;
  for (Index i = 0; i < data.copy_count(); ++i) {
    largest = std::max(largest, stiffest_vertex(data, data.copy(i)));
  }
  return largest;
}

std::unique_ptr<Backend> make_serial_backend() {
  return std::make_unique<SerialBackend>();
}

}  // namespace pbdsurg
