// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The loops of the vertex-block method, for one vertex or for a register of them.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// The vertices of a hinge in their order.
template <class Scalar>
struct RowHinge {
  Vec3<Scalar> x[4];

  template <class Condition>
  PBDSURG_DEVICE RowHinge(const Vec3<Scalar>& own, const Vec3<Scalar>& second,
                          const Vec3<Scalar>& other, const Vec3<Scalar>& fourth,
                          const Condition& is_opposite) {
    const auto choose = [&](const Vec3<Scalar>& a, const Vec3<Scalar>& b) {
      return Vec3<Scalar>{select(is_opposite, a.x, b.x), select(is_opposite, a.y, b.y),
                          select(is_opposite, a.z, b.z)};
    };
    x[0] = choose(other, own);
    x[1] = second;
    x[2] = choose(own, other);
    x[3] = fourth;
  }
};

/// sqrt(N m), the turn of a hinge as VertexEnergy::add_friction() takes it, from any start.
/// @param a  m, with b and c: its neighbours, from the vertex
template <class Scalar>
PBDSURG_DEVICE inline Scalar hinge_turn(const Scalar (&shares)[3], const Vec3<Scalar>& across,
                                        const Vec3<Scalar>& a, const Vec3<Scalar>& b,
                                        const Vec3<Scalar>& c) {
  return dot(across, shares[0] * a + shares[1] * b + shares[2] * c);
}

/// Adds the hinge of a row.
/// @param block   whose row it is
/// @param a       m, with b and c: its neighbours, from the vertex
template <class Access, class Scalar, class Energy>
PBDSURG_DEVICE inline void add_hinge(const HingeRow& row, const VertexBlock& block,
                                     const Access& access, const Vec3<Scalar>& a,
                                     const Vec3<Scalar>& b, const Vec3<Scalar>& c, Energy& energy) {
  energy.add_moment(access.load(row.moment), a, b, c);
  if (block.is_damped) {
    const Scalar shares[3] = {access.load(row.shares[0]), access.load(row.shares[1]),
                              access.load(row.shares[2])};
    const Vec3<Scalar> across{access.load(row.across[0]), access.load(row.across[1]),
                              access.load(row.across[2])};
    energy.add_friction(shares[0] + shares[1] + shares[2], across,
                        hinge_turn(shares, across, a, b, c) - access.load(row.start));
  }
  if (block.has_angles) {
    const auto is_opposite = access.load(row.is_opposite) > Scalar(0);
    energy.add_hinge(access.load(row.stiffness), access.load(row.rest),
                     RowHinge<Scalar>({}, a, b, c, is_opposite).x, is_opposite);
  }
}

/// Which rows of each kind: every `stride`-th from `first` on.
struct RowPart {
  Index first = 0;
  Index stride = 1;
};

/// The fibres of a row: what becomes of their direction, and the share of the vertex in it, see
/// VertexEnergy::add_fibre().
template <class Scalar>
struct RowFibre {
  Vec3<Scalar> stretched;
  Scalar share;

  template <class Access>
  PBDSURG_DEVICE RowFibre(const FibreRow& row, const Access& access) {
    const Scalar a = access.load(row.shares[0]);
    const Scalar b = access.load(row.shares[1]);
    const Scalar c = access.load(row.shares[2]);
    stretched = a * access.position(row.neighbors[0]) + b * access.position(row.neighbors[1]) +
                c * access.position(row.neighbors[2]);
    share = a + b + c;
  }
};

