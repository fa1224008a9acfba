// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What kernels of a step read and write, as plain pointers to device memory.

#include <cstddef>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/device/records.h"
#include "lib/solver/methods/coarse_kernel.h"
#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/edge_crossing.h"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/grip_motion.h"
#include "lib/solver/methods/group_balance.h"
#include "lib/solver/methods/handed_force.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/state/particle.h"
#include "lib/solver/state/surface_contact.h"
#include "lib/solver/state/tissue_touch.h"
#include "lib/solver/state/tool_spring.h"
#include "lib/solver/state/touch_rules.h"

namespace pbdsurg::cuda {

/// State, in the order of places: see SolverData. Here and below, arrays are those of all copies;
/// kernels take the part of theirs. There is room for more vertices than there are, which
/// StepInput::vertex_count says; what lies there is undefined.
struct DeviceState {
  Particle* particles;  ///< [copy][capacity]
  Velocity*
      velocities;  ///< [copy][capacity] before and after a step; in compliance mode, a substep
  Index* vertex_of_place;  ///< [capacity] of the scene
  Particle* previous;      ///< [copy][capacity] in fraction mode, else null: as in StepScratch
  // in compliance mode, else null
  Particle* displacements;  ///< [copy][capacity] as in StepScratch
  Carry* carries;           ///< [copy][capacity]
  // of the vertex-block method, else null
  Particle* flights;         ///< [copy][capacity] as in StepScratch
  FixedPoint* fixed_points;  ///< [copy][capacity] likewise
  LinkEnds ends;             ///< [copy][capacity] likewise
  // of BDF2, else null
  Way* ways;                    ///< [copy][capacity] as in CopyState
  Velocity* velocities_before;  ///< [copy][capacity] likewise
  Load* forces;     ///< [copy][capacity] as in CopyState, or null while no copy has had any
  Load* gravities;  ///< [capacity] as in SolverState, or null
  Index capacity;
  bool starts;  ///< whether fixed points are where vertices start: of explicit steps

  bool operator==(const DeviceState&) const = default;
};

/// The rows of the vertex-block method, as on the host, with room for more; what lies there, and in
/// idle lanes of rows, is any. Damping changes rows in each substep, each copy's otherwise;
/// without it, copies share them.
struct VertexArrays {
  const VertexBlock* blocks;          ///< [block_count]
  const PullRow* pulls;               ///< [pull]
  SpringRow* springs;                 ///< [copy, if damped][spring_room]
  VolumeRow* volumes;                 ///< [copy, if damped][volume_room]
  HingeRow* hinges;                   ///< [copy, if damped][hinge_room]
  TriangleRow* triangles;             ///< [copy, if damped][triangle_room]
  const FibreRow* fibres;             ///< [fibre]
  const DampedRow* damped_springs;    ///< [spring_room] if damped
  const DampedRow* damped_volumes;    ///< [volume_room] if damped
  const DampedRow* damped_triangles;  ///< [triangle_room] if damped
  /// [copy][block_room][lane] what tools do at a vertex in the current substep: the index of its
  /// HeldInput, kOnlyTouched, kOnlySurfaces or kInvalidIndex.
  Index* holds;
  /// [copy][block_room][lane] N/m, see GuardBlock; null where no surface may be filled.
  float* guards;
  /// [place] block * kBlockLanes + lane, or kInvalidIndex where no block has it.
  const Index* lane_of_place;
  const float* stiffness_shares;  ///< [block][lane] of explicit steps: StableSubstep::shares()
  Index block_count, block_room, spring_room, volume_room, hinge_room, triangle_room;
  bool is_damped;
  bool has_rare_rows;  ///< see VertexCounts

