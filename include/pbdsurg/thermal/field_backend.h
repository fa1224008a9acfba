// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who solves the linear systems of heat and potential.

#include <cstdint>

namespace pbdsurg {

/// Answers of both agree to the tolerance of the system, not to the bit; each repeats its own bits.
enum class FieldBackend : std::uint8_t {
  /// A CUDA device where there is one and a system is large enough to gain by it, else the CPU;
  /// reports say which. Opened with the first such system, which waits for that.
  automatic,
  cpu,
  /// A CUDA device, whatever the size, opened with the field: for programs that link pbdsurg::cuda
  /// (or pbdsurg::pbdsurg, which has all). The state of the tissue stays on the host.
  cuda,
};

}  // namespace pbdsurg
