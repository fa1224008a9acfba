// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The anatomy as a scene: materials, what is held, what is joined to what.

#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/core/types.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/thermal/tissue.h"

namespace cholecystectomy {

using pbdsurg::Organ;

/// Bodies are added in the order of pbdsurg::kOrgans, which is that of the enumerators.
constexpr pbdsurg::Index body_of(Organ organ) {
  return static_cast<pbdsurg::Index>(organ);
}

struct SurgicalScene {
  pbdsurg::Scene scene;
  std::vector<pbdsurg::TetMesh> meshes;            ///< [body]
  std::vector<pbdsurg::TissueProperties> tissues;  ///< [body]
  pbdsurg::ConnectiveTissue connections;           ///< all links: strand i is link i
  pbdsurg::Index membrane_link_count = 0;          ///< links [0, n) join gallbladder and liver
  pbdsurg::MeshData membrane;                      ///< triangles between them: point i is on link i
};

/// Adds bodies, fixes the liver's upper part and the far ends of vessels and ducts, and links
/// surfaces that lie close: the membrane between gallbladder and liver first.
SurgicalScene make_scene(const pbdsurg::CholecystectomyAnatomy& anatomy);

}  // namespace cholecystectomy
