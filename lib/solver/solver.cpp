// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/solver.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"
#include "lib/solver/coarse_choice.h"
#include "lib/solver/make_solver_data.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/program/backend.h"
#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/solver_input.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {

SolverData& solver_data(Solver& solver) {
  return *solver.data_;
}
const SolverData& solver_data(const Solver& solver) {
  return *solver.data_;
}

Solver::Solver(Tissue& tissue, const SolverOptions& asked) : tissue_(&tissue) {
  check_option_ranges(asked);
  SolverOptions options = asked;
  options.method = method_for(tissue.bodies(), asked);
  options.coarse_correction = coarse_correction_for(tissue, options);
  check_option_readers(options);
  check_materials(tissue.bodies(), options.mode);
  std::size_t hinge_count = 0;
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    hinge_count += tissue.is_hinge_alive(h) ? 1 : 0;
  }
  check_hinges(hinge_count, options.mode);
  check_vertex_method(tissue.bodies(), options);
  if (tissue.vertex_count() > kMostParticles) {
    throw InvalidArgument("the scene has " + std::to_string(tissue.vertex_count()) +
                          " vertices; a solver takes " + std::to_string(kMostParticles) +
                          " at most");
  }
  if (options.composition == PlanComposition::joint && tissue.version() != 0) {
    throw InvalidArgument("a joint plan is of tissue as a scene has it; this was edited");
  }
  if (!options.executor) {
    options.executor = executor::threads();
  }
  std::unique_ptr<SolverData> data = make_solver_data(tissue, options);
  // edits colour little, and must not fail
  data->options.coloring.executor = {};
  follow(std::move(data));
}

Solver::Solver(Tissue& tissue, std::unique_ptr<SolverData> data) : tissue_(&tissue) {
  follow(std::move(data));
}

void Solver::follow(std::unique_ptr<SolverData> data) {
  reserve_spare_room(*tissue_, data->options.spare);
  data->follow_tissue();
  data->free_pieces.refresh(*tissue_, data->place_of_vertex);  // the first step finds no memory
  data_ = std::move(data);
}

Solver::Solver(const Scene& scene, const SolverOptions& options)
    : Solver(std::make_unique<Tissue>(scene), options) {}

Solver::Solver(std::unique_ptr<Tissue> tissue, const SolverOptions& options)
    : Solver(*tissue, options) {
  data_->own_tissue = std::move(tissue);
}

Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

StepReport Solver::step(float dt) {
  start_step(dt);
  return finish_step();
}

void Solver::check_step(float dt) const {
  if (data_->step_in_flight != SolverData::Step::none) {
    throw InvalidArgument("a step was started and not finished: finish_step() comes first");
  }
  const int substeps = divide_step(dt, data_->rule_of_copies(), data_->options).substeps;
  const float h = dt / static_cast<float>(substeps);
  if (!(dt > 0) || !std::isfinite(dt) || !std::isfinite(kLargestCompliance / (h * h))) {
    std::ostringstream text;
    text << "dt is " << dt << " s in " << substeps
         << " substeps; it must be positive and finite, and so must 1e12 / substep^2";
    throw InvalidArgument(text.str());
  }
  if (is_explicit(data_->options)) {
    check_explicit_step(dt, data_->substep_rule, data_->options);
  }
}

void Solver::start_step(float dt) {
  check_step(dt);
  data_->start_step(dt);
}

namespace {

// Where options ask for it.
void refuse_dropped_contacts(const SolverData& data) {
  const DroppedContacts& dropped = data.report.dropped_contacts;
  if (!data.options.refuses_dropped_contacts || dropped.total() == 0) {
    return;
  }
  std::ostringstream text;
  text << "the step is done, but " << dropped.at_vertices << " contacts of tools with vertices, "
       << dropped.at_surfaces << " of tools with surfaces and " << dropped.of_bodies
       << " between bodies had no room in its substeps: contact_capacity is "
       << data.options.contact_capacity;
  throw Error(text.str());
}

}  // namespace

StepReport Solver::finish_step() {
  if (data_->step_in_flight == SolverData::Step::none) {
    throw InvalidArgument("no step was started that could be finished");
  }
  data_->finish_running_step();
  data_->step_in_flight = SolverData::Step::none;
  const int substeps =
      data_->report.stalled ? 0 : data_->part.before + data_->part.division.substeps;
  data_->report.substeps = substeps;
  data_->report.fast_tools = 0;
  for (Index i = 0; i < data_->copy_count(); ++i) {
    CopyState& copy = data_->copy(i);
    copy.last_report.substeps = substeps;
    copy.last_report.fast_tools = copy.fast_tools;
    data_->report.fast_tools += copy.fast_tools;
  }
  const Index interval = data_->options.convergence_interval;
  if (interval > 0 && ++data_->steps_since_convergence == interval) {
    data_->steps_since_convergence = 0;
    double largest = 0;
    for (const Convergence& body : convergence(data_->step_length)) {
      largest = std::max(largest, body.ratio());
    }
    data_->report.convergence = data_->last_report.convergence = static_cast<float>(largest);
  }
  refuse_dropped_contacts(*data_);
  return data_->report;
}

StepReport Solver::last_report(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->finish_running_step();
  return state.last_report;
}

const SolverOptions& Solver::options() const {
  return data_->options;
}
const StepPlan& Solver::plan() const {
  return data_->plan;
}
const char* Solver::backend_name() const {
  return data_->backend->name();
}

std::size_t Solver::memory_bytes() const {
  return data_->memory_bytes();
}

Index Solver::vertex_count() const {
  return static_cast<Index>(data_->particles.size());
}

Tissue& Solver::tissue() {
  static_cast<void>(*data_);  // throws if it was moved from
  return *tissue_;
}
const Tissue& Solver::tissue() const {
  static_cast<void>(*data_);
  return *tissue_;
}

float Solver::rest_length(Index edge) const {
  if (!tissue().is_edge_alive(edge)) {
    throw InvalidArgument("edge " + std::to_string(edge) + " was removed");
  }
  const auto& distances = data_->sets.of<DistanceConstraint>();
  const Index distance = data_->sets.distance_ids.of_edge(edge);
  if (!distances.is_alive(distance)) {
    throw InvalidArgument("edge " + std::to_string(edge) +
                          " belongs to a Neo-Hookean body, whose edges have no rest length");
  }
  return distances.record(distance).parameters[DistanceConstraint::kRest];
}

float Solver::rest_area(Index triangle) const {
  check_id("triangle", triangle, tissue().triangles().size());
  const auto& membranes = data_->sets.of<MembraneConstraint>();
  if (!membranes.is_alive(triangle)) {
    throw InvalidArgument("triangle " + std::to_string(triangle) + " was removed");
  }
  return static_cast<float>(pbdsurg::rest_area(membranes.record(triangle)));
}

float Solver::rest_volume(Index tet) const {
  check_id("tet", tet, tissue().tets().size());
  const auto& solids = data_->sets.of<NeoHookeanConstraint>();
  if (solids.is_alive(tet)) {
    return pbdsurg::rest_volume(solids.record(tet));
  }
  const auto& volumes = data_->sets.of<VolumeConstraint>();
  if (!volumes.is_alive(tet)) {
    throw InvalidArgument("tet " + std::to_string(tet) +
                          " was removed or belongs to a body without volume constraints");
  }
  return volumes.record(tet).parameters[VolumeConstraint::kRest];
}

}  // namespace pbdsurg
