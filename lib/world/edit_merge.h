// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One edit of what several ask for.

#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

[[nodiscard]] bool is_empty(const TopologyEdit& edit) noexcept;

/// Adds a request to an edit, but for removals that it has already. At most one of the two may
/// bring vertices, tetrahedra, links or bodies, whose ids both would give away.
/// @return  whether that was so; else nothing was added
bool merge(TopologyEdit& edit, const TopologyEdit& request);

}  // namespace pbdsurg