  bool operator==(const VertexArrays&) const = default;
};

// Of VertexArrays::holds, where no tool holds the vertex: contacts are all there is, of tools that
// meet vertices and perhaps of others; of surfaces or other bodies alone.
inline constexpr Index kOnlyTouched = -2;
inline constexpr Index kOnlySurfaces = -3;

/// What nothing holds: see FreePieces.
struct FreePieceArrays {
  const Index* firsts = nullptr;  ///< [count + 1]
  const Index* places = nullptr;  ///< of piece i, [firsts[i], firsts[i + 1]): none of the last ones
  Index count = 0;                ///< zero if there are no pieces
  /// [copy][count] the first of those that a piece moves with, or kInvalidIndex if it is pushed
  /// from outside: see PushedPieces. Null: each moves by itself.
  Index* groups = nullptr;
  /// [copy][count] likewise, as bodies have pushed each other by the end of a substep. Null: no
  /// bodies meet.
  Index* meeting = nullptr;
  const Index* piece_of_place = nullptr;  ///< [capacity] or kInvalidIndex; may be null
  // [copy][count] of those that contacts touch and nothing holds, in the current sweep
  Index* touched = nullptr;      ///< the first of those that move at once, or kInvalidIndex
  MomentumSums* sums = nullptr;  ///< where touched

  bool operator==(const FreePieceArrays&) const = default;
};

/// A CoarseSpace, and what CoarseScratch has of each copy. No nodes where there is no correction.
struct CoarseArrays {
  const CoarseVertex* vertices = nullptr;       ///< [vertex_room]
  const Index* own_counts = nullptr;            ///< [node] see NodeMembers
  const Index* own_places = nullptr;            ///< [node][member_room]
  const Index* member_counts = nullptr;         ///< [node]
  const Index* member_places = nullptr;         ///< [node][member_room]
  const CoarseShares* member_shares = nullptr;  ///< [node][member_room]
  const Index* pieces = nullptr;                ///< [node]
  const float* stiffnesses = nullptr;           ///< [mode]
  const float* modes = nullptr;                 ///< [mode][number]
  const float* numbers = nullptr;               ///< [number][mode]
  Particle* residuals = nullptr;                ///< [copy][vertex_room], as the following
  Particle* moves = nullptr;
  NodeSums* part_sums = nullptr;  ///< [copy][node][part_room] of kNodePart
  double* part_gains = nullptr;   ///< likewise, J, after the move
  NodeSums* sums = nullptr;       ///< [copy][node], as the following
  AffineNumbers* moves_of_nodes = nullptr;
  double* gains_before = nullptr;
  Turn* turns = nullptr;        ///< [copy][node] of pieces
  float* amplitudes = nullptr;  ///< [copy][mode]
  float* hold_modes = nullptr;  ///< [copy][mode][row] in room for kHoldRows
  /// [copy][part of kModesOfPart][entry] see HoldSystem::sum_of_modes()
  double* hold_parts = nullptr;
  CoarseHolds* holds = nullptr;        ///< [copy]
  CoarseShares* hold_sums = nullptr;   ///< [copy][node near which it is][node that moves it] N/m
  Index* hold_counts = nullptr;        ///< [copy][node]
  AffineNumbers* wide_sums = nullptr;  ///< [copy][wide][node] as CoarseScratch has them of one
  float* wide_compliances = nullptr;   ///< [copy][wide] m^3/Pa
  Index wide_count = 0;  ///< of WideConstraints: filled surfaces with a wall, kMostWides at most
  Index node_count = 0, piece_count = 0, mode_count = 0;
  Index vertex_room = 0, member_room = 0, part_room = 0;

