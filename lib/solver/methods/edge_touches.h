// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Edges of two bodies, or of one, that cross: what no vertex sees where one of them is thin, or
/// both are sharp. See edge_crossing.h.

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/touch_start.h"
#include "lib/solver/state/contact_bodies.h"
#include "lib/solver/state/touch_lists.h"

namespace pbdsurg {

/// Adds edges of a pair that are within reach of each other to the candidates.
/// @param pair   of ContactBodies
/// @param reach  m
void find_edges(const TouchStart& start, const ContactBodies& bodies, Index pair, float reach,
                TissueTouches::Search& search);

/// Adds their contact, if they meet.
/// @param limit      m, what is no nearer does not count
/// @param nearer_by  m, than the candidate was
void meet_edges(const TouchStart& start, const ContactBodies& bodies,
                const EdgeCandidate& candidate, float limit, float nearer_by);

}  // namespace pbdsurg
