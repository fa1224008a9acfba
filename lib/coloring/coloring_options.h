// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every backend refuses alike.

#include "pbdsurg/coloring/color.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the option out of range
void check_coloring_options(const ColoringOptions& options);

}  // namespace pbdsurg
