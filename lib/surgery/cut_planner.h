// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Plans a cut on plain arrays.

#include "pbdsurg/surgery/cut.h"

#include "lib/surgery/cut_neighborhood.h"

namespace pbdsurg {

/// See the public function of this name.
[[nodiscard]] CutPlan plan_cut(const CutTissue& tissue, const CutSurface& surface,
                               const CutOptions& options);

}  // namespace pbdsurg