  bool operator==(const CoarseArrays&) const = default;
};

/// A row as a thread reads it that shares a vertex with others: see VertexTiles. Neighbours go by
/// their position in the vertex's list, counted from one; position 0 is the vertex itself.
struct alignas(8) PullRecord {
  float weight;  ///< as in PullRow
  std::uint32_t neighbor;
};
struct alignas(16) SpringRecord {
  float stiffness, rest;  ///< as in SpringRow
  std::uint32_t neighbor;
  std::uint32_t unused;
};
struct alignas(16) VolumeRecord {
  float stiffness, target;  ///< as in VolumeRow
  std::uint32_t face;       ///< three positions of eight bits, the first one's the lowest
  std::uint32_t unused;
};

/// How many rows each thread of a block has, those that do nothing among them.
struct alignas(16) TileCounts {
  std::uint16_t neighbors, pulls, springs, volumes;
  Index others;  ///< hinges, triangles and fibres of a vertex, which stay rows
  Index more;    ///< not zero if there are more than usual_counts()
};

/// Rows that each thread has at least: most have no more, and need not ask how many.
/// @param parts  threads of a vertex
PBDSURG_HOST_DEVICE constexpr TileCounts usual_counts(Index parts) {
  return parts >= 16  ? TileCounts{1, 1, 0, 2, 0, 0}
         : parts >= 8 ? TileCounts{2, 2, 0, 3, 0, 0}
                      : TileCounts{3, 3, 0, 4, 0, 0};
}

/// What one kernel for all sweeps knows of a block of vertices.
struct alignas(16) TileBlock {
  Index neighbors, pulls, springs, volumes;  ///< first rows, as in VertexTiles
  TileCounts counts;
};

/// @param neighbor_count  the longest list of the block
/// @param parts           threads of a vertex
PBDSURG_HOST_DEVICE inline TileCounts tile_counts(const VertexBlock& block, Index neighbor_count,
                                                  Index parts) {
  const auto of_thread = [&](Index rows, std::uint16_t usual) {
    const auto count = static_cast<std::uint16_t>((rows + parts - 1) / parts);
    return count > usual ? count : usual;
  };
  const TileCounts usual = usual_counts(parts);
  TileCounts counts{of_thread(neighbor_count, usual.neighbors),
                    of_thread(block.pulls.count, usual.pulls),
                    of_thread(block.springs.count, usual.springs),
                    of_thread(block.volumes.count, usual.volumes),
                    block.hinges.count + block.triangles.count + block.fibres.count,
                    0};
  counts.more =
      static_cast<Index>(counts.neighbors > usual.neighbors || counts.pulls > usual.pulls ||
                         counts.springs > 0 || counts.volumes > usual.volumes || counts.others > 0);
  return counts;
}

/// What it reads in place of rows.
struct TileArrays {
  static constexpr Index kMostNeighbors = 254;        ///< positions have eight bits
  static constexpr Index kCountBits = (1 << 22) - 1;  ///< of how often a vertex has moved

  const TileBlock* blocks;         ///< [block]
  const std::uint32_t* neighbors;  ///< [row][thread], as the following
  PullRecord* pulls;               ///< [pull_rows][thread]
  SpringRecord* springs;           ///< [copy, if damped][spring_rows][thread]
  VolumeRecord* volumes;           ///< [copy, if damped][volume_rows][thread]
  Index parts;                     ///< threads of a vertex
  bool has_rare_rows;              ///< see VertexCounts
  Index spring_rows, volume_rows;
  Index most_neighbors;  ///< of a thread
};

/// Where vertices are, in kernels that take all of a step: one for each of two substeps that follow
/// each other, so that who goes on to the next cannot overwrite what a neighbour has yet to read.
struct Mailboxes {
  FixedPoint* points[2];  ///< [copy][capacity]
};

/// The blocks of each colour.
struct VertexColors {
  static constexpr Index kMost = 32;

  RowRange blocks[kMost];
  Index count;
};

/// Constraints of a kind, in the order of the stages.
template <class Constraint>
struct KindArrays {
  const Record<Constraint>* records = nullptr;  ///< [count]
  float* multipliers = nullptr;  ///< [Constraint::kMultiplierCount][count] of the first copy
  Index count = 0;

  bool operator==(const KindArrays&) const = default;
};

template <class... Constraints>
struct ArraysOfKinds : KindArrays<Constraints>... {
  template <class Constraint>
  PBDSURG_HOST_DEVICE const KindArrays<Constraint>& of() const noexcept {
    return *this;
  }

  bool operator==(const ArraysOfKinds&) const = default;
};

/// All constraints, and multipliers that sweeps hand to the next: these are those of the first
/// copy, and so on every multiplier_count.
struct ConstraintArrays : ForAllConstraints<ArraysOfKinds> {
  const float* distance_damping = nullptr;  ///< [distance] s
  const JointRecord* joints = nullptr;      ///< [joint_count]
  float* joint_multipliers = nullptr;       ///< [7][joint] of six edges, then of the volume
  const TubeRecord* tubes = nullptr;        ///< [tube_count]
  const Index* level_ends = nullptr;        ///< of serial stages
  Index joint_count = 0, tube_count = 0;
  std::size_t multiplier_count = 0;  ///< of a copy, all kinds together

