// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bodies that come into living tissue.

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Adds a scene's bodies, without its links and hinges, behind all that is there. Cost:
/// proportional to them.
void add_bodies(TissueData& data, const Scene& scene);

}  // namespace pbdsurg
