// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A world of the bytes of a file, wherever these come from.

#include "pbdsurg/base/export.h"
#include "pbdsurg/world/world.h"

#include "lib/mesh/source.h"

namespace pbdsurg {

/// @throws  as read_world()
[[nodiscard]] PBDSURG_API World world_of_bytes(const Source& file, const Executor& executor = {});

}  // namespace pbdsurg
