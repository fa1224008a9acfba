// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Heat in a thread of its own, beside the steps of a solver.

#include <Eigen/Core>
#include <exception>
#include <semaphore>
#include <thread>
#include <utility>

#include "pbdsurg/heat/generator.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::bench {

/// What the heat of some steps asks for.
struct Heated {
  TopologyEdit edit;
  CauteryReport report;
  double time_ms = 0;  ///< that it took
  double dt = 0;       ///< s that it stands for
};

/// While it is busy, its owner may step the solver, but change no tissue.
class HeatThread {
 public:
  HeatThread(const Solver& solver, Cautery& cautery);
  ~HeatThread();
  HeatThread(const HeatThread&) = delete;
  HeatThread& operator=(const HeatThread&) = delete;

  /// After Cautery::read_positions(), while it is not busy.
  void start(const Eigen::Vector3f& tip, const GeneratorSettings& settings, double dt);
  /// Waits for nothing.
  /// @throws Error  whatever heat threw
  [[nodiscard]] bool is_busy();
  /// Of what was started last, while it is not busy: once, then null, as before the first.
  [[nodiscard]] Heated* take_result() {
    return std::exchange(has_result_, false) ? &heated_ : nullptr;
  }

 private:
  void run();

  const Solver& solver_;
  Cautery& cautery_;
  Eigen::Vector3f tip_{0, 0, 0};
  GeneratorSettings settings_;
  Heated heated_;
  std::exception_ptr failure_;
  bool is_busy_ = false, has_result_ = false, is_ending_ = false;
  std::binary_semaphore started_{0}, finished_{0};
  std::thread thread_;  // last: it uses the others
};

}  // namespace pbdsurg::bench
