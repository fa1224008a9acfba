// SPDX-License-Identifier: Apache-2.0
// Constraints of a program's own.
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

void Solver::add_constraints(std::shared_ptr<CustomConstraints> set) {
  if (set == nullptr) {
    throw InvalidArgument("a set of constraints is a null pointer");
  }
  if (is_explicit(data_->options)) {
    throw InvalidArgument("constraint set '" + set->name() +
                          "' is projected in sweeps; explicit steps have none");
  }
  for (Index i = 0; i < data_->copy_count(); ++i) {
    if (data_->copy(i).factors.change_material()) {
      throw InvalidArgument("constraint set '" + set->name() +
                            "' does not know the material that " + "copy " + std::to_string(i) +
                            " has of its own");
    }
  }
  if (data_->backend->keeps_state()) {
    if (set->filling() == nullptr) {
      throw BackendUnavailable("constraint set '" + set->name() + "' is called on a CPU; " +
                               backend_name() + " steps without such calls");
    }
    if (!data_->backend->takes_fillings()) {
      throw BackendUnavailable("constraint set '" + set->name() +
                               "' needs a CPU, or compliance mode, launch by launch: " +
                               backend_name() + " does not step it");
    }
  }
  data_->custom.add(tissue(), std::move(set));
  data_->rebuild_plan();
}

void Solver::remove_constraints(const CustomConstraints& set) {
  data_->custom.remove(set);
  data_->rebuild_plan();
}

}  // namespace pbdsurg
