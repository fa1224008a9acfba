// SPDX-License-Identifier: Apache-2.0
#include "solver/backend.h"

#include <utility>

#include "solver/solver_data.h"
#include "solver/solver_input.h"
#include "solver/state_report.h"

namespace pbdsurg {
namespace {

/// While it lives, a copy's state is at hand.
class AtHand {
 public:
  AtHand(SolverData& data, Index copy) : data_(data), other_(data.copy(copy)) { swap(); }
  ~AtHand() { swap(); }
  AtHand(const AtHand&) = delete;
  AtHand& operator=(const AtHand&) = delete;

 private:
  void swap() noexcept {
    if (&other_ != &data_) {
      std::swap(data_, other_);
    }
  }

  CopyState& data_;
  CopyState& other_;
};

}  // namespace

void Backend::fetch_state(SolverData& /*data*/, Index /*copy*/) {}

void Backend::read_positions(const SolverData& data, Index copy, std::span<const Index> places,
                             std::span<Eigen::Vector3f> out) {
  const std::vector<Particle>& particles = data.copy(copy).particles;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Particle& p = particles[places[i]];
    out[i] = {p.x, p.y, p.z};
  }
}

Backend::Maker Backend::maker() const {
  return [](const SolverData& data) { return make_host_backend(data.options); };
}

StepReport step_copies(SolverData& data, Backend& backend, float dt) {
  StepReport report;
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    const AtHand at_hand(data, copy);
    backend.start_step(data, dt);
    report_copy(copy, backend.finish_step(data), data, report);
  }
  return report;
}

}  // namespace pbdsurg
