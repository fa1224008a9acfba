// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes for tests.

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::testing {

/// One body, with the ids of its mesh.
inline Scene scene_of(const TetMesh& mesh) {
  Scene scene;
  scene.add_body("body", mesh);
  return scene;
}

}  // namespace pbdsurg::testing
