// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Requests for changes to living tissue.

#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/scene.h"

namespace pbdsurg {

/// A new rest length of a live edge of a body of springs. A strain limit follows.
struct RestLengthChange {
  Index edge;         ///< live, each once
  float rest_length;  ///< m, positive and finite
};

/// A new rest volume of a live tetrahedron of a body with volume constraints or of a Neo-Hookean
/// body, whose rest shape is then scaled evenly. Strain limits of such a body follow: each of the n
/// tetrahedra around an edge scales its limit by the n-th root of what it scales its own sides by,
/// so that the limit follows in full where all change alike.
struct RestVolumeChange {
  Index tet;          ///< live, each once
  float rest_volume;  ///< m^3, positive and finite
};

/// A new rest area of a live triangle of a sheet, whose rest shape is then scaled evenly. Its
/// moduli times its thickness stay, and so do its mass and the bending of its hinges.
struct RestAreaChange {
  Index triangle;   ///< live, each once
  float rest_area;  ///< m^2, positive and finite
};

/// How many times as stiff as its body's material a live tetrahedron of a Neo-Hookean body is from
/// now on: Young's modulus is scaled, the ratio stays. What divides it is as stiff.
struct StiffnessChange {
  Index tet;     ///< live, each once
  float factor;  ///< in [kSmallestStiffness, kLargestStiffness]; 1: as its body's material
};

/// The same of a triangle of a sheet: its membrane is scaled, and the bending of a hinge by the
/// mean of its two triangles.
struct TriangleStiffnessChange {
  Index triangle;  ///< live, each once
  float factor;    ///< in [kSmallestStiffness, kLargestStiffness]; 1: as its sheet's material
};

/// Other fibres of a live tetrahedron of a Neo-Hookean body. What divides it has the same.
struct FibreChange {
  Index tet;    ///< live, each once
  Fibre fibre;  ///< as Scene::set_fibres() takes it; of no stiffness: none
};

/// A new rest length of a live link: a suture that is drawn tight, a strand that shrinks.
struct LinkLengthChange {
  Index link;         ///< live, each once, not removed by the same edit
  float rest_length;  ///< m, >= 0 and finite
};

/// A vertex that comes to be: on the segment between two vertices of one body, or where one is.
struct NewVertex {
  Index first;      ///< a corner of a live tetrahedron or triangle
  Index second;     ///< the same as `first` for a copy of it
  float share = 0;  ///< in [0, 1]: it starts at first + share (second - first), and moves as there
};

/// Moves a corner of a tetrahedron from a vertex to a copy of it that the same edit makes: this is
/// how tissue parts along faces. The tetrahedron keeps its id, its rest shape and its colour.
struct CornerMove {
  Index tet;   ///< live, not removed by the same edit
  Index from;  ///< a corner of it
  Index to;    ///< a new vertex, copy of `from`
};

/// Moves a corner of a sheet's triangle from a vertex to a copy of it that the same edit makes:
/// this is how a sheet parts or rips along edges. The triangle keeps its id and its rest shape.
struct TriangleMove {
  Index triangle;  ///< live, not removed by the same edit
  Index from;      ///< a corner of it
  Index to;        ///< a new vertex, copy of `from`
};

/// Moves an end of a link from a vertex to a copy of it that the same edit makes.
struct LinkMove {
  Index link;  ///< live, not removed by the same edit
  Index from;  ///< an end of it
  Index to;    ///< a new vertex, copy of `from`
};

/// A tetrahedron that takes over part of another's tissue: material, density, rest shape. The other
/// goes; all that take its place together fill it. That they do not overlap, and that neighbours
/// are split alike where they share an edge, is the caller's to see to: only volumes are checked.
struct NewTet {
  Index parent;  ///< live, not moved and not removed by the same edit
  /// Corners of the parent, copies of these, or new vertices on edges of the parent.
  Tet vertices;
};

/// What to change, all at once: see Tissue::apply(). Ids are those of the tissue, which never
/// change meaning. What is new gets the ids that follow: new_vertices[i] is vertex vertex_count() +
/// i, new_tets[i] tetrahedron tets().size() + i, new_links[i] link links().size() + i, as they are
/// before the edit; so entries of an edit can name its new vertices. Vertices, tetrahedra,
/// triangles, links and hinges of new_bodies follow all of these, in the order of that scene.
struct TopologyEdit {
  std::vector<Index> remove_tets{};       ///< live, each once
  std::vector<Index> remove_triangles{};  ///< of sheets: live, each once
  std::vector<Index> remove_links{};      ///< live, each once
  /// Whole bodies, particles and sheets included. Nothing of theirs can be moved, divided or linked
  /// by the same edit, nor be listed in remove_tets or remove_triangles.
  std::vector<Index> remove_bodies{};
  std::vector<RestLengthChange> rest_lengths{};                 ///< of edges
  std::vector<RestVolumeChange> rest_volumes{};                 ///< of tetrahedra
  std::vector<RestAreaChange> rest_areas{};                     ///< of triangles
  std::vector<StiffnessChange> stiffnesses{};                   ///< of tetrahedra
  std::vector<TriangleStiffnessChange> triangle_stiffnesses{};  ///< of triangles
  std::vector<FibreChange> fibres{};                            ///< of tetrahedra
  std::vector<LinkLengthChange> link_lengths{};                 ///< of links
  /// Vertices that stop where they are, and stay there in all copies, as those that the scene
  /// fixed: free ones, each once. They must have tissue, before and after the edit.
  std::vector<Index> fix_vertices{};
  /// Fixed ones, likewise, that move again, from rest.
  std::vector<Index> unfix_vertices{};
  std::vector<NewVertex> new_vertices{};       ///< for the next five
  std::vector<CornerMove> corner_moves{};      ///< where tissue parts along faces
  std::vector<TriangleMove> triangle_moves{};  ///< where a sheet parts along edges
  std::vector<LinkMove> link_moves{};          ///< to copies of vertices
  std::vector<NewTet> new_tets{};              ///< where tissue is divided
  std::vector<Link> new_links{};               ///< between vertices with tissue, new ones included
  /// Bodies that come in, with their hinges and the links between them: at rest where the scene has
  /// them, without speed, in all copies. Links to what is there already go to new_links. The
  /// scene's gravity is of no account.
  Scene new_bodies{};
};

}  // namespace pbdsurg
