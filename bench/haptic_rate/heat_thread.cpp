// SPDX-License-Identifier: Apache-2.0
#include "bench/haptic_rate/heat_thread.h"

#include <utility>

#include "bench/support/timing.h"

namespace pbdsurg::bench {

HeatThread::HeatThread(const Solver& solver, Cautery& cautery)
    : solver_(solver), cautery_(cautery), thread_([this] { run(); }) {}

HeatThread::~HeatThread() {
  is_ending_ = true;
  started_.release();
  thread_.join();
}

void HeatThread::start(const Eigen::Vector3f& tip, const GeneratorSettings& settings, double dt) {
  tip_ = tip;
  settings_ = settings;
  heated_.dt = dt;
  is_busy_ = true;
  started_.release();
}

bool HeatThread::is_busy() {
  if (is_busy_ && finished_.try_acquire()) {
    is_busy_ = false;
    has_result_ = true;
  }
  if (!is_busy_ && failure_) {
    std::rethrow_exception(std::exchange(failure_, nullptr));
  }
  return is_busy_;
}

void HeatThread::run() {
  for (started_.acquire(); !is_ending_; started_.acquire()) {
    heated_.edit = {};
    try {
      heated_.time_ms = time_of([&] {
        heated_.report = cautery_.heat(solver_, {tip_, tip_}, settings_, heated_.dt, heated_.edit);
      });
    } catch (...) {
      failure_ = std::current_exception();
    }
    finished_.release();
  }
}

}  // namespace pbdsurg::bench
