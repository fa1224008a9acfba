// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/contact/proximity.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Capsule;

std::int64_t now() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

// Capsules in the tool's frame: the tip at the origin, the shaft along +z.
const std::vector<Capsule>& hook_capsules() {
  static const std::vector<Capsule> capsules{{{0, 0, 0}, {0.003F, 0, 0.001F}, 0.0005F},
                                             {{0.003F, 0, 0.001F}, {0.003F, 0, 0.012F}, 0.0006F},
                                             {{0.003F, 0, 0.014F}, {0.003F, 0, 0.25F}, 0.0025F}};
  return capsules;
}

const std::vector<Capsule>& grasper_capsules() {
  static const std::vector<Capsule> capsules{{{0, 0, 0}, {0, 0, 0.016F}, 0.0018F},
                                             {{0, 0, 0.018F}, {0, 0, 0.25F}, 0.0025F}};
  return capsules;
}

// Tissue pushes a hand away, however hard the script aims through it.
constexpr pbdsurg::ToolCoupling kHand{.stiffness = 500};  // N/m

// What the strands between gallbladder and liver leave free does not pass through the other.
constexpr pbdsurg::TissueContact kBed{.thickness = 0.5e-3F, .friction = 0.1F};

pbdsurg::CauteryOptions hook_options() {
  pbdsurg::CauteryOptions options;
  options.contact_radius = 1.5e-3;
  // thinned by traction: so that the gallbladder comes off within the script's time
  options.link_energy = 0.008;
  options.link_conductance = 3e-3;
  return options;
}

// A hand's tremor: 0.1 mm at about 9 Hz (physiological tremor is 8 to 12 Hz), from the seed alone.
Eigen::Vector3f tremor(std::uint64_t seed, pbdsurg::ToolId tool, double time) {
  Eigen::Vector3f offset;
  for (int axis = 0; axis < 3; ++axis) {
    const double phase = 2 * std::numbers::pi * pbdsurg::random_unit(seed, tool, 2 * axis);
    const double rate = 8 + 3 * pbdsurg::random_unit(seed, tool, 2 * axis + 1);
    offset[axis] = static_cast<float>(1e-4 * std::sin(2 * std::numbers::pi * rate * time + phase));
  }
  return offset;
}

// Turns the shaft towards the port.
void aim(Instrument& instrument) {
  instrument.orientation = Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(),
                                                              instrument.port - instrument.tip);
}

Instrument make_instrument(pbdsurg::World& world, const std::vector<Capsule>& capsules,
                           const Eigen::Vector3f& port, const Eigen::Vector3f& tip) {
  Instrument instrument{.port = port, .tip = tip};
  aim(instrument);
  instrument.tool = world.add_tool(capsules, instrument.pose());
  return instrument;
}

}  // namespace

void Range::add(double value) {
  least = std::min(least, value);
  most = std::max(most, value);
  sum += value;
  ++count;
}

StageTimer::StageTimer(StageTimes& times, const std::string& stage)
    : total_(times[stage]), start_(now()) {}

StageTimer::~StageTimer() {
  total_ += 1e-6 * static_cast<double>(now() - start_);
}

pbdsurg::ToolPose Instrument::pose() const {
  pbdsurg::ToolPose pose = pbdsurg::ToolPose::Identity();
  pose.linear() = orientation.toRotationMatrix();
  pose.translation() = tip + offset;
  return pose;
}

pbdsurg::SolverOptions solver_options(const pbdsurg::Executor& executor, bool paper) {
  pbdsurg::SolverOptions options{.method = pbdsurg::SolverMethod::vertex_block,
                                 .substeps = 1,
                                 .iterations = 4,
                                 .over_relaxation = 1.2F,
                                 .coarse_correction = pbdsurg::CoarseCorrection::on};
  if (paper) {
    options = pbdsurg::SolverOptions::paper();
  }
  options.damping = paper ? 60 : 20;
  options.executor = executor;
  return options;
}

Simulation::Simulation(const SurgicalScene& surgical_scene, const pbdsurg::SolverOptions& options,
                       std::optional<std::uint64_t> seed, StageTimes& stage_times, double step)
    : scene(surgical_scene),
      time_step(step),
      world(scene.scene, scene.tissues, scene.connections, options),
      solver(world.solver()),
      connections(world.strands()),
      grasper(make_instrument(world, grasper_capsules(), {-0.05F, 0.05F, -0.16F},
                              {-0.04F, 0.03F, -0.06F})),
      hook(
          make_instrument(world, hook_capsules(), {0.12F, -0.08F, -0.16F}, {0.1F, -0.04F, -0.06F})),
      burner(world.add_cautery(hook.tool, kBurnable, hook_options())),
      cautery(world.cautery(burner)),
      times(stage_times),
      seed_(seed) {
  for (const Instrument& instrument : {grasper, hook}) {
    world.couple(instrument.tool, kHand);
  }
  world.set_contact(body_of(Organ::gallbladder), body_of(Organ::liver), kBed);
  find_surfaces();
}

