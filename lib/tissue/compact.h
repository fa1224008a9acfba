// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Copies of a tissue, as it is and without what is dead in it.

#include <memory>

#include "pbdsurg/tissue/renumbering.h"
#include "pbdsurg/tissue/scene.h"

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Bodies, vertices and elements, without what of these is at a vertex: all that compact() reads.
/// Cost: O(all that there ever was), of memory bandwidth.
[[nodiscard]] std::unique_ptr<TissueData> copy_of_elements(const TissueData& data);

/// All of a tissue but its followers and the undo of its last edit: another tissue. Cost: likewise.
[[nodiscard]] std::unique_ptr<TissueData> copy_of(const TissueData& data);

/// The scene that a tissue was made of, before any edit. Cost: likewise.
[[nodiscard]] Scene scene_of(const TissueData& data);

/// What lives, with new ids: in the order of bodies, and within a body in that of the old ids.
/// @param ids  filled, but for versions
[[nodiscard]] std::unique_ptr<TissueData> compact(const TissueData& data, Renumbering& ids);

/// Puts compacted tissue in the place of what it was made of. No edit can be undone any more.
void replace(TissueData& data, TissueData&& compacted, std::uint64_t version);

}  // namespace pbdsurg