  bool operator==(const ConstraintArrays&) const = default;
};

/// A contact with a surface, and what sweeps need beside it.
struct DeviceContact {
  SurfaceContact contact;
  float friction;  ///< coefficient
  Index swept;     ///< its capsule in StepInput's table of the substep; kInvalidIndex: a half space
  Index spring;    ///< the meeter that it is of, if that has one; else kInvalidIndex
  float firmness;  ///< for vertex blocks: see firmness_of()
};

/// A triangle is a candidate itself, behind its three edges.
inline constexpr Index kFeaturesOfTriangle = 4;

/// What contacts are ordered by.
struct alignas(16) ContactKey {
  ContactFeature feature;
  Index meeter;
};

/// A place and a hold there, in one number.
using HoldKey = std::uint64_t;

/// The holds of a place, within SurfaceArrays::holds.
struct alignas(8) HoldRange {
  Index first = 0, count = 0;
};

/// Of a contact, in SurfaceArrays::list_memory: see ContactLists.
inline constexpr std::size_t kListBytes =
    2 * sizeof(ContactKey) + 3 * sizeof(Index) + 3 * (2 * sizeof(HoldKey) + 3 * sizeof(Index));

/// A vertex that a tool takes along: see StoppedVertex.
struct DeviceStopped {
  Index place, capsule;
  Vec3<float> point;  ///< m
  Vec3<float> push;   ///< kg m
};

/// No capsule that a vertex has come through: all bytes are alike.
inline constexpr Index kNothingPassed = 0x7F7F7F7F;

/// What tools that meet surfaces touch. There is room for the copy that has most; nothing at all,
/// until a tool is such a one.
///
/// A candidate of a tool is a vertex, a vertex at one of its half spaces, or an edge or the inside
/// of a triangle, in this order: see load_candidate(). Contacts of all tools lie one after another.
/// A hold is a corner of a contact, 3 * contact + corner.
struct SurfaceArrays {
  const Index* triangles = nullptr;  ///< [triangle][3] places; kInvalidIndex where there is none
  const Index* thin = nullptr;       ///< [thin][3] likewise, of sheets, and links
  /// [place] the triangles there, ascending, from first_around[place] to first_around[place + 1]
  const Index* around = nullptr;
  const Index* first_around = nullptr;  ///< [capacity + 1]
  const float* firmness = nullptr;      ///< [capacity] see ContactFirmness
  // of the current substep
  Index* met_counts = nullptr;           ///< [copy][meeter] candidates; zero between searches
  DeviceContact* found = nullptr;        ///< [copy][meeter][tool_room] in any order
  unsigned char* list_memory = nullptr;  ///< [copy][contact_room][kListBytes]
  DeviceContact* contacts = nullptr;  ///< [copy][contact_room] in the order of tools and features
  Index* ends = nullptr;              ///< [copy][1 + meeter_room] of the tools before, then of each
  Index* level_counts = nullptr;      ///< [copy]
  HoldRange* holds_at = nullptr;      ///< [copy][capacity] of a place, within holds
  Index* holds = nullptr;             ///< [copy][hold] those of a place together, the last first
  Index* roots = nullptr;             ///< [copy][hold] the first at its place
  float* pushes = nullptr;            ///< [copy][hold] how often its place is pushed, in all
  /// [copy][contact_room] contacts of one level share no corner and no spring, and come after
  /// those of lower ones
  Index* levels = nullptr;
  /// [copy][contact_room] of what the substep before left: see HandedForce
  HandedForce* handed = nullptr;
  Index* passed = nullptr;           ///< [copy][capacity] kNothingPassed between substeps
  DeviceStopped* stopped = nullptr;  ///< [copy][capacity] by the tool at work
  ToolSpring* springs = nullptr;     ///< [copy][meeter_room] yield 0 of those that have none
  // of the substep before, but for the first
  RememberedContact* remembered = nullptr;  ///< [copy][contact_room]
  Index* remembered_ends = nullptr;         ///< [copy][1 + meeter_room]
  // what the host reads after the step
  SurfaceContact* told = nullptr;                ///< [copy][contact_room]
  RememberedContact* told_remembered = nullptr;  ///< [copy][contact_room]
  Index* told_ends = nullptr;                    ///< [copy][1 + meeter_room]
  ToolSpring* told_springs = nullptr;            ///< [copy][meeter_room]
  bool has_springs = false;                      ///< whether a tool is coupled
  Index triangle_count = 0, thin_count = 0;
  Index candidate_room = 0;  ///< of a tool
  Index tool_room = 0;       ///< contacts of a tool
  Index meeter_room = 0, contact_room = 0;

