// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the paper's tables are measured on.

#include <list>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg::bench {

/// A mesh of the table 2 family and its constraints.
struct Sample {
  /// @throws BackendUnavailable  see table2_mesh()
  Sample(int table2_row, Table2Kind table2_kind);

  int row;
  Table2Kind kind;
  TetMesh mesh;
  std::vector<Edge> edges;
  int max_owned;  ///< most edges of one tetrahedron that owns its edges

  [[nodiscard]] ConstraintVertices edge_constraints() const {
    return {std::span<const Edge>(edges), mesh.vertex_count()};
  }
  [[nodiscard]] ConstraintVertices tet_constraints() const {
    return {mesh.tets(), mesh.vertex_count()};
  }
};

/// "hollow", "surface_filled"
[[nodiscard]] const char* name_of(Table2Kind kind) noexcept;

/// Meshes kind by kind, without those kinds that cannot be made here: a line in `notes` says so.
[[nodiscard]] std::list<Sample> make_samples(const std::vector<int>& rows,
                                             const std::vector<Table2Kind>& kinds,
                                             std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
