// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"

#include "lib/base/check.h"
#include "lib/base/executor_state.h"
#include "lib/solver/host/host_backends.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/program/backend.h"
#include "lib/solver/program/solver_device.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
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

// @param options  with an executor
std::unique_ptr<SolverData> make_data_with_backend(const Tissue& tissue, SolverOptions options) {
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

CopyState& checked_copy(SolverData& data, Index copy) {
  if (copy < 0 || copy >= data.copy_count()) {
    throw InvalidArgument("there is no copy " + std::to_string(copy) + "; the solver has " +
                          std::to_string(data.copy_count()));
  }
  return data.copy(copy);
}

ToolState& checked_tool(CopyState& copy, ToolId tool) {
  if (tool < 0 || tool >= static_cast<Index>(copy.tools.size())) {
    throw InvalidArgument("there is no tool " + std::to_string(tool.value) + "; the solver has " +
                          std::to_string(copy.tools.size()));
  }
  return copy.tools[tool];
}

void check_pose(const ToolPose& pose) {
  constexpr float kRounding = 1e-3F;  // of a product of unit vectors
  const Eigen::Matrix3f rotation = pose.linear();
  if (!pose.matrix().allFinite() ||
      !(rotation.transpose() * rotation).isApprox(Eigen::Matrix3f::Identity(), kRounding) ||
      !(rotation.determinant() > 0)) {
    throw InvalidArgument("a tool's pose must be a finite translation and a rotation");
  }
}

void check_size(const char* what, std::size_t size, std::size_t expected) {
  if (size != expected) {
    throw InvalidArgument(std::string(what) + " has " + std::to_string(size) +
                          " entries; it needs " + std::to_string(expected));
  }
}

void check_finite(const char* what, std::span<const Eigen::Vector3f> values) {
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (!values[v].allFinite()) {
      throw InvalidArgument(std::string("the ") + what + " of vertex " + std::to_string(v) +
                            " is not finite");
    }
  }
}

}  // namespace

SolverOptions SolverOptions::paper() {
  SolverOptions options;
  options.mode = ProjectionMode::fraction;
  options.substeps = 1;
  options.iterations = 30;
  options.coloring = {.algorithm = ColoringAlgorithm::random_disc,
                      .disc = {.palette = Palette::conflicts}};
  options.composition = PlanComposition::separate;
  return options;
}

SolverData& solver_data(Solver& solver) {
  return *solver.data_;
}
const SolverData& solver_data(const Solver& solver) {
  return *solver.data_;
}

Solver::Solver(Tissue& tissue, const SolverOptions& options) : tissue_(&tissue) {
  check_options(options);
  check_materials(tissue.bodies(), options.mode);
  std::size_t hinge_count = 0;
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    hinge_count += tissue.is_hinge_alive(h) ? 1 : 0;
  }
  check_hinges(hinge_count, options.mode);
  check_vertex_method(tissue.bodies(), tissue.links(), options);
  if (tissue.vertex_count() > kMostParticles) {
    throw InvalidArgument("the scene has " + std::to_string(tissue.vertex_count()) +
                          " vertices; a solver takes " + std::to_string(kMostParticles) +
                          " at most");
  }
  if (options.composition == PlanComposition::joint && tissue.version() != 0) {
    throw InvalidArgument("a joint plan is of tissue as a scene has it; this was edited");
  }
  SolverOptions wanted = options;
  if (!wanted.executor) {
    wanted.executor = executor::threads();
  }
  std::unique_ptr<SolverData> data = make_data_with_backend(tissue, std::move(wanted));
  // edits colour little, and must not fail
  data->options.coloring.executor = {};
  reserve_spare_room(tissue, options.spare);
  data->follow_tissue();
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
  const float h = dt / static_cast<float>(data_->options.substeps);
  if (!(dt > 0) || !std::isfinite(dt) || !std::isfinite(kLargestCompliance / (h * h))) {
    std::ostringstream text;
    text << "dt is " << dt << " s in " << data_->options.substeps
         << " substeps; it must be positive and finite, and so must 1e12 / substep^2";
    throw InvalidArgument(text.str());
  }
}

void Solver::start_step(float dt) {
  check_step(dt);
  data_->start_step(dt);
}