/// Adds what the rows of a block tell to the energies of its vertices, or to the forces on them.
/// Not a number, or infinite, where a neighbour is.
/// @param access  load(const float*): a Scalar of stored lanes; position(const ParticleOffset*):
///                likewise, m, from the vertex of a lane
template <class Access, class Energy>
PBDSURG_DEVICE inline void add_rows(const VertexRows& rows, const VertexBlock& block,
                                    const Access& access, Energy& energy, RowPart part = {}) {
  using Scalar = typename Energy::Number;
  if constexpr (Energy::kHasMore) {
    const PullRow* const pulls = rows.pulls + block.pulls.first;
    for (Index i = part.first; i < block.pulls.count; i += part.stride) {
      energy.add_pull(access.load(pulls[i].weights), access.position(pulls[i].neighbors));
    }
    const SpringRow* const springs = rows.springs + block.springs.first;
    for (Index i = part.first; i < block.springs.count; i += part.stride) {
      energy.add_spring(access.load(springs[i].stiffness), access.load(springs[i].rest),
                        access.position(springs[i].neighbors));
    }
  }
  const VolumeRow* const volumes = rows.volumes + block.volumes.first;
  for (Index i = part.first; i < block.volumes.count; i += part.stride) {
    energy.add_volume(access.load(volumes[i].stiffness), access.load(volumes[i].target),
                      access.position(volumes[i].face[0]), access.position(volumes[i].face[1]),
                      access.position(volumes[i].face[2]));
  }
  if constexpr (Energy::kHasMore) {
    const HingeRow* const hinges = rows.hinges + block.hinges.first;
    for (Index i = part.first; i < block.hinges.count; i += part.stride) {
      add_hinge(hinges[i], block, access, access.position(hinges[i].neighbors[0]),
                access.position(hinges[i].neighbors[1]), access.position(hinges[i].neighbors[2]),
                energy);
    }
    const TriangleRow* const triangles = rows.triangles + block.triangles.first;
    for (Index i = part.first; i < block.triangles.count; i += part.stride) {
      energy.add_triangle(
          access.load(triangles[i].weights[0]), access.load(triangles[i].weights[1]),
          access.load(triangles[i].stiffness), access.load(triangles[i].target),
          access.position(triangles[i].neighbors[0]), access.position(triangles[i].neighbors[1]));
    }
    const FibreRow* const fibres = rows.fibres + block.fibres.first;
    for (Index i = part.first; i < block.fibres.count; i += part.stride) {
      const RowFibre<Scalar> fibre(fibres[i], access);
      energy.add_fibre(access.load(fibres[i].stiffness), fibre.share, fibre.stretched);
    }
  }
}

/// Into so many parts rows are dealt: row i of a kind goes to part i modulo this. A vertex's sum is
/// that of its parts, in a tree that lanes of a device can follow, too.
inline constexpr Index kRowParts = 16;

/// As add_rows(), as the sum of parts: those whose numbers differ by half of kRowParts first, then
/// by a quarter. The first part starts from what the energy has, others from zero.
template <class Access, class Energy>
PBDSURG_DEVICE inline void add_tree(const VertexRows& rows, const VertexBlock& block,
                                    const Access& access, Energy& energy) {
  // a loop, since compilers would lay out rows once for each part of a recursion
  Energy sums[5];  // of subtrees that wait for their other halves
  static_assert(kRowParts == 1 << 4);
  Index count = 0;
  for (Index i = 0; i < kRowParts; ++i) {
    const Index part = (i & 1) << 3 | (i & 2) << 1 | (i & 4) >> 1 | i >> 3;
    Energy sum;
    if (i == 0) {
      sum = energy;
    }
    add_rows(rows, block, access, sum, {part, kRowParts});
    for (Index bit = 1; (i & bit) != 0; bit *= 2) {
      Energy both = sums[--count];
      both.add(sum);
      sum = both;
    }
    sums[count++] = sum;
  }
  energy = sums[0];
}

/// Where a vertex is, and how far it gets in a while.
template <class Scalar>
struct Heading {
  Vec3<Scalar> x, way;  ///< m
};

/// How stiffly volumes hold a vertex, taken up as its energy is: the trace of what they add to its
/// Hessian, where all vertices get in a while and where they were as long ago. See StableSubstep.
template <class Scalar>
struct VolumeStiffness {
  using Number = Scalar;
  static constexpr bool kHasMore = false;

  Scalar ahead{}, back{};  ///< N/m

  PBDSURG_HOST_DEVICE void add(const VolumeStiffness& other) {
    ahead = ahead + other.ahead;
    back = back + other.back;
  }
  PBDSURG_HOST_DEVICE void add_volume(Scalar stiffness, Scalar, const Heading<Scalar>& a,
                                      const Heading<Scalar>& b, const Heading<Scalar>& c) {
    const Vec3<Scalar> ab = b.x - a.x, ac = c.x - a.x;
    const Vec3<Scalar> way_ab = b.way - a.way, way_ac = c.way - a.way;
    const Vec3<Scalar> face = cross(ab + way_ab, ac + way_ac);
    const Vec3<Scalar> face_before = cross(ab - way_ab, ac - way_ac);
    ahead = ahead + stiffness * dot(face, face);
    back = back + stiffness * dot(face_before, face_before);
  }

