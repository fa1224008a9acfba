// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How the neighbourhoods of vertices lie in memory, for the vertex-block method: sixteen vertices
/// of one colour side by side, one neighbour or tetrahedron of each to a row. A vertex with fewer
/// than its block has rows is padded: itself for the others, and no stiffness. This header and
/// particle.h are shared with kernels that are compiled for several instruction sets.

#include <cstdint>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/sets/constraint_block.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// Distortion of Neo-Hookean tetrahedra, which pulls a vertex towards a neighbour.
struct alignas(64) PullRow {
  ParticleOffset neighbors[kBlockLanes];
  float weights[kBlockLanes];  ///< N/m
};

/// An edge of a body of springs, a link, a limit of stretch, or the damping of an edge.
struct alignas(64) SpringRow {
  ParticleOffset neighbors[kBlockLanes];
  float stiffness[kBlockLanes];  ///< N/m
  float rest[kBlockLanes];       ///< m; negative: a limit, see VertexEnergy::add_spring()
};

/// A tetrahedron's volume.
struct alignas(64) VolumeRow {
  ParticleOffset face[3][kBlockLanes];  ///< opposite, counter-clockwise seen from outside
  float stiffness[kBlockLanes];         ///< N/m^5 / 36
  float target[kBlockLanes];            ///< 6 m^3
};

/// A hinge, turned so that the vertex is the first or, opposite the edge, the third of it. Of the
/// others, the second, the third or else the first, and the fourth. One of a thin sheet that is
/// neither bent at rest nor damped has pulls in place of a row.
struct alignas(64) HingeRow {
  ParticleOffset neighbors[3][kBlockLanes];
  float moment[kBlockLanes];       ///< N/m^2, as VertexEnergy::add_moment() takes it
  float stiffness[kBlockLanes];    ///< N m
  float rest[kBlockLanes];         ///< BendingConstraint::kRest
  float is_opposite[kBlockLanes];  ///< 1 or 0
  float damping[kBlockLanes];      ///< N m s
  // In a damped block, of VertexEnergy::add_friction() in this substep: add_damping() sets them.
  float shares[3][kBlockLanes];  ///< 1/m, of the neighbours
  float across[3][kBlockLanes];  ///< sqrt(N m): x, y, z
  float start[kBlockLanes];      ///< sqrt(N m), what to count a turn from
};

/// A triangle of a sheet.
struct alignas(64) TriangleRow {
  ParticleOffset neighbors[2][kBlockLanes];
  float weights[2][kBlockLanes];  ///< N/m, of the pulls towards these
  float stiffness[kBlockLanes];   ///< N/m^3
  float target[kBlockLanes];      ///< m^2
};

/// The fibres of a tetrahedron.
struct alignas(64) FibreRow {
  ParticleOffset neighbors[3][kBlockLanes];
  float shares[3][kBlockLanes];  ///< 1/m, of these in F a
  float stiffness[kBlockLanes];  ///< N m
};

/// A step along a strip of the faces opposite a vertex, for kernels on registers: after corners a,
/// b and c comes d, and the next face is a, c, d or, where the strip turns, c, b, d. So a face
/// takes one corner to gather in place of three, and its pulls none.
struct alignas(64) StripRow {
  ParticleOffset corners[kBlockLanes];
  /// As in VolumeRow, of the face that ends here, zero for none; with a sign where the strip turns.
  float stiffness[kBlockLanes];
  float target[kBlockLanes];   ///< as in VolumeRow
  float weights[kBlockLanes];  ///< as in PullRow, towards the corner; zero for none
};

/// A step along a fan of the triangles at a vertex of sheets, for kernels on registers: a corner,
/// and the triangle between it and the corner before. So a triangle takes one corner to gather, and
/// pulls towards it none.
struct alignas(64) FanRow {
  ParticleOffset corners[kBlockLanes];
  float stiffness[kBlockLanes];  ///< as in TriangleRow; zero for no triangle
  float target[kBlockLanes];     ///< as in TriangleRow
  float within[kBlockLanes];     ///< N/m, the sum of its weights
  float weights[kBlockLanes];    ///< N/m, of all pulls towards the corner
};