Simulation::Simulation(const SurgicalScene& surgical_scene, const SimulationState& state,
                       StageTimes& stage_times, double step)
    : scene(surgical_scene),
      time_step(step),
      world(state.world),
      solver(world.solver()),
      connections(world.strands()),
      grasper(state.grasper),
      hook(state.hook),
      burner(state.burner),
      cautery(world.cautery(burner)),
      last_burn(state.last_burn),
      totals(state.totals),
      times(stage_times) {
  find_surfaces();
}

SimulationState Simulation::save() const {
  return {world.save(), grasper, hook, burner, last_burn, totals};
}

void Simulation::find_surfaces() {
  for (const Organ organ : pbdsurg::kOrgans) {
    surfaces_.push_back(&world.surface(body_of(organ)));
  }
}

void Simulation::place(Instrument& instrument) {
  if (instrument.is_aimed && instrument.held.empty()) {
    aim(instrument);
  }
  pbdsurg::ToolPose pose = instrument.pose();
  if (seed_) {
    pose.translation() += tremor(*seed_, instrument.tool, time());
  }
  world.move(instrument.tool, pose);
}

void Simulation::advance(const std::optional<pbdsurg::GeneratorSettings>& settings) {
  for (Instrument* instrument : {&grasper, &hook}) {
    place(*instrument);
  }
  hook_power = settings ? settings->power : 0;
  world.energise(burner, settings);
  const pbdsurg::Frame frame = world.step(time_step);
  times["cautery"] += 1e3 * frame.times.heat;
  times["tearing"] += 1e3 * frame.times.edit;
  times["solve"] += 1e3 * frame.times.step;
  times["readback"] += 1e3 * frame.times.readback;
  totals.tets_deleted += frame.removed_tets;
  totals.links_cut += frame.removed_links;
  if (totals.refused_edits == 0 && !frame.refused.empty()) {
    totals.first_refusal = frame.why();
  }
  totals.refused_edits += static_cast<std::int64_t>(frame.refused.size());
  count(frame.cauteries.front());
  ++totals.steps;
  totals.grasper_touches += world.force(grasper.tool).isZero(0) ? 0 : 1;
  totals.hook_touches += world.force(hook.tool).isZero(0) ? 0 : 1;
  const pbdsurg::StepReport& report = frame.report;
  totals.residual_last = std::max(report.distance_residual, report.volume_residual);
  totals.residual_max = std::max(totals.residual_max, totals.residual_last);
  totals.inverted_tets_max = std::max(totals.inverted_tets_max, report.inverted_tets);
  totals.non_finite_vertices = report.non_finite_vertices;
  totals.dropped_contacts += report.dropped_contacts.total();
}

void Simulation::count(const pbdsurg::CauteryReport& report) {
  last_burn = report;
  totals.tets_torn_by_steam += report.torn;
  totals.tets_deferred_max = std::max(totals.tets_deferred_max, report.deferred);
  totals.unconverged += report.converged ? 0 : 1;
  totals.hottest = std::max(totals.hottest, report.hottest);
  if (report.energy > 0) {
    totals.burn_power.add(report.power);
    totals.burn_resistance.add(report.resistance);
    totals.burn_voltage.add(report.voltage);
    totals.sparks += report.is_arcing ? 1 : 0;
  }
}

std::vector<pbdsurg::Index> Simulation::grasp(Organ organ, float radius) {
  constexpr std::size_t kFewest = 4;
  std::vector<pbdsurg::Index> vertices;
  const Eigen::Vector3f tip = pose_of(grasper).translation();
  for (const float factor : {1.0F, 2.0F, 4.0F, 8.0F}) {
    vertices = pbdsurg::find_vertices_near(solver, body_of(organ), tip, factor * radius);
    if (vertices.size() >= kFewest) {
      break;
    }
  }
  if (vertices.empty()) {
    throw CannotGoOn(std::string("the grasper finds no ") + pbdsurg::name_of(organ) + " to hold");
  }
  grasper.offset = solver.tool_displacement(grasper.tool);
  world.couple(grasper.tool, {});  // what holds has no spring
  world.grasp(grasper.tool, vertices);
  grasper.held = vertices;
  return vertices;
}

void Simulation::release() {
  world.release(grasper.tool);
  world.couple(grasper.tool, kHand);
  grasper.offset.setZero();
  grasper.held.clear();
}

pbdsurg::ToolPose Simulation::pose_of(const Instrument& instrument) const {
  return Eigen::Translation3f(solver.tool_displacement(instrument.tool)) *
         world.pose(instrument.tool);
}

void Simulation::approach(Instrument& instrument, const Eigen::Vector3f& point, float speed) {
  const Eigen::Vector3f way = point - instrument.tip;
  const float reach = speed * static_cast<float>(time_step);
  instrument.tip += way.norm() <= reach ? way : Eigen::Vector3f(reach / way.norm() * way);
}

std::vector<Eigen::Vector3f> Simulation::tissue_of(Organ organ) const {
  std::vector<Eigen::Vector3f> tissue;
  for (std::size_t v = 0; v < surface(organ).vertices().size(); ++v) {
    if (solver.tissue().has_tissue(surface(organ).vertices()[v])) {
      tissue.push_back(surface(organ).positions()[v]);
    }
  }
  return tissue;
}

}  // namespace cholecystectomy
