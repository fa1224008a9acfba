// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Changes to living tissue: the only way in which topology changes.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/export.h"
#include "pbdsurg/core/types.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// A new rest length of a live edge of a body of springs. A strain limit follows.
struct RestLengthChange {
  Index edge;
  float rest_length;  ///< m, positive and finite
};

/// A new rest volume of a live tetrahedron of a body with volume constraints or of a Neo-Hookean
/// body, whose rest shape is then scaled evenly. Strain limits of such a body follow: each of the n
/// tetrahedra around an edge scales its limit by the n-th root of what it scales its own sides by,
/// so that the limit follows in full where all change alike.
struct RestVolumeChange {
  Index tet;
  float rest_volume;  ///< m^3, positive and finite
};

/// A vertex that comes to be: on the segment between two vertices of one body, or where one is.
struct NewVertex {
  Index first;
  Index second;     ///< the same as `first` for a copy of it
  float share = 0;  ///< in [0, 1]: it starts at first + share (second - first), and moves as there
};

/// Moves a corner of a tetrahedron from a vertex to a copy of it that the same edit makes: this is
/// how tissue parts along faces. The tetrahedron keeps its id, its rest shape and its colour.
struct CornerMove {
  Index tet;
  Index from;  ///< a corner of it
  Index to;    ///< a new vertex, copy of `from`
};

/// Moves an end of a link from a vertex to a copy of it that the same edit makes.
struct LinkMove {
  Index link;
  Index from;
  Index to;
};

/// A tetrahedron that takes over part of another's tissue: material, density, rest shape. The other
/// goes; all that take its place together fill it. That they do not overlap, and that neighbours
/// are split alike where they share an edge, is the caller's to see to: only volumes are checked.
struct NewTet {
  Index parent;  ///< live, not moved and not removed by the same edit
  /// Corners of the parent, copies of these, or new vertices on edges of the parent.
  Tet vertices;
};

/// What to change, all at once. Ids are those of the solver, which never change meaning. What is
/// new gets the ids that follow: new_vertices[i] is vertex vertex_count() + i, new_tets[i]
/// tetrahedron tets().size() + i, new_links[i] link links().size() + i, as they are before the
/// edit; so entries of an edit can name its new vertices. Vertices, tetrahedra and links of
/// new_bodies follow all of these, in the order of that scene.
struct TopologyEdit {
  std::vector<Index> remove_tets{};
  std::vector<Index> remove_links{};
  /// Whole bodies, particles included. Nothing of theirs can be moved, divided or linked by the
  /// same edit, nor be listed in remove_tets.
  std::vector<Index> remove_bodies{};
  std::vector<RestLengthChange> rest_lengths{};
  std::vector<RestVolumeChange> rest_volumes{};
  std::vector<NewVertex> new_vertices{};
  std::vector<CornerMove> corner_moves{};
  std::vector<LinkMove> link_moves{};
  std::vector<NewTet> new_tets{};
  std::vector<Link> new_links{};
  /// Bodies that come in, and links between these: at rest where the scene has them, without
  /// speed, in all copies. Links to what is there already go to new_links. The scene's gravity is
  /// of no account.
  Scene new_bodies{};
};

/// What an edit did, consequences included. Vertices keep their ids for ever.
struct EditResult {
  /// Removed: as asked, then those of removed bodies, then parents of new ones, each once.
  std::vector<Index> tets;
  std::vector<Index> edges;  ///< whose last tetrahedron went, or moved away
  std::vector<Index> links;  ///< as asked, then those to a vertex that lost its tissue
  /// That lost their last tetrahedron, or were particles: they stop, and tools let go.
  std::vector<Index> vertices;
  Index first_new_vertex = 0;  ///< new ones follow each other, in the order of the edit
  Index first_new_tet = 0;
  Index first_new_link = 0;
  Index first_new_body = 0;  ///< new_bodies.bodies()[i] is body first_new_body + i
  Index first_new_edge = 0;  ///< up to the solver's edge count after the edit
  std::uint64_t topology_version = 0;
};