StepReport Solver::finish_step() {
  if (data_->step_in_flight == SolverData::Step::none) {
    throw InvalidArgument("no step was started that could be finished");
  }
  data_->finish_running_step();
  data_->step_in_flight = SolverData::Step::none;
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

std::vector<Eigen::Vector3f> Solver::positions(Index copy) const {
  std::vector<Eigen::Vector3f> out(data_->particles.size());
  read_positions(out, copy);
  return out;
}

void Solver::read_positions(std::span<Eigen::Vector3f> out, Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  check_size("the buffer for positions", out.size(), state.particles.size());
  data_->fetch_state(copy);
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Particle& p = state.particles[places[v]];
    out[v] = {p.x, p.y, p.z};
  }
}

void Solver::read_positions(std::span<const Index> vertices, std::span<Eigen::Vector3f> out,
                            Index copy) const {
  checked_copy(*data_, copy);
  check_size("the buffer for positions", out.size(), vertices.size());
  const std::size_t vertex_count = data_->particles.size();
  for (const Index v : vertices) {
    check_id("vertex", v, vertex_count);
  }
  data_->read_positions(copy, vertices, out);
}

void Solver::watch(std::span<const Index> vertices) {
  const std::size_t vertex_count = data_->particles.size();
  for (const Index v : vertices) {
    check_id("vertex", v, vertex_count);
  }
  data_->finish_running_step();
  std::vector<Index> places;
  for (const Index v : vertices) {
    places.push_back(data_->place_of_vertex[v]);
  }
  std::vector<std::vector<Eigen::Vector3f>> watched(static_cast<std::size_t>(data_->copy_count()),
                                                    std::vector<Eigen::Vector3f>(vertices.size()));
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->read_positions(copy, vertices, watched[copy]);
  }
  data_->changes.watched = true;  // nothing fails from here on
  data_->watched_places = std::move(places);
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->copy(copy).watched_positions = std::move(watched[copy]);
  }
}

std::span<const Eigen::Vector3f> Solver::watched_positions(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->finish_running_step();
  return state.watched_positions;
}

void Solver::write_positions(std::span<const Eigen::Vector3f> positions, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the array of positions", positions.size(), state.particles.size());
  check_finite("position", positions);
  data_->finish_running_step();
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Index place = places[v];
    Particle& p = state.particles[place];
    p = {positions[v].x(), positions[v].y(), positions[v].z(), p.w};
    state.velocities[place] = {};
  }
  std::fill(state.falling.begin(), state.falling.end(), 1.0F);
  state.is_state_current = true;  // whatever the backend has
  data_->changes.state[copy] = true;
}

std::vector<Eigen::Vector3f> Solver::velocities(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  std::vector<Eigen::Vector3f> out;
  out.reserve(state.velocities.size());
  for (const Index place : data_->place_of_vertex) {
    const Velocity& velocity = state.velocities[place];
    out.emplace_back(velocity.x, velocity.y, velocity.z);
  }
  return out;
}

void Solver::write_velocities(std::span<const Eigen::Vector3f> velocities, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the array of velocities", velocities.size(), state.velocities.size());
  check_finite("velocity", velocities);
  data_->fetch_state(copy);  // positions stay
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    state.velocities[places[v]] = {velocities[v].x(), velocities[v].y(), velocities[v].z()};
  }
  data_->changes.state[copy] = true;
}

Snapshot Solver::snapshot(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  Snapshot snapshot{
      positions(copy), velocities(copy), {}, tissue().identified_version(), state.falling};
  for (const ToolState& tool : state.tools) {
    snapshot.tool_poses.push_back(tool.pose);
  }
  return snapshot;
}

void Solver::restore(const Snapshot& snapshot, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the snapshot's positions", snapshot.positions.size(), state.particles.size());
  check_size("the snapshot's velocities", snapshot.velocities.size(), state.particles.size());
  check_size("the snapshot's tool poses", snapshot.tool_poses.size(), state.tools.size());
  check_size("the snapshot's shares of gravity", snapshot.falling.size(), state.falling.size());
  const TissueVersion now = tissue().identified_version();
  if (snapshot.tissue.tissue != now.tissue) {
    throw InvalidArgument("the snapshot is of another tissue");
  }
  if (snapshot.tissue.number != now.number) {
    throw InvalidArgument("the snapshot is of topology version " +
                          std::to_string(snapshot.tissue.number) + ", the solver is at " +
                          std::to_string(now.number));
  }
  check_finite("position", snapshot.positions);
  check_finite("velocity", snapshot.velocities);
  for (const ToolPose& pose : snapshot.tool_poses) {
    check_pose(pose);
  }
  for (const float share : snapshot.falling) {
    if (!(share >= 0) || !(share <= 1)) {
      throw InvalidArgument("a share of gravity in the snapshot is " + std::to_string(share) +
                            "; it must be in [0, 1]");
    }
  }
  write_positions(snapshot.positions, copy);
  state.falling = snapshot.falling;
  write_velocities(snapshot.velocities, copy);
  for (std::size_t t = 0; t < state.tools.size(); ++t) {
    ToolState& tool = state.tools[t];
    tool.pose = tool.target = snapshot.tool_poses[t];
    tool.attachments.clear();
    data_->forget_releases(copy, static_cast<Index>(t));
    tool.contacts.clear();
    tool.force.setZero();
  }
  state.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
}

