// SPDX-License-Identifier: Apache-2.0
#include "solver/step_copies.h"

#include <utility>

#include "solver/solver_data.h"
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