  bool operator==(const SurfaceArrays&) const = default;
};

/// A vertex and a body that it may meet.
struct alignas(16) TouchVertex {
  Index place;  ///< kInvalidIndex: none
  Index body;   ///< its own, of the tissue
  Index other;  ///< of TouchArrays::bodies
  Index pair;
};

struct TouchBody {
  Index body;  ///< of the tissue
  Index first_group, group_count;
  Index first_edge_group, edge_group_count;
  bool is_two_sided;
};

struct TouchPair {
  float thickness, friction;
  Index first, second;  ///< of TouchArrays::bodies
};

/// A triangle of a body, or a link, which has its second end twice.
struct alignas(16) TouchTriangle {
  Index corners[3];
  Index index;  ///< of the body's, ascending; kInvalidIndex: none
};

/// A box, for accesses of 16 bytes.
struct alignas(16) GroupBox {
  Vec3<float> low;  ///< m
  float unused_low;
  Vec3<float> high;  ///< m
  float unused_high;
};

/// The search of a copy. Those that are near stay so before anything has moved by `slack` from
/// where it was seen, as on a host.
struct TouchSearchState {
  std::uint32_t most_way;        ///< bits of m^2, in this substep; zero between searches
  std::uint32_t most_moved;      ///< likewise, since those that are near were searched
  float slack;                   ///< m
  Index has_searched, searches;  ///< whether it did so before; whether it does in this substep
  std::uint32_t blocks_done;     ///< see StepSums
  Index near_count;
  Index crossing_count;  ///< zero between searches
};

/// Bodies that meet each other: see ContactBodies. Nothing at all, until there are any. Triangles
/// and edges are in groups that lie near each other, those of a body one after another.
struct TouchArrays {
  static constexpr Index kGroup = 32;

  const TouchVertex* vertices = nullptr;  ///< [vertex_count] in the order of contacts
  const TouchBody* bodies = nullptr;
  const TouchPair* pairs = nullptr;          ///< [pair_count]
  const TouchTriangle* triangles = nullptr;  ///< [group][kGroup]
  const CrossingEdge* edges = nullptr;       ///< [edge_count] ascending; body kInvalidIndex: none
  const Index* edge_bodies = nullptr;        ///< [edge_count] of bodies
  const Index* edge_groups = nullptr;        ///< [group][kGroup] of edges, or kInvalidIndex
  TouchRules rules{};
  Index vertex_count = 0, edge_count = 0, pair_count = 0;
  Index triangle_group_count = 0, edge_group_count = 0;
  float thickest = 0;  ///< m, of all pairs
  // of the current substep
  GroupBox* boxes = nullptr;             ///< [copy][group] of triangles, then of edges
  TouchSearchState* searches = nullptr;  ///< [copy]
  Vec3<float>* seen = nullptr;  ///< [copy][vertex_count] m, when those that are near were searched
  Index* near = nullptr;        ///< [copy][vertex_count + edge_count] in any order
  std::uint8_t* is_met = nullptr;      ///< [copy][vertex_count]
  std::uint64_t* crossings = nullptr;  ///< [copy][crossing_room] turns, in any order
  TissueTouch* found = nullptr;        ///< [copy][vertex_count + crossing_room]
  Index* last_holds = nullptr;         ///< [copy][capacity] kInvalidIndex between searches
  Index* order = nullptr;              ///< [copy][contact_room] within found
  TissueTouch* contacts = nullptr;     ///< [copy][contact_room] in the order of slots
  Index* counts = nullptr;             ///< [copy]
  // as in SurfaceArrays, with four holds a contact
  Index* level_counts = nullptr;
  HoldRange* holds_at = nullptr;
  Index* holds = nullptr;
  Index* roots = nullptr;
  Index* befores = nullptr;  ///< [copy][hold] the contact before at its place, or kInvalidIndex
  float* pushes = nullptr;
  Index* levels = nullptr;
  // of the substep before, but for the first
  RememberedTouch* remembered = nullptr;  ///< [copy][contact_room]
  Index* remembered_counts = nullptr;     ///< [copy]
  // what the host reads after the step
  TissueTouch* told = nullptr;                 ///< [copy][contact_room]
  RememberedTouch* told_remembered = nullptr;  ///< [copy][contact_room]
  Index* told_counts = nullptr;                ///< [copy]
  Index contact_room = 0, crossing_room = 0;

