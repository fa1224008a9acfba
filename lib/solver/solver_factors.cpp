// SPDX-License-Identifier: Apache-2.0
// How copies of a solver differ from its scene.
#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/base/describe.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/solver_input.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {
namespace {

void check_factor(const std::string& copy, const char* what, float factor) {
  if (!(factor >= kSmallestStiffness && factor <= kLargestStiffness)) {
    throw InvalidArgument(copy + ": the factor of " + what + " is " + describe(factor) +
                          "; it must be in [" + describe(kSmallestStiffness) + ", " +
                          describe(kLargestStiffness) + "]");
  }
}

void check_factors(const SolverData& data, const CopyFactors& factors, Index index) {
  const std::string copy = "copy " + std::to_string(index);
  check_factor(copy, "stiffness", factors.stiffness);
  check_factor(copy, "density", factors.density);
  if (!std::isfinite(factors.gravity)) {
    throw InvalidArgument(copy + ": the factor of gravity is " + describe(factors.gravity) +
                          "; it must be finite");
  }
  if (!factors.change_material()) {
    return;
  }
  if (data.options.mode == ProjectionMode::fraction) {
    throw InvalidArgument(copy +
                          " cannot have a material of its own: fraction mode has no "
                          "stiffness to scale, and no masses that count");
  }
  if (is_explicit(data.options)) {
    throw InvalidArgument(copy +
                          " cannot have a material of its own: explicit steps are as long "
                          "as that of the scene allows");
  }
  if (!data.custom.empty()) {
    throw InvalidArgument(copy +
                          " cannot have a material of its own: custom constraints do not "
                          "know of it");
  }
  const double haste = double{factors.stiffness} / double{factors.density};
  const float longest = hastened(data.substep_rule, std::max(haste, 1.0)).longest;
  if (data.options.substeps == kAutomatic &&
      double{data.options.longest_step} > kMostAutomatic * double{longest}) {
    throw InvalidArgument(copy + " needs substeps of " + describe(longest) +
                          " s or less: more than " + std::to_string(kMostAutomatic) +
                          " in the longest step, " + describe(data.options.longest_step) + " s");
  }
}

}  // namespace

void Solver::set_factors(const CopyFactors& factors, Index copy) {
  SolverData& data = *data_;
  CopyState& state = checked_copy(data, copy);
  check_factors(data, factors, copy);
  state.factors = factors;
  set_substep_rule(data.substep_rule, data);
}

CopyFactors Solver::factors(Index copy) const {
  return checked_copy(*data_, copy).factors;
}

}  // namespace pbdsurg