std::uint64_t Solver::state_hash(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  std::uint64_t hash = state.particles.size();
  const auto mix = [&hash](float value) {
    hash = detail::mix_bits(hash, std::bit_cast<std::uint32_t>(value));
  };
  for (const Index place : data_->place_of_vertex) {
    const Particle& p = state.particles[place];
    const Velocity& velocity = state.velocities[place];
    for (const float value : {p.x, p.y, p.z, velocity.x, velocity.y, velocity.z}) {
      mix(value);
    }
  }
  return hash;
}

ToolId Solver::add_tool(std::span<const Capsule> capsules, const ToolPose& pose) {
  for (std::size_t c = 0; c < capsules.size(); ++c) {
    const Capsule& capsule = capsules[c];
    if (!capsule.start.allFinite() || !capsule.end.allFinite() || !(capsule.radius > 0) ||
        !std::isfinite(capsule.radius)) {
      throw InvalidArgument("capsule " + std::to_string(c) + " has radius " +
                            std::to_string(capsule.radius) +
                            " m; ends must be finite and the radius positive");
    }
  }
  check_pose(pose);
  ToolState tool;
  tool.capsules.assign(capsules.begin(), capsules.end());
  tool.pose = tool.target = pose;
  data_->finish_running_step();
  std::vector<ToolState> added(static_cast<std::size_t>(data_->copy_count()), tool);
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->reserve_tool(added[copy]);
    data_->copy(copy).tools.reserve(data_->copy(copy).tools.size() + 1);
  }
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {  // nothing fails from here on
    data_->copy(copy).tools.push_back(std::move(added[copy]));
  }
  data_->changes.tools = true;
  data_->rebuild_plan();
  return ToolId(static_cast<Index>(data_->tools.size()) - 1);
}

void Solver::move_tool(ToolId tool, const ToolPose& pose, Index copy) {
  ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  check_pose(pose);
  data_->finish_running_step();
  state.target = pose;
}

ToolPose Solver::tool_pose(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  return state.pose;
}

ToolPose Solver::tool_target(ToolId tool, Index copy) const {
  return checked_tool(checked_copy(*data_, copy), tool).target;
}

void Solver::grasp(ToolId tool, std::span<const Index> vertices, float compliance, Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  if (!(compliance >= 0) || !(compliance <= kLargestCompliance)) {
    throw InvalidArgument("grasp compliance is " + std::to_string(compliance) +
                          " m/N; it must be in [0, 1e12]");
  }
  std::vector<bool> held(data_->particles.size(), false);
  for (const Attachment& attachment : state.attachments) {
    held[attachment.vertex] = true;
  }
  for (const Index v : vertices) {
    check_id("vertex", v, data_->particles.size());
    if (!tissue().has_tissue(v)) {
      throw InvalidArgument("vertex " + std::to_string(v) + " has no tissue left to hold");
    }
    if (held[v]) {
      throw InvalidArgument("tool " + std::to_string(tool.value) + " holds vertex " +
                            std::to_string(v) + " already");
    }
    held[v] = true;
  }
  std::vector<Eigen::Vector3f> positions(vertices.size());
  data_->read_positions(copy, vertices, positions);
  const ToolPose to_tool = state.pose.inverse();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f& x = positions[i];
    state.attachments.push_back(
        {vertices[i], to_tool * x, compliance, x, Eigen::Vector3f::Zero(), 0});
  }
  owner.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
}

void Solver::release(ToolId tool, Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  data_->finish_running_step();
  state.attachments.clear();
  data_->forget_releases(copy, tool);
  owner.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
}

Eigen::Vector3f Solver::tool_force(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  return state.force;
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
