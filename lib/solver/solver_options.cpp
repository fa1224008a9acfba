// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/solver_options.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/coloring/coloring_options.h"

namespace pbdsurg {
namespace {

template <class Choice>
void check_choice(const char* what, Choice choice, Choice last) {
  if (choice > last) {
    throw InvalidArgument(std::string("unknown ") + what + " " +
                          std::to_string(static_cast<int>(choice)));
  }
}

}  // namespace

void check_option_ranges(const SolverOptions& options) {
  if (options.substeps < 1 && options.substeps != kAutomatic) {
    throw InvalidArgument("substeps is " + std::to_string(options.substeps) +
                          "; it must be >= 1, or 0 for automatic ones");
  }
  if (!(options.accuracy >= 1e-3F) || !(options.accuracy <= 1)) {
    throw InvalidArgument("accuracy is " + std::to_string(options.accuracy) +
                          "; it must be in [0.001, 1]");
  }
  if (!(options.longest_step > 0) || !std::isfinite(options.longest_step)) {
    throw InvalidArgument("longest_step is " + std::to_string(options.longest_step) +
                          " s; it must be positive and finite");
  }
  if (options.iterations < 1 && options.iterations != kAutomatic) {
    throw InvalidArgument("iterations is " + std::to_string(options.iterations) +
                          "; it must be >= 1, or 0 for automatic ones");
  }
  if (!(options.damping >= 0) || !std::isfinite(options.damping)) {
    throw InvalidArgument("damping is " + std::to_string(options.damping) +
                          " 1/s; it must be >= 0 and finite");
  }
  if (!(options.over_relaxation >= 1) || !(options.over_relaxation < 2)) {
    throw InvalidArgument("over_relaxation is " + std::to_string(options.over_relaxation) +
                          "; it must be in [1, 2)");
  }
  if (options.contact_capacity < 0) {
    throw InvalidArgument("contact_capacity is " + std::to_string(options.contact_capacity) +
                          "; it must be >= 0");
  }
  if (options.convergence_interval < 0) {
    throw InvalidArgument("convergence_interval is " +
                          std::to_string(options.convergence_interval) + "; it must be >= 0");
  }
  if (options.copies < 1) {
    throw InvalidArgument("copies is " + std::to_string(options.copies) + "; it must be >= 1");
  }
  for (const auto& [what, count] :
       {std::pair("vertices", options.spare.vertices), std::pair("tets", options.spare.tets),
        std::pair("edges", options.spare.edges), std::pair("links", options.spare.links)}) {
    if (count < 0) {
      throw InvalidArgument(std::string("spare room for ") + what + " is " + std::to_string(count) +
                            "; it must be >= 0");
    }
  }
  check_choice("math mode", options.math, MathMode::strict);
  check_choice("device strategy", options.device_strategy, DeviceStrategy::cooperative);
  check_choice("method", options.method, SolverMethod::explicit_steps);
  check_choice("mode", options.mode, ProjectionMode::compliance);
  check_choice("coarse correction", options.coarse_correction, CoarseCorrection::on);
  check_choice("time integration", options.integration, TimeIntegration::bdf2);
  check_coloring_options(options.coloring);
  check_choice("composition", options.composition, PlanComposition::nested);
}

namespace {

[[noreturn]] void refuse_unread(const std::string& option, const char* rule) {
  throw InvalidArgument(option + ", which nothing would read; " + rule);
}

constexpr const char* kNeedsAutomatic = "it needs automatic substeps or iterations";

void check_explicit_readers(const SolverOptions& options) {
  if (options.iterations != kAutomatic && options.iterations != 1) {
    refuse_unread("iterations is " + std::to_string(options.iterations),
                  "explicit steps have no sweeps");
  }
  if (options.accuracy != SolverOptions{}.accuracy) {
    refuse_unread("accuracy is " + std::to_string(options.accuracy),
                  "explicit steps take as many substeps as they need to be stable");
  }
  if (options.integration != TimeIntegration::implicit_euler) {
    throw InvalidArgument("integration is bdf2; explicit steps have an integration of their own");
  }
  if (options.convergence_interval > 0) {
    refuse_unread("convergence_interval is " + std::to_string(options.convergence_interval),
                  "explicit steps solve no system that could leave a residual");
  }
}

}  // namespace

// An option that others leave without a reader would do nothing, in silence.
void check_option_readers(const SolverOptions& options) {
  if (options.over_relaxation != 1 && options.method != SolverMethod::vertex_block) {
    refuse_unread("over_relaxation is " + std::to_string(options.over_relaxation),
                  "it needs the vertex-block method");
  }
  if (has_coarse_correction(options) && options.method != SolverMethod::vertex_block) {
    refuse_unread("coarse_correction is on", "it needs the vertex-block method");
  }
  if (has_coarse_correction(options) && options.iterations == 1) {
    refuse_unread("coarse_correction is on and iterations is 1",
                  "it takes a sweep before and one after: 2 or more, or automatic ones");
  }
  if (options.device_strategy == DeviceStrategy::cooperative && !moves_vertices(options)) {
    refuse_unread("device_strategy is cooperative", "it needs the vertex-block method");
  }
  if (is_explicit(options)) {
    check_explicit_readers(options);
  }
  if (options.convergence_interval > 0 && options.mode == ProjectionMode::fraction) {
    refuse_unread("convergence_interval is " + std::to_string(options.convergence_interval),
                  "it needs compliance mode");
  }
  if (options.integration == TimeIntegration::bdf2 && options.mode == ProjectionMode::fraction) {
    throw InvalidArgument(
        "integration is bdf2; fraction mode moves positions and has no inertia that it could "
        "change: it needs compliance mode");
  }
  const SolverOptions usual;
  const bool is_automatic = options.substeps == kAutomatic || options.iterations == kAutomatic;
  if (is_automatic && options.mode == ProjectionMode::fraction) {
    throw InvalidArgument(
        "substeps or iterations are automatic; fraction mode has no stiffness that they could "
        "follow from: name both");
  }
  if (!is_automatic && options.accuracy != usual.accuracy) {
    refuse_unread("accuracy is " + std::to_string(options.accuracy), kNeedsAutomatic);
  }
  if (!is_automatic && options.longest_step != usual.longest_step) {
    refuse_unread("longest_step is " + std::to_string(options.longest_step) + " s",
                  kNeedsAutomatic);
  }
  if (options.device_strategy == DeviceStrategy::automatic) {
    return;
  }
  if (!options.executor || options.executor.kind() != ExecutorKind::device) {
    constexpr const char* kNames[] = {"automatic", "stream", "graph", "cluster", "cooperative"};
    refuse_unread("device_strategy is " +
                      std::string(kNames[static_cast<std::size_t>(options.device_strategy)]),
                  "it needs a CUDA device as executor");
  }
}

SolverOptions SolverOptions::paper() {
  SolverOptions options;
  options.method = SolverMethod::projection;
  options.mode = ProjectionMode::fraction;
  options.substeps = 1;
  options.iterations = 30;
  options.coloring = {.algorithm = ColoringAlgorithm::random_disc,
                      .disc = {.palette = Palette::conflicts}};
  options.composition = PlanComposition::separate;
  return options;
}

}  // namespace pbdsurg