  bool operator==(const TouchArrays&) const = default;
};

struct GripInput;
struct GripPointInput;

/// What tools touch and hold. A pusher is a tool that has capsules and holds nothing, and meets
/// vertices alone; a meeter meets surfaces. There is room for the copy that has most.
struct ToolArrays {
  // of the current substep
  std::uint32_t* touched;               ///< [copy][pusher][word_count] a bit a place
  CapsulePlane* planes;                 ///< [copy][pusher][DeviceState::capacity] where touched
  float* contact_multipliers;           ///< likewise, kg m
  Vec3<float>* contact_points;          ///< likewise, m, of the tool's surface
  Index* contact_places;                ///< [copy][pusher][contact_room] ascending
  Index* contact_counts;                ///< [copy][pusher]
  Vec3<float>* attachment_multipliers;  ///< [copy][attachment] kg m
  Index word_count;                     ///< 32 places each, of those there is room for
  Index contact_room;                   ///< the contact capacity, or all these if they are fewer
  Index pusher_room, attachment_room;
  // of jaws that hold with a limit, what the host reads after the step; no room without such
  GripInput* told_grips;        ///< [copy][grip_room]
  GripPointInput* told_points;  ///< [copy][point_room]
  Index grip_room, point_room;
  SurfaceArrays surfaces;
  TouchArrays touches;  ///< which act where tools do
  // of pieces that move at once, see group_balance.h
  GroupContact* group_contacts;  ///< [copy][group_room]
  GroupAnswer* group_answers;    ///< [copy][group_room]
  Index group_room;

