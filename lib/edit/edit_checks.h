// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an edit must fulfil.

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Refuses a bad edit, and changes nothing but a buffer. Cost: proportional to the edit, but for
/// sorting.
/// @throws InvalidArgument  see apply_edit()
void check_edit(SolverData& data, const TopologyEdit& edit);

/// Vertices that an edit leaves without tissue, ascending.
/// @param vertices  replaced
void find_stopping(const SolverData& data, const TopologyEdit& edit, std::vector<Index>& vertices);

}  // namespace pbdsurg
