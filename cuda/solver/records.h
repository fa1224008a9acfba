// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Constraints as kernels read them: records of whole 16-byte words. Places are as in SolverData.
/// Where the first place is negative, a constraint was removed and does nothing.

#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/core/types.h"

namespace pbdsurg::cuda {

struct alignas(16) DistanceRecord {
  Index places[2];
  float rest;       ///< m
  float stiffness;  ///< as in DistanceConstraint
};

struct alignas(16) VolumeRecord {
  Index places[4];
  float rest;       ///< m^3
  float stiffness;  ///< as in VolumeConstraint
  float damping;    ///< s
  float unused;
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

struct alignas(16) NeoHookeanRecord {
  Index places[4];
  float parameters[NeoHookeanConstraint::kParameterCount];
};

struct alignas(16) StrainLimitRecord {
  Index places[2];
  float limit;  ///< m
  float unused;
};

struct alignas(16) BendingRecord {
  Index places[4];
  float rest;       ///< as in BendingConstraint
  float stiffness;  ///< likewise
  float damping;    ///< s
  float unused;
};

/// A tetrahedron that is only watched for inversion.
struct alignas(16) TubeRecord {
  Index places[4];
};

inline constexpr float kNotOwned = -1;  // m, rest length of an edge that another record projects

}  // namespace pbdsurg::cuda
