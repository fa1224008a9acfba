// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include <hwy/targets.h>

namespace pbdsurg::testing {

/// While it lives, solvers that are made use no more than one instruction set: "AVX-512", "AVX2" or
/// "SSSE3". Their backend_name() says which they use.
class InstructionSet {
 public:
  explicit InstructionSet(const std::string& name) {
    std::int64_t disabled = 0;
    if (name == "AVX2" || name == "SSSE3") {
      disabled |= HWY_AVX3;
    }
    if (name == "SSSE3") {
      disabled |= HWY_AVX2;
    }
    hwy::DisableTargets(disabled);
  }
  ~InstructionSet() { hwy::DisableTargets(0); }
  InstructionSet(const InstructionSet&) = delete;
  InstructionSet& operator=(const InstructionSet&) = delete;
};

}  // namespace pbdsurg::testing
