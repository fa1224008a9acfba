// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A rival: the projections of the solver's Neo-Hookean tetrahedra, but all from the same
/// positions, which needs no colours.

#include <Eigen/Core>
#include <vector>

#include "pbdsurg/constraints/neo_hookean.h"

#include "bench/convergence/cantilever.h"

namespace pbdsurg::bench {

enum class JacobiSum {
  averaged,  ///< a vertex moves by the mean of what its tetrahedra ask for
  plain,     ///< by the sum
};

/// A plain loop on one thread.
class JacobiLoop {
 public:
  /// @param damping  1/s, as SolverOptions::damping
  JacobiLoop(const Cantilever& bar, JacobiSum sum, int substeps, int iterations, float damping);

  /// Moves every vertex and stops it.
  /// @param positions  [vertex_count] m
  void write_positions(const std::vector<Eigen::Vector3f>& positions);

  void step(float dt);

  [[nodiscard]] std::vector<Eigen::Vector3f> positions() const;

 private:
  struct Constraint {
    Tet vertices;
    float parameters[NeoHookeanConstraint::kParameterCount];
    float multipliers[NeoHookeanConstraint::kMultiplierCount];
  };

  void iterate(const Substep<float>& substep);

  int substeps_;
  int iterations_;
  float damping_;
  Vec3<float> gravity_;
  std::vector<Constraint> constraints_;
  std::vector<float> inverse_masses_;  // 1/kg
  std::vector<float> shares_;          // of what its constraints ask for that a vertex does
  std::vector<Vec3<float>> x_, previous_, velocities_, moves_;
};

}  // namespace pbdsurg::bench
