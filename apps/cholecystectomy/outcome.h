// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Whether what was run was the operation.

#include <vector>

#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/warning.h"

namespace cholecystectomy {

/// What went wrong in a run, for `warnings[]`. Failures: the script could not go on; an instrument
/// never felt tissue; heat removed neither a tetrahedron nor a strand; an organ has no tissue left,
/// or no strands lead from it to one that is held in place. An interrupted run is judged by its
/// organs alone.
std::vector<Warning> judge(const Simulation& simulation, const Course& course);

}  // namespace cholecystectomy
