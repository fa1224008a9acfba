// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints as kernels read them: records of whole 16-byte words. Places are as in SolverData.
/// Where the first place is negative, a constraint was removed and does nothing.

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/distance.h"

#include "lib/solver/sets/constraint_kinds.h"

namespace pbdsurg::cuda {

/// How many parameters a record has, the first of its kind's. What damps a distance lies in an
/// array of its own, so that records of undamped ones are one word.
template <class Constraint>
inline constexpr int kRecordParameters = Constraint::kParameterCount;
template <>
inline constexpr int kRecordParameters<DistanceConstraint> = DistanceConstraint::kDamping;

constexpr int round_to_words(int numbers) {
  return (numbers + 3) / 4 * 4;
}

template <class Constraint>
struct alignas(16) Record {
  Index places[Constraint::kVertexCount];
  /// Of the kind; zero beyond them.
  float parameters[round_to_words(Constraint::kVertexCount + kRecordParameters<Constraint>) -
                   Constraint::kVertexCount];
};

/// A tetrahedron of a joint plan. An edge that another tetrahedron owns has a negative rest length.
/// Edges and volume are of one body, and so of one damping.
struct alignas(16) JointRecord {
  Index places[4];
  float rest;       ///< m^3
  float stiffness;  ///< as in VolumeConstraint
  float damping;    ///< s
  float unused;
  float edge_rest[6];       ///< m, in the order of kTetEdges
  float edge_stiffness[6];  ///< as in DistanceConstraint
};

/// A tetrahedron that is only watched for inversion.
struct alignas(16) TubeRecord {
  Index places[4];
};

inline constexpr float kNotOwned = -1;  // m, rest length of an edge that another record projects

}  // namespace pbdsurg::cuda
