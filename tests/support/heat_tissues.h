// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissues that tests of heat warm.

#include "pbdsurg/tissue/library.h"

namespace pbdsurg::testing {

/// What most tests of heat warm.
inline const ThermalProperties& kLiver = tissues::liver().heat;
inline const ThermalProperties& kFat = tissues::fat().heat;

}  // namespace pbdsurg::testing
