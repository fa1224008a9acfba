// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an automatic coarse correction is.

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// On where it lets vertex blocks do with fewer substeps, see CoarseCorrection; any other than an
/// automatic one stays. Cost: O(V + edges).
/// @param options  with the method that was chosen
[[nodiscard]] PBDSURG_API CoarseCorrection coarse_correction_for(const Tissue& tissue,
                                                                 const SolverOptions& options);

/// Whether a CoarseSpace has a node for each piece of tissue. Any other piece moves by sweeps
/// alone.
[[nodiscard]] PBDSURG_API bool has_node_for_each_piece(const Tissue& tissue);

/// Whether an end of a link is a vertex of a sheet, which takes no part in a coarse correction.
[[nodiscard]] bool leads_to_sheet(const Tissue& tissue, Index link);

}  // namespace pbdsurg
