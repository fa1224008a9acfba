// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How free pieces ease off what pushes them, of BDF2 with vertex blocks: see piece_easing.h.

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// At the end of a substep: as eased() (displacement.h) does for vertices, makes each touched piece
/// no faster away from what pushes it than on its way, and forget that it became so. It goes by the
/// rigid motion that the pushes of its contacts give it, and tools feel the momentum that this
/// takes. Two pieces that push each other go by the motion that these pushes give both, so theirs
/// together stays.
void ease_pieces(const StepContext& step);

}  // namespace pbdsurg
