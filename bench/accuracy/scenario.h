// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An organ that is let go from a stretch and swings under its weight, and how solvers follow it.

#include <string>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"

#include "bench/accuracy/reference.h"

namespace pbdsurg::bench {

struct Scenario {
  std::string name;
  std::string mesh;
  double away = 0;  ///< m, from the origin along each axis
  Scene scene;
  Positions start;   ///< m
  Motion reference;  ///< in the end
  double seconds;

  /// At the origin.
  /// @param youngs_modulus     Pa
  /// @param reference_substep  s
  /// @param quick              a tenth of the time
  /// @throws Error  unless the reference keeps its energy within 1 %
  Scenario(const TetMesh& organ, std::string mesh_name, double youngs_modulus,
           double reference_substep, bool quick);

  /// The same motion elsewhere, which takes no new reference.
  /// @param by  m, along each axis
  [[nodiscard]] Scenario moved(double by) const;
};

/// How a solver steps.
struct Setting {
  const char* method;
  SolverOptions options;
};

/// The default first.
[[nodiscard]] std::vector<Setting> make_settings();

struct Accuracy {
  double ms;        ///< a step, the median
  double error_mm;  ///< RMS distance of all vertices from the reference
  double tip_mm;    ///< distance of the mean of those that were furthest from the hold
  double energy;    ///< in the end over the start
};

/// @throws Error  if the end is not finite
[[nodiscard]] Accuracy measure(const Scenario& scenario, SolverOptions options, double dt);

}  // namespace pbdsurg::bench
