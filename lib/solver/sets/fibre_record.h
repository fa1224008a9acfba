// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the fibres of a tetrahedron store, from the rest shape that its matrix has.

#include "pbdsurg/tissue/material.h"

#include "lib/solver/sets/constraint_numbers.h"

namespace pbdsurg {

/// @param solid  its matrix, as it is now
/// @param fibre  of positive stiffness
[[nodiscard]] Numbers<FibreConstraint> fibre_numbers(const Numbers<NeoHookeanConstraint>& solid,
                                                     const Fibre& fibre);

}  // namespace pbdsurg
