// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The anatomy as a scene: materials, what is held, what is joined to what.

#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/scene.h"

#include "apps/cholecystectomy/organ_files.h"
#include "apps/cholecystectomy/warning.h"

namespace cholecystectomy {

using pbdsurg::Organ;

/// Bodies are added in the order of pbdsurg::kOrgans, which is that of the enumerators.
constexpr pbdsurg::BodyId body_of(Organ organ) {
  return pbdsurg::BodyId(static_cast<pbdsurg::Index>(organ));
}

/// What an organ is made of.
/// @throws InvalidArgument  if there is no such organ
[[nodiscard]] const pbdsurg::TissueRecord& tissue_of(Organ organ);

/// Connective tissue between two organs.
struct JoinedPair {
  Organ first, second;
  pbdsurg::Index link_count;
  pbdsurg::Index fibre_count;  ///< a link of a user's coarse mesh stands for several
};

struct SurgicalScene {
  pbdsurg::Scene scene;
  std::vector<pbdsurg::TissueRecord> tissues;  ///< [body]
  pbdsurg::ConnectiveTissue connections;       ///< all links: strand i is link i
  std::vector<JoinedPair> joined;              ///< in the order of their links
  pbdsurg::Index membrane_link_count = 0;      ///< links [0, n) join gallbladder and liver
  pbdsurg::MeshData membrane;                  ///< triangles between them: point i is on link i
  std::vector<pbdsurg::Triangle> sheets;       ///< of links, the same of every joint
  std::vector<Warning> warnings;               ///< organs that hang on too little
};

/// Adds bodies, fixes the liver's upper part and the far ends of vessels and ducts, and links
/// surfaces that lie close: the membrane between gallbladder and liver first.
/// @param model  of all bodies
SurgicalScene make_scene(const LoadedAnatomy& loaded, pbdsurg::ElasticModel model);

}  // namespace cholecystectomy
