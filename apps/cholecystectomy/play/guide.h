// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The first minute: one hint at a time, until it was done.

#include <cstddef>

#include "apps/cholecystectomy/play/controls.h"
#include "apps/cholecystectomy/play/scene_state.h"

namespace cholecystectomy {

class Guide {
 public:
  static constexpr std::size_t kHints = 6;  ///< as many as Texts::guide
  static constexpr double kFarewell = 6;    ///< s, for which the last words stay

  /// Goes on where a hint was followed. @param now  s of the clock
  void update(const SceneState& state, const Controls& controls, const Scope& scope, double now);

  /// The hint in Texts::guide; kHints for the last words, and beyond when nothing is to be said.
  [[nodiscard]] std::size_t hint() const { return hint_; }

 private:
  [[nodiscard]] bool is_followed(const SceneState& state, const Controls& controls,
                                 const Scope& scope) const;

  std::size_t hint_ = 0;
  bool has_begun_ = false;
  double since_ = 0;                  // of the present hint
  Eigen::Vector3f grasper_{0, 0, 0};  // m, at its beginning
  Eigen::Vector3f view_{0, 0, 0};
};

}  // namespace cholecystectomy
