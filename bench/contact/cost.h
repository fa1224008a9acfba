// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What contact adds to a step of the paper's largest scene.

#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/material.h"

namespace pbdsurg::bench {

struct CostSubject {
  const char* method;  ///< as the table names it
  SolverOptions options;
  ElasticModel model;
  float step;  ///< s
};

struct ContactCost {
  std::string stage;
  std::optional<double> us;  ///< a step, or what it takes longer; nothing where it cannot be made
  std::optional<double> share;  ///< of the step with it
  Index contacts;               ///< of tools and of bodies, that the last step had
};

/// A gallbladder that lies on the liver, half of its membrane cut, at first without anything that
/// touches; then two shafts of 2.5 mm, 3 mm deep in it, that meet its vertices; all of its surface;
/// and that, with the two bodies meeting each other; or jaws that hold what is within 4 mm of one
/// place, and lift it by as much. All step by turns.
/// @param rounds  that are timed
[[nodiscard]] std::vector<ContactCost> contact_costs(const CostSubject& subject, int rounds);

}  // namespace pbdsurg::bench
