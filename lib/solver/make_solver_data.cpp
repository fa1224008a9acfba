// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/make_solver_data.h"

#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/base/executor_state.h"
#include "lib/solver/host/host_backends.h"
#include "lib/solver/program/backend.h"
#include "lib/solver/program/solver_device.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_input.h"

namespace pbdsurg {
namespace {

// Where a cluster of blocks holds a scene, many short phases are the faster plan; beyond, few
// launches. The vertex-block method knows no joint plan.
PlanComposition device_composition(const Tissue& tissue, const SolverOptions& options) {
  constexpr std::size_t kLarge = 320'000;  // tetrahedra; measured on an H200
  const bool is_joint = options.method == SolverMethod::projection && tissue.version() == 0 &&
                        tissue.tets().size() > kLarge;
  return is_joint ? PlanComposition::joint : PlanComposition::separate;
}

// All but a backend.
// @param automatic  what an automatic composition is
std::unique_ptr<SolverData> make_data(const Tissue& tissue, SolverOptions options,
                                      PlanComposition automatic) {
  if (options.composition == PlanComposition::automatic) {
    options.composition = automatic;
  }
  return build_solver_data(tissue, input_at_rest(tissue, options));
}

// Colours by the device where that is worth its while and it can.
std::unique_ptr<SolverData> make_data_for_device(const Tissue& tissue, SolverOptions options) {
  constexpr std::size_t kWorthDevice = 1'500'000;  // edges and tetrahedra: see ColoringOptions
  const PlanComposition automatic = device_composition(tissue, options);
  if (!options.coloring.executor && tissue.edges().size() + tissue.tets().size() >= kWorthDevice) {
    SolverOptions colored_there = options;
    colored_there.coloring.executor = options.executor;
    try {
      return make_data(tissue, std::move(colored_there), automatic);
    } catch (const BackendUnavailable&) {  // it may step all the same
    }
  }
  return make_data(tissue, std::move(options), automatic);
}

// @throws BackendUnavailable  if the device cannot
std::unique_ptr<SolverData> make_device_data(const Tissue& tissue, const SolverOptions& options) {
  auto* const device = dynamic_cast<SolverDevice*>(options.executor.state()->device());
  if (device == nullptr) {
    throw BackendUnavailable(options.executor.name() + " steps no solvers");
  }
  std::unique_ptr<SolverData> data = make_data_for_device(tissue, options);
  data->set_backend(device->make_backend(*data));
  return data;
}

std::unique_ptr<SolverData> make_host_data(const Tissue& tissue, const SolverOptions& options) {
  std::unique_ptr<SolverData> data = make_data(tissue, options, PlanComposition::nested);
  data->set_backend(make_host_backend(options));
  return data;
}

}  // namespace

std::unique_ptr<SolverData> make_solver_data(const Tissue& tissue, SolverOptions options) {
  if (options.executor.kind() == ExecutorKind::device) {
    const Executor instead = options.executor.state()->instead();
    try {
      return make_device_data(tissue, options);
    } catch (const BackendUnavailable&) {  // for this tissue
      if (!instead) {
        throw;
      }
    }
    options.executor = instead;
    options.device_strategy = DeviceStrategy::automatic;
  }
  return make_host_data(tissue, options);
}

}  // namespace pbdsurg
