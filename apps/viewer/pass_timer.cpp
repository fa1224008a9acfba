// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/pass_timer.h"

namespace cholecystectomy {

void PassTimer::begin(const char* name) {
  end();
  glBeginQuery(GL_TIME_ELAPSED, passes_.emplace_back(Pass{name, {}}).query.name());
  is_running_ = true;
}

void PassTimer::end() {
  if (is_running_) {
    glEndQuery(GL_TIME_ELAPSED);
    is_running_ = false;
  }
}

std::vector<PassTime> PassTimer::take() {
  end();
  std::vector<PassTime> times;
  for (const Pass& pass : passes_) {
    GLuint64 nanoseconds = 0;
    glGetQueryObjectui64v(pass.query.name(), GL_QUERY_RESULT, &nanoseconds);
    times.push_back({pass.name, 1e-6 * static_cast<double>(nanoseconds)});
  }
  passes_.clear();
  return times;
}

}  // namespace cholecystectomy
