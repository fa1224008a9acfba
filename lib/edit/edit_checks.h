// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an edit must fulfil.

#include <span>

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Refuses a bad edit, and changes nothing but a buffer. Cost: proportional to the edit, but for
/// sorting.
/// @return  vertices that the edit leaves without tissue, ascending, in that buffer
/// @throws InvalidArgument  see apply_edit()
std::span<const Index> check_edit(SolverData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
