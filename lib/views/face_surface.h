// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Surfaces made of faces of living tissue: what they enclose, where they are open, and what joins
/// them there.

#include <vector>

#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// From one corner of a face to the next, and the face.
struct FaceEdge {
  Index from, to;
  TetFace face;
};

/// By tetrahedron, then by place in it.
[[nodiscard]] inline bool is_before(const TetFace& a, const TetFace& b) noexcept {
  return a.tet != b.tet ? a.tet < b.tet : a.face < b.face;
}

/// In scene vertices, wound so that the normal points out of the tetrahedron.
[[nodiscard]] Triangle corners_of(const Tissue& tissue, const TetFace& face);

/// Whether no living tetrahedron is on the other side.
[[nodiscard]] bool is_bare(const Tissue& tissue, const TetFace& face);

/// Edges of faces that no edge of another runs back along, ascending. Cost: O(n log n).
[[nodiscard]] std::vector<FaceEdge> free_edges(const Tissue& tissue,
                                               const std::vector<TetFace>& faces);

/// Adds the faces that go on from free edges over the surface of the tissue, until none is free.
/// Where more than two faces meet at an edge, those go on in each other that face each other
/// across the outside, at rest.
/// @return  ascending
[[nodiscard]] std::vector<TetFace> closed_surface(const Tissue& tissue, std::vector<TetFace> faces);

/// m^3, of what closed faces enclose at rest: positive of tissue, negative of hollows.
[[nodiscard]] double enclosed_volume(const Tissue& tissue, const std::vector<TetFace>& faces);

}  // namespace pbdsurg
