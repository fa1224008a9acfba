// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who steps a tissue, and by which plan.

#include <memory>

#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Data with a backend. A device that cannot step the tissue gives way to the executor that serves
/// instead of it, if there is one.
/// @param options  checked, with an executor
/// @throws BackendUnavailable  if the device cannot, and nothing serves instead
[[nodiscard]] std::unique_ptr<SolverData> make_solver_data(const Tissue& tissue,
                                                           SolverOptions options);

}  // namespace pbdsurg
