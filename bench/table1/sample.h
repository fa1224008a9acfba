// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What table 1 is measured on: one mesh, its constraints, and the ways to colour them.

#include <string>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/color.h"

namespace pbdsurg::bench {

/// A mesh of the table 2 family.
struct Sample {
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

/// "clique_bound", "conflicts"
[[nodiscard]] const char* name_of(Palette palette) noexcept;

/// All algorithms, plain; and the first and the last of them with repair and balance.
[[nodiscard]] std::vector<ColoringOptions> table1_colorings();

/// Colours on one thread.
/// @throws Error  if two constraints of one colour share a vertex
[[nodiscard]] Coloring color_validly(const ConstraintVertices& constraints,
                                     const ColoringOptions& options);

}  // namespace pbdsurg::bench
