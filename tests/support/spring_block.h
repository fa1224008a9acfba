// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A block of springs.

#include <array>

#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/scene.h"

#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {

/// A block held at one side, of the stiffest springs, or where the vertex-block method has to
/// follow them, of soft ones.
inline Scene make_spring_block(std::array<Index, 3> cells = {6, 5, 5},
                               SolverMethod method = SolverMethod::projection) {
  const TetMesh mesh = make_box(cells, kEventfulEdge, 0.1);
  Scene scene;
  scene.add_body(
      "block", mesh,
      method == SolverMethod::vertex_block ? elastic_material(mesh, 1000, 20e3) : kSprings);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  return scene;
}

/// A small block of the stiffest springs that nothing holds.
inline Scene make_free_spring_block() {
  Scene scene;
  scene.add_body("block", make_box({3, 3, 3}, kEventfulEdge, 0.1), kSprings);
  return scene;
}

}  // namespace pbdsurg::testing