  bool operator==(const ToolArrays&) const = default;
};

/// What a step sums up. Integers, whose sums do not depend on the order.
struct StepSums {
  Index inverted_tets;
  Index non_finite_vertices;
  Index first_non_finite;  ///< scene vertex, or the largest Index
  Index contacts;
  DroppedContacts dropped_contacts;
  std::uint32_t distance_residual;  ///< bits of a float >= 0, which are ordered as it is
  std::uint32_t volume_residual;    ///< likewise
  std::uint32_t stiffest;           ///< likewise, of explicit steps: see stiffest_vertex()
  std::uint32_t stalled;            ///< not zero once a thread has waited for too long
  std::uint32_t blocks_done;        ///< of the kernel at work, whose last block sets it to zero
};

struct ToolInput {
  Index pusher;  ///< or kInvalidIndex
  Index meeter;  ///< likewise
  Index grip;    ///< likewise
  Index first_attachment;
  Index attachment_count;
};

/// Of a tool.
struct Wrench {
  Vec3<float> force;   ///< N
  Vec3<float> torque;  ///< N m, around its origin
};

/// A tool that meets surfaces, in one substep.
struct MeeterInput {
  ContactBox box;  ///< see swept_box()
  Index first_capsule, capsule_count;
  Index first_half_space, half_space_count;
  Index first_remembered, remembered_count;  ///< when the part of the step begins
  Vec3<float> displacement;                  ///< m, of a coupled tool, likewise
  float compliance;                          ///< m/N, of its spring; zero where it has none
  float stride, way;                         ///< m, see end_spring()
  Vec3<float> told;                          ///< m, likewise
  float friction;                            ///< coefficient
  bool meets_triangles;                      ///< and edges
};

/// A pusher in one substep.
struct alignas(16) PusherInput {
  ContactBox box;
  Index first_capsule;
  Index capsule_count;
};

/// Where an attachment pulls to in one substep.
struct alignas(16) AttachmentInput {
  Vec3<float> target;  ///< m
  float compliance;    ///< m/N
};

/// Jaws that hold with a limit: see ToolGrip. The device writes what changes in a step.
struct alignas(16) GripInput {
  Index first_point, point_count;
  Index first_corner, corner_count;
  float limit;        ///< N
  float compliance;   ///< m/N
  Vec3<float> slide;  ///< m, of anchors in the substep
  Vec3<float> pull;   ///< N, summed up in the step
  float slid;         ///< m, likewise
};

/// A point that they hold: see GripPoint. Likewise.
struct alignas(16) GripPointInput {
  Index places[3];   ///< kInvalidIndex behind its vertices
  Index corners[3];  ///< these among the corners of the grip
  float weights[3];
  Vec3<float> anchor, target;  ///< m
  Vec3<float> multiplier;      ///< kg m
  Vec3<float> force;           ///< N, summed up in the step
};

struct GripCornerInput {
  Index place;
  float share;
};

/// A corner of a point as what holds its vertex.
struct GripHold {
  Index grip, point, corner;
};

/// A vertex that tools hold: HeldInput::first to first + count of the list of holds, which are
/// attachments and, behind these, GripHolds; in the order in which hosts list them.
struct alignas(16) HeldInput {
  Index place;
  Index first;
  Index count;
  Index unused;
};

/// What the host tells about a part of a step, in one piece of memory: one of these for each copy,
/// then the tables that they point to, each in bytes from its own start. Everything in it may
/// differ from step to step without a kernel being launched another way. What has nothing to do
/// with tools, or with the past of BDF2, is alike in all copies.
struct alignas(16) StepInput {
  FreeMotion<float> motion;
  Substep<float> substep;      ///< lengths
  float past_share;            ///< of BDF2, see displacement.h
  float unit;                  ///< m, of fixed points
  float force_per_multiplier;  ///< 1/s^2
  float h, inverse_h;          ///< s, 1/s: the length of a substep, in whatever share that counts
  double per_step;             ///< substeps of this length that a whole step would have
  float density;               ///< factor of the copy
  float heading;               ///< s, of explicit steps: see StableSubstep
  Index substep_count;         ///< of kernels that take all of a part of a step
  Index moves_before;          ///< likewise, what the counts of points go on from
  std::uint32_t longest_wait;  ///< see there
  Index vertex_count;
  Index contact_capacity;
  Index tool_count, pusher_count, capsule_count, attachment_count, held_count, watched_count;
  Index meeter_count, swept_count, half_space_count;
  Index grip_count, grip_point_count;
  Index touch_count;           ///< of contacts between bodies, when the part of the step begins
  std::uint32_t tools;         ///< ToolInput[tool]
  std::uint32_t wrenches;      ///< Wrench[tool] summed up in the step
  std::uint32_t origins;       ///< Vec3<float>[substep][tool] m
  std::uint32_t pushers;       ///< PusherInput[substep][pusher]
  std::uint32_t capsules;      ///< PlacedCapsule[substep][capsule]
  std::uint32_t attachments;   ///< AttachmentInput[substep][attachment]
  std::uint32_t held;          ///< HeldInput[held]
  std::uint32_t held_order;    ///< Index[hold]
  std::uint32_t grips;         ///< GripInput[grip]
  std::uint32_t grip_points;   ///< GripPointInput[] of all grips
  std::uint32_t grip_corners;  ///< GripCornerInput[] of all grips
  std::uint32_t grip_holds;    ///< GripHold[]
  std::uint32_t grip_poses;    ///< GripPose[substep][grip]
  std::uint32_t meeters;       ///< MeeterInput[substep][meeter]
  std::uint32_t swept;         ///< SweptCapsule[substep][capsule of a meeter]
  std::uint32_t half_spaces;   ///< SweptHalfSpace[substep][half space]
  std::uint32_t remembered;    ///< RememberedContact[] of all meeters
  std::uint32_t touches;       ///< RememberedTouch[touch_count]
  StepSums sums;
  // Of BDF2: those from the second substep on, which take the place of the above.
  FreeMotion<float> later_motion;
  Substep<float> later_substep;
  float later_past_share;
  float later_force_per_multiplier;
};

/// A table of a step's input.
template <class T>
PBDSURG_HOST_DEVICE T* table(StepInput* input, std::uint32_t offset) {
  return reinterpret_cast<T*>(reinterpret_cast<char*>(input) + offset);
}

/// What a step tells the host: in its memory, written by the device.
struct StepOutput {
  StepSums* sums;               ///< [copy]
  Wrench* wrenches;             ///< [copy][tool]
  Vec3<float>* watched;         ///< [copy][watched] m
  const Index* watched_places;  ///< [watched] on the device

  bool operator==(const StepOutput&) const = default;
};

}  // namespace pbdsurg::cuda
