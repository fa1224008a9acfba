// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The sensor of the emulated handle.

#include "pbdsurg/haptics/handle.h"

namespace pbdsurg::testing {

/// What the emulated handle's sensor reads, with 6 bits more.
inline constexpr JawRange kEmulatedRange{.closed = 900 * 64, .open = 100 * 64};

}  // namespace pbdsurg::testing
