// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long a device takes for each pass of a picture.

#include <string>
#include <vector>

#include "apps/viewer/gl_objects.h"

namespace cholecystectomy {

struct PassTime {
  std::string name;
  double milliseconds;  ///< of the device
};

/// Timer queries around the passes of one picture. Needs a current context as its renderer does.
class PassTimer {
 public:
  PassTimer() = default;
  PassTimer(const PassTimer&) = delete;
  PassTimer& operator=(const PassTimer&) = delete;
  ~PassTimer() { end(); }  // a query that runs cannot be deleted

  /// Ends the pass before, and begins one. The device is not waited for.
  void begin(const char* name);
  void end();

  /// Of the passes since the last call, in their order. Waits for the device.
  [[nodiscard]] std::vector<PassTime> take();

 private:
  struct Pass {
    std::string name;
    GlQuery query;
  };
  std::vector<Pass> passes_;
  bool is_running_ = false;
};

}  // namespace cholecystectomy
