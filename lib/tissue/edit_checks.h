// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an edit must fulfil.

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Refuses a bad edit, and changes nothing but a buffer. Cost: proportional to the edit, but for
/// sorting.
/// @throws InvalidArgument  see Tissue::apply()
void check_edit(TissueData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