/// What damping makes a row's stiffness and target from, in each substep.
struct alignas(64) DampedRow {
  float stiffness[kBlockLanes];
  float target[kBlockLanes];
  float damping[kBlockLanes];  ///< s times the unit of the stiffness
};

struct RowRange {
  Index first = 0;
  Index count = 0;
};

/// Sixteen vertices of one colour. Where there are fewer, the idle lanes repeat the last in use,
/// rows and all, so that a kernel of any width may store them: to the same place, the same bits.
struct alignas(64) VertexBlock {
  ParticleOffset corners[kBlockLanes];
  Index lane_count;
  bool is_damped;   ///< whether some row is
  bool has_angles;  ///< whether some hinge has a stiffness of its angle
  RowRange pulls, springs, volumes, hinges, triangles, fibres;
  RowRange strips;  ///< that say the same as pulls and volumes; none where they lack the room
  RowRange fans;    ///< that say the same as pulls and triangles; none where volumes are, too
  Index fan_steps;  ///< of these that have a triangle, and come first
};

/// All of them.
struct VertexRows {
  const VertexBlock* blocks;
  const PullRow* pulls;
  const SpringRow* springs;
  const VolumeRow* volumes;
  const HingeRow* hinges;
  const TriangleRow* triangles;
  const FibreRow* fibres;
  const StripRow* strips = nullptr;
  const FanRow* fans = nullptr;
};

/// Those that damping changes.
struct DampedRows {
  const VertexBlock* blocks;
  SpringRow* springs;
  VolumeRow* volumes;
  HingeRow* hinges;
  TriangleRow* triangles;
  const DampedRow* damped_springs;    ///< [springs]
  const DampedRow* damped_volumes;    ///< [volumes]
  const DampedRow* damped_triangles;  ///< [triangles]
  StripRow* strips = nullptr;
  const DampedRow* damped_strips = nullptr;  ///< [strips]
};

/// One bit a lane of a block, the first lane's the lowest.
using LaneBits = std::uint32_t;

/// How far a vertex may go in a sweep, as a share of the way to its least energy: more than any
/// over_relaxation; or no further than there, as a stiff link counts on it.
inline constexpr float kFreely = 2;
inline constexpr float kToLeastEnergy = 1;

/// Ends of stiff links and vertices of custom constraints in a substep, [place] each; see LooseEnd.
struct LinkEnds {
  Particle* ways;    ///< m, and whether it is known
  Particle* gives;   ///< m/N: xx, yy, zz; in place of w, 1 once custom constraints have pushed it
  Particle* shears;  ///< m/N: xy, xz, yz

  bool operator==(const LinkEnds&) const = default;
};

/// How stiffly custom constraints keep the vertices of a block where they are while the forces of
/// these lag behind: from projection to projection.
struct alignas(64) GuardBlock {
  float stiffness[kBlockLanes]{};  ///< N/m
};

/// What moving vertices reads and writes beside their rows.
struct VertexState {
  const Particle* bases;     ///< m, where vertices were at the start of the substep
  Particle* displacements;   ///< m, since then
  FixedPoint* fixed_points;  ///< where that takes them
  /// m, the displacement of a vertex without its rows; stiff links push it. In place of w, the most
  /// relaxation: see kFreely.
  Particle* flights;
  const LaneBits* left_out;            ///< [block_count] lanes that kernels must leave to others
  float unit;                          ///< m, of fixed points
  float inverse_dt_squared;            ///< 1/s^2
  float relaxation;                    ///< how far to go, as a share of the way to the least energy
  const GuardBlock* guards = nullptr;  ///< [block_count] null: none
};

}  // namespace pbdsurg
