// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an edit must fulfil.

#include <span>

#include "tissue/tissue_data.h"

namespace pbdsurg {

/// Refuses a bad edit, and changes nothing but a buffer. Cost: proportional to the edit, but for
/// sorting.
/// @return  vertices that the edit leaves without tissue, ascending, in that buffer
/// @throws InvalidArgument  see Tissue::apply()
std::span<const Index> check_edit(TissueData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
