// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Small scenes to be edited.

#include <span>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::testing {

/// A scene to be edited.
struct EditScene {
  std::string name;
  Scene scene;
  ConnectiveTissue strands{};
};

/// Few tetrahedra each, so that thousands of trials take seconds: a lattice, a mesh of vertices
/// with many or few neighbours, an organ, bodies with and without volumes joined by links, solids
/// and a thread of particles, bodies joined by strands, hinged bodies, sheets, fibres. Built once.
[[nodiscard]] const std::vector<EditScene>& edit_scenes();

/// Ways of solving that a scene allows, one for each way in which constraints are kept.
[[nodiscard]] std::vector<SolverOptions> edit_options(const EditScene& scene);

}  // namespace pbdsurg::testing
