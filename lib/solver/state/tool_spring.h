// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where the spring of a coupled tool lets it be: see coupled_tool.h.

#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

struct ToolSpring {
  Vec3<float> displacement;  ///< m, of the tool, from where it is to be: as the substep begins
  Vec3<float> shift;         ///< m, that the substep adds to it
  float yield = 0;           ///< 1/kg, in the substep
};

}  // namespace pbdsurg
