// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tables 2 and 3 step.

#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::bench {

/// A scene at rest and where it stands in table 2.
struct Subject {
  std::optional<int> row;  ///< of the paper's table
  std::string kind;        ///< "hollow", "surface_filled", "scene" or "lattice"
  Scene scene;
};

/// Those of table 2, kind by kind: its rows, the largest scene of table 3, a liver of a million
/// tetrahedra; or, to see it work, the smallest row alone.
/// @param notes  gets a line for each kind that cannot be made here
[[nodiscard]] std::vector<Subject> make_table2_subjects(bool quick,
                                                        std::vector<std::string>& notes);

/// A liver of about so many vertices.
[[nodiscard]] TetMesh make_liver(Index vertices);

/// A liver of a million tetrahedra.
[[nodiscard]] TetMesh make_large_liver();

/// Vertices of liver and gallbladder.
struct SceneSize {
  Index liver_vertices;
  Index gallbladder_vertices;
};

/// It has about the tetrahedra of the paper's largest scene, table 3: 19729 and 22611.
inline constexpr SceneSize kLargestScene{4320, 6600};

/// Their meshes.
struct OrganPair {
  TetMesh gallbladder;
  TetMesh liver;
};
[[nodiscard]] OrganPair make_organ_pair(const SceneSize& size);

/// Liver and gallbladder as in the demo: the liver's upper part is fixed, a membrane of links joins
/// them. The gallbladder is the first body.
/// @param model  springs as the paper's, or the moduli of the tissue library
[[nodiscard]] Scene make_liver_and_gallbladder(const OrganPair& organs,
                                               ElasticModel model = ElasticModel::springs);
[[nodiscard]] Scene make_liver_and_gallbladder(const SceneSize& size,
                                               ElasticModel model = ElasticModel::springs);

/// A liver of the library's tissue that hangs from its upper tenth.
[[nodiscard]] Scene make_sagging_liver(Index vertices);

}  // namespace pbdsurg::bench
