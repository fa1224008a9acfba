// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a host writes while it steps a copy, beside that copy's state.

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/stiff_link.h"

#include "lib/solver/methods/coarse_correction.h"
#include "lib/solver/methods/group_balance.h"
#include "lib/solver/methods/pushed_pieces.h"
#include "lib/solver/methods/touched_list.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/sets/constraint_block.h"
#include "lib/solver/sets/constraint_kinds.h"
#include "lib/solver/state/particle.h"
#include "lib/solver/state/tissue_surface.h"

namespace pbdsurg {

class SolverData;
struct CopyState;

/// What constraints remember from sweep to sweep of a substep.
template <class... Constraints>
class MultiplierStore {
 public:
  template <class Constraint>
  using Groups = std::vector<std::vector<MultiplierBlock<Constraint>>>;

  /// [group][block] as the blocks of ConstraintSlots
  template <class Constraint>
  [[nodiscard]] Groups<Constraint>& of() noexcept {
    return std::get<Groups<Constraint>>(groups_);
  }

  /// Calls visit(groups) for each kind.
  template <class Visit>
  void for_each(Visit visit) {
    (visit(std::get<Groups<Constraints>>(groups_)), ...);
  }
  template <class Visit>
  void for_each(Visit visit) const {
    (visit(std::get<Groups<Constraints>>(groups_)), ...);
  }

 private:
  std::tuple<Groups<Constraints>...> groups_;
};

/// Of a surface contact, or one between bodies.
struct ContactEntry {
  Index tool, entry;  ///< as of VertexHold
  int side = 0;       ///< of a contact between bodies: 0 the vertex, 1 the triangle
  auto operator<=>(const ContactEntry& other) const noexcept = default;
};

/// Of StepScratch::touched, the first before the second.
struct PiecePair {
  Index first, second;
  auto operator<=>(const PiecePair& other) const noexcept = default;
};

enum class HoldKind : std::uint8_t { grasp, grip, contact, surface_contact, touch };

/// What a tool, or another body, does at a vertex.
struct VertexHold {
  Index place;  ///< of the vertex, see SolverState
  Index next;   ///< at the same vertex, or kInvalidIndex
  Index tool;   ///< kInvalidIndex: a body
  Index entry;  ///< of its attachments, its grip's points, contacts or surface contacts; of
                ///< contacts between bodies
  HoldKind kind;
  int corner = 0;  ///< of a grip's point, a surface contact, or one between bodies
};

/// A vertex that a tool takes along: see stop_passing.h.
struct StoppedVertex {
  Index tool, place;
  Index capsule;      ///< of the tool, that it had come through
  Vec3<float> point;  ///< m, where it is now
  Vec3<float> push;   ///< kg m, that it took
};

/// Weights with which likely contacts between bodies push a vertex: see begin_touches().
struct PushLists {
  struct Range {
    Index first = kInvalidIndex;  ///< not looked up yet
    Index count = 0;
  };
  std::vector<float> weights;   ///< those of a vertex together
  std::vector<Range> of_holds;  ///< [hold] by the first of a vertex
};

/// How a vertex with holds gives way.
struct HeldGive {
  VertexGive<float> give{};
  bool is_known = false;
};

/// Of one worker: who steps copies at the same time has one each. Nothing in it outlives a step.
struct PBDSURG_API StepScratch {
  std::vector<Particle> previous;       ///< [place] in fraction mode: at the start of the substep
  std::vector<Particle> displacements;  ///< [place] in compliance mode: m, since that start
  ForAllConstraints<MultiplierStore> multipliers;

  // of the vertex-block method
  std::vector<Particle> flights;         ///< [place] see VertexState
  std::vector<FixedPoint> fixed_points;  ///< [place] where displacements take vertices
  std::vector<Index> first_holds;        ///< [place] or kInvalidIndex
  std::vector<VertexHold> holds;         ///< of the current substep
  PushLists likely_pushes;
  std::vector<HeldGive> gives;                ///< [hold] by the first of a vertex, see yield_of()
  std::vector<LaneBits> held;                 ///< [block] lanes of vertices with holds
  std::vector<ContactEntry> contact_entries;  // likewise
  std::vector<TissueSurface::PlaceTriangle> triangles_at_tool;  ///< that one may touch
  std::vector<Index> walls_at_tool;                             ///< fixed vertices of these
  std::vector<StoppedVertex> stopped;                           ///< in the current substep
  TouchedPieces touched;                                        ///< in the current sweep
  std::vector<GroupContact> group_contacts;  ///< of pieces that move at once, see group_balance.h
  std::vector<GroupAnswer> group_answers;    // likewise
  std::vector<RigidBody> group_bodies;       // likewise
  std::vector<GroupSpace> group_space;       ///< one, likewise
  std::vector<PiecePair> piece_pairs;        ///< that push each other, see eased_pieces.h
  CoarseScratch coarse;                      ///< of its coarse correction, if it has one
  // of its stiff links, custom constraints and bodies that meet, if there are any
  std::vector<Particle> end_ways, end_gives, end_shears;  ///< [place] see LinkEnds
  std::vector<LaneBits> linked;                           ///< [block] lanes of their vertices
  std::vector<ParticleOffset> lone_ends;                  ///< ends in no block
  PushedPieces pushed;                                    ///< by custom constraints
  PushedPieces meeting;            ///< by these or, once sweeps are done, by other bodies
  std::vector<GuardBlock> guards;  ///< [block] likewise
  /// Whether it has rows that damping changes in each substep; else those of VertexBlocks are,
  /// which is for one worker to do.
  bool has_own_rows = false;
  std::uint64_t rows_revision = 0;  ///< SolverData::rows_revision of these
  std::vector<SpringRow> springs;
  std::vector<VolumeRow> volumes;
  std::vector<HingeRow> hinges;
  std::vector<StripRow> strips;
  std::vector<TriangleRow> triangles;

  /// Makes room for a step of any copy, before it begins, and finds the ends of stiff links and the
  /// vertices of custom constraints. Cost: O(groups), and O(blocks) with such vertices, where no
  /// edit came between.
  void fit(const SolverData& data);

  /// As fit(), for a worker beside the one that changes the rows of VertexBlocks. Cost: O(rows), if
  /// these have damping and an edit came between.
  void fit_beside(const SolverData& data);

  [[nodiscard]] LinkEnds link_ends() noexcept {
    return {end_ways.data(), end_gives.data(), end_shears.data()};
  }

  /// Makes room for all that tools can touch and hold, part of fit().
  void reserve_holds(const SolverData& data);

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void fit_ends(const SolverData& data);
};

/// A step of one copy, as one worker takes it.
struct StepContext {
  SolverData& data;  ///< read, but for the rows of VertexBlocks: see StepScratch
  CopyState& copy;
  StepScratch& scratch;
  Index index = 0;        ///< of the copy
  bool is_probe = false;  ///< whether nobody will have made the step
};

}  // namespace pbdsurg