  /// The larger of both times the share, or what there is if neither is larger.
  [[nodiscard]] PBDSURG_HOST_DEVICE Scalar most(Scalar share, Scalar most_before) const {
    const Scalar with_ahead = select(share * ahead > most_before, share * ahead, most_before);
    return select(share * back > with_ahead, share * back, with_ahead);
  }
};

/// Sets stiffness and target of the damped rows of a block for a substep: see VertexBlocks.
/// @param access      also store(Scalar, float*); positions are those at the start of the substep
/// @param inverse_dt  1/s
template <class Access, class Scalar>
PBDSURG_DEVICE inline void add_damping(const DampedRows& rows, const VertexBlock& block,
                                       const Access& access, Scalar inverse_dt) {
  using std::sqrt;
  const auto set = [&](const DampedRow& from, Scalar start, float* stiffness, float* target) {
    const Scalar given = access.load(from.stiffness);
    const Scalar rest = access.load(from.target);
    const Scalar damping = access.load(from.damping) * inverse_dt;
    const Scalar sum = given + damping;
    access.store(sum, stiffness);
    // else as given, bit for bit: not all lanes of a damped block are damped
    access.store(select(damping > Scalar(0), (given * rest + damping * start) / sum, rest), target);
  };
  const Vec3<Scalar> x = access.position(block.corners);
  for (Index i = block.springs.first; i < block.springs.first + block.springs.count; ++i) {
    SpringRow& row = rows.springs[i];
    const Vec3<Scalar> d = access.position(row.neighbors) - x;
    const Scalar length = sqrt(dot(d, d));
    set(rows.damped_springs[i], select(is_usable(length), length, Scalar(0)), row.stiffness,
        row.rest);
  }
  for (Index i = block.volumes.first; i < block.volumes.first + block.volumes.count; ++i) {
    VolumeRow& row = rows.volumes[i];
    const Vec3<Scalar> a = access.position(row.face[0]);
    const Vec3<Scalar> face =
        cross(access.position(row.face[1]) - a, access.position(row.face[2]) - a);
    set(rows.damped_volumes[i], dot(a - x, face), row.stiffness, row.target);
  }
  for (Index i = block.triangles.first; i < block.triangles.first + block.triangles.count; ++i) {
    TriangleRow& row = rows.triangles[i];
    const AreaPull<Scalar> start(access.position(row.neighbors[0]) - x,
                                 access.position(row.neighbors[1]) - x);
    set(rows.damped_triangles[i], start.area, row.stiffness, row.target);
  }
  for (Index i = block.hinges.first; i < block.hinges.first + block.hinges.count; ++i) {
    HingeRow& row = rows.hinges[i];
    const Vec3<Scalar> neighbors[3] = {access.position(row.neighbors[0]) - x,
                                       access.position(row.neighbors[1]) - x,
                                       access.position(row.neighbors[2]) - x};
    const auto is_opposite = access.load(row.is_opposite) > Scalar(0);
    const auto turning = BendingConstraint::turning(
        RowHinge<Scalar>({}, neighbors[0], neighbors[1], neighbors[2], is_opposite).x);
    const Scalar shares[3] = {turning.shares[1],
                              select(is_opposite, turning.shares[0], turning.shares[2]),
                              turning.shares[3]};
    const Scalar damping = access.load(row.damping) * inverse_dt;
    const Scalar scale = select(damping > Scalar(0), sqrt(damping), Scalar(0));
    const Vec3<Scalar> across = scale * turning.across;
    for (int k = 0; k < 3; ++k) {
      access.store(shares[k], row.shares[k]);
    }
    access.store(across.x, row.across[0]);
    access.store(across.y, row.across[1]);
    access.store(across.z, row.across[2]);
    const Scalar start = hinge_turn(shares, across, neighbors[0], neighbors[1], neighbors[2]);
    access.store(select(start * start < Scalar(kInfinity), start, Scalar(0)), row.start);
  }
}

}  // namespace pbdsurg
