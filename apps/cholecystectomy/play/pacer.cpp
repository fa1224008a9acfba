// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/pacer.h"

#include <algorithm>

namespace cholecystectomy {

void Pacer::set_speed(double speed, double now) {
  if (speed != speed_) {
    speed_ = speed;
    next_ = now;
    begin_window(now);
  }
}

void Pacer::took_step(double now) {
  next_ = std::max(next_ + time_step_ / speed_, now - kMostOwed);
  ++window_steps_;
  const double length = now - window_start_;
  if (length >= kWindow) {
    factor_ = std::min(window_steps_ * time_step_ / (speed_ * length), 1.0);
    begin_window(now);
  }
}

void Pacer::begin_window(double now) {
  window_start_ = now;
  window_steps_ = 0;
}

}  // namespace cholecystectomy