/// Whoever holds something that follows topology: a heat field, collision data, render buffers.
class PBDSURG_API EditParticipant {
 public:
  virtual ~EditParticipant() = default;

  /// Refuses an edit by throwing; must change nothing. An empty edit asks, before an undo too,
  /// whether this is still where the last edit left it.
  virtual void validate(const Solver& solver, const TopologyEdit& edit) const = 0;

  /// Follows an edit that all have accepted, after the solver did.
  /// @param result  what went, consequences included
  virtual void apply(const Solver& solver, const TopologyEdit& edit,
                     const EditResult& result) noexcept = 0;

  /// Goes back to where it was before the edit that it followed last, bit for bit, after the solver
  /// did. Called at most once for each edit, with what apply() was called with.
  virtual void undo(const Solver& solver, const TopologyEdit& edit,
                    const EditResult& result) noexcept = 0;
};

/// Changes a solver's topology between two steps: all of it, or nothing. Between start_step() and
/// finish_step() it changes that of the next step, with the same bits as after finish_step(). Only
/// these wait for the step that runs: undo_edit(), an edit that brings vertices, participants that
/// read the state, and on a device an edit that stops more vertices, counted in all copies, than
/// 1024 and than any edit before.
///
/// A removed tetrahedron takes with it its share of mass, the edges that it was the last to use,
/// and links to a vertex that it was the last to use. Colours stay valid: what is added takes a
/// colour that is free at its vertices, or a new one; phases without a constraint leave the plan.
///
/// New vertices move as what they are between, and are fixed if that is. A vertex that loses its
/// last tetrahedron to a copy stops, as one whose tetrahedra go. Where tetrahedra give way to
/// others, mass and rest volume stay; momentum does wherever velocity is linear over the parent.
///
/// A body that comes in is all that a scene's body is, and Solver::bodies() grows by it; it is
/// coloured by itself, into the colours that there are. A body that goes keeps its number and its
/// name, and Solver::is_body_alive() says that it is gone.
///
/// Cost: proportional to the change and to what tools hold, and to the number of phases where one
/// of them comes or goes; for bodies that come, to their size and the number of bodies; for one
/// that goes, to its size and all that edits brought so far; participants add theirs. On a device,
/// what adds anything takes spare room, see SolverOptions::spare: where that runs out, its
/// constraints are made anew before the next step, which costs as much as there is. So does what
/// adds anything with the vertex-block method, which lays out its rows anew. From a device, new
/// vertices have those read that they lie between.
///
/// @throws InvalidArgument  naming the first id that is out of range, dead or listed twice, or the
///                          value out of range; then nothing has changed
PBDSURG_API EditResult apply_edit(Solver& solver, const TopologyEdit& edit,
                                  std::span<EditParticipant* const> participants = {});

/// As above, into a result that is used again, so that no memory has to be found for it. An edit
/// that changes no more than one before it, and adds no more than there is spare room for
/// (SolverOptions::spare), allocates nothing; but one that brings bodies, in a joint plan, where
/// edges change groups, and with the vertex-block method, where it adds anything. A device's
/// backend may allocate for what is added.
PBDSURG_API void apply_edit(Solver& solver, const TopologyEdit& edit, EditResult& result,
                            std::span<EditParticipant* const> participants = {});

/// Takes back the last edit: topology, rest values, masses, colours, the order of constraints, what
/// tools held. Vertices that had tissue before and after the edit stay where they are now and
/// others are where the edit found them; so if nothing moved since, all bits are those of before
/// the edit, and so are those of all later steps. Tools let go of vertices that the edit brought.
/// @param edit          as given to apply_edit()
/// @param result        as it returned
/// @param participants  those of the edit, in their order
/// @throws InvalidArgument  if the last edit is another or was taken back, had other participants,
///                          or one that was moved from since, or brought a vertex that is watched;
///                          then nothing has changed
PBDSURG_API void undo_edit(Solver& solver, const TopologyEdit& edit, const EditResult& result,
                           std::span<EditParticipant* const> participants = {});

}  // namespace pbdsurg
