// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a person is told of the devices in both hands.

#include <array>
#include <string>
#include <vector>

#include "apps/cholecystectomy/play/texts.h"
#include "apps/rig/rig.h"

namespace cholecystectomy {

class RigWatch {
 public:
  explicit RigWatch(const Texts& texts) : texts_(texts) {}

  /// What happened to a hand since the last call, each in a sentence.
  [[nodiscard]] std::vector<std::string> update(rig::Side side, const rig::HandStatus& status);

  /// How it is now, for a panel; empty for a mouse.
  [[nodiscard]] std::string line(rig::Side side, const rig::HandStatus& status) const;

 private:
  const Texts& texts_;
  static constexpr double kSpell = 1;  // s: what repeats within is one spell

  std::array<rig::HandStatus, 2> before_;         // [side]
  std::array<double, 2> warm_{-kSpell, -kSpell};  // s, [side]: when motors were last
};

}  // namespace cholecystectomy
