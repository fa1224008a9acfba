// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Colours that nothing has.

#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Renumbers the colours that occur as 0, 1, ... in the same order, and counts them.
void close_color_gaps(Coloring& coloring);

}  // namespace pbdsurg
