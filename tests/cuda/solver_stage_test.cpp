// SPDX-License-Identifier: Apache-2.0
// A step on a device, part by part: the first that has other bits than the host is named.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/constraint_buffers.h"
#include "cuda/solver/state_buffers.h"
#include "cuda/solver/step_kernels.h"
#include "cuda/solver/sweeps.h"
#include "cuda/solver/tool_buffers.h"
#include "cuda/solver/vertex_buffers.h"
#include "cuda/stream.cuh"
#include "lib/solver/host/serial_phases.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/state_report.h"
#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/host_stages.h"
#include "tests/support/inspect.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;
using pbdsurg::testing::Variant;
using testing::HostStages;

constexpr float kTimeStep = 2e-3F;  // s

/// What a CUDA backend has, without the backend.
struct Device {
  explicit Device(SolverData& data, const StageRecords& records) : state(data) {
    constraints.upload(records, true, 1, stream.get());
    vertices.upload(data, false, stream.get());
    state.take_over(data, stream.get());
    tools.take_over(data, state.arrays().capacity, stream.get());
    tools.upload(data, nullptr, 0, stream.get());
  }

  std::vector<Particle> particles() { return of_places(state.arrays().particles); }
  std::vector<Particle> displacements() { return of_places(state.arrays().displacements); }

  template <class T>
  std::vector<T> of_places(const T* array) {
    return all(array, static_cast<std::size_t>(state.arrays().capacity));
  }

  template <class T>
  std::vector<T> all(const T* array, std::size_t count) {
    stream.wait();
    std::vector<T> result(count);
    copy(result.data(), array, count);
    return result;
  }

  template <class T>
  void copy(T* to, const T* from, std::size_t count) {
    PBDSURG_CUDA_CHECK(cudaMemcpy(to, from, count * sizeof(T), cudaMemcpyDeviceToHost));
  }

  Stream stream;
  StateBuffers state;
  ConstraintBuffers constraints;
  VertexBuffers vertices;
  ToolBuffers tools;
};

// Where the bits of two states differ first: for a message that says how much.
template <class Quad>
std::string difference(const std::vector<Quad>& device, const std::vector<Quad>& host) {
  for (std::size_t place = 0; place < host.size(); ++place) {
    const Quad& a = device[place];
    const Quad& b = host[place];
    if (std::memcmp(&a, &b, sizeof a) != 0) {
      return "place " + std::to_string(place) + ": device " + std::to_string(a.x) + " " +
             std::to_string(a.y) + " " + std::to_string(a.z) + ", host " + std::to_string(b.x) +
             " " + std::to_string(b.y) + " " + std::to_string(b.z) + ", apart by " +
             std::to_string(1e9F * (load(a) - load(b)).x) + " " +
             std::to_string(1e9F * (load(a) - load(b)).y) + " " +
             std::to_string(1e9F * (load(a) - load(b)).z) + " nm";
    }
  }
  return {};
}

// Velocities and, in compliance mode, carries; unused numbers of a velocity are the device's own.
std::string motion_difference(Device& device, const SolverData& data) {
  std::vector<Velocity> velocities = device.of_places(device.state.arrays().velocities);
  for (Velocity& velocity : velocities) {
    velocity.unused = 0;
  }
  std::string found = difference(velocities, data.velocities);
  if (found.empty() && !data.carries.empty()) {
    found = difference(device.of_places(device.state.arrays().carries), data.carries);
  }
  return found;
}

bool same_points(Device& device, const SolverData& data) {
  const std::vector<FixedPoint> here = device.of_places(device.state.arrays().fixed_points);
  const std::vector<FixedPoint>& there = data.step_scratch.fixed_points;
  return std::memcmp(here.data(), there.data(), there.size() * sizeof there[0]) == 0;
}

// Some that no step would leave.
void carry_something(SolverData& data) {
  for (std::size_t place = 0; place < data.carries.size(); ++place) {
    const auto i = static_cast<float>(place);
    data.carries[place] = {1e-7F * i, -2e-7F * i, 3e-8F * i,
                           0.125F * static_cast<float>(place % 9)};
  }
}

std::string name_of(const Stage& stage) {
  constexpr std::array kNames{"distance",   "volume",   "joint",        "neo_hookean",
                              "fibre",      "membrane", "strain_limit", "bending",
                              "stiff_link", "vertex",   "attachment",   "contact"};
  return std::string(kNames[static_cast<std::size_t>(stage.kind)]) + ", " +
         std::to_string(stage.count) + " from " + std::to_string(stage.first) + ", levels " +
         std::to_string(stage.level_count);
}

// Of all that can be projected in a mode.
Scene make_scene(ProjectionMode mode, float damping) {
  Scene scene = pbdsurg::testing::make_eventful_scene(mode, damping);
  if (mode == ProjectionMode::compliance) {
    const auto sheet = pbdsurg::testing::make_sheet({6, 5}, pbdsurg::testing::kEventfulEdge, 0.2);
    scene.add_sheet("sheet", sheet.positions, sheet.triangles, {.damping = damping});
    pbdsurg::testing::give_solid_fibres(scene);
  }
  return scene;
}

// Two pushers, one of them too deep for the capacity, and two holders of the same vertices.
void add_tools(Solver& solver) {
  const std::array capsules{Capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F},
                            Capsule{{0, 0, 0}, {0, 0.004F, 0.002F}, 3e-3F}};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.013F, 0.006F);
  solver.add_tool(capsules, pose, {ContactFeatures::vertices});
  pose.translation() = Eigen::Vector3f(0.01F, 0.004F, 0.012F);
  solver.add_tool(std::span(capsules).first(1), pose, {ContactFeatures::vertices});
  pose.linear() = Eigen::AngleAxisf(0.3F, Eigen::Vector3f::UnitX()).toRotationMatrix();
  solver.move_tool(ToolId{1}, pose);
  const ToolId holder = solver.add_tool({}, ToolPose::Identity());
  const ToolId other =
      solver.add_tool(std::span(capsules).first(1), pose, {ContactFeatures::vertices});
  solver.grasp(holder, std::array<Index, 3>{99, 98, 97}, 1e-4F);
  solver.grasp(other, std::array<Index, 2>{98, 90}, 0);
  pose.translation() += Eigen::Vector3f(0, 1e-3F, 5e-4F);
  solver.move_tool(other, pose);
}

void check_wrenches(const Wrench* wrenches, const std::vector<ToolState>& tools) {
  for (std::size_t t = 0; t < tools.size(); ++t) {
    INFO("tool " << t);
    CHECK(vector_of(wrenches[t].force) == tools[t].force);
    CHECK(vector_of(wrenches[t].torque) == tools[t].torque);
  }
}

}  // namespace

TEST_CASE("cuda step: every part of a strict step has the serial bits", "[device]") {
  const Variant variant = GENERATE(from_range(testing::plan_variants()));
  INFO("mode " << static_cast<int>(variant.mode) << ", composition "
               << static_cast<int>(variant.composition) << ", at most " << variant.max_colors
               << " colors, damping " << variant.damping);
  SolverOptions options = pbdsurg::testing::options_of(variant);
  options.executor = executor::serial();
  options.contact_capacity = 7;
  options.damping = 0;
  Solver solver(make_scene(variant.mode, variant.damping), options);
  std::vector<Eigen::Vector3f> moving = solver.positions();
  for (std::size_t v = 0; v < moving.size(); ++v) {
    moving[v] *= v % 3 == 0 ? 5 : -3;  // m/s
  }
  solver.write_velocities(moving);
  add_tools(solver);
  SolverData& data = inspect(solver);
  data.step_scratch.fit(data);
  data.part = whole_step(kTimeStep, {2, 2});
  carry_something(data);
  const StepContext step{data, data, data.step_scratch};
  const bool displaces = has_displacements(options);
  HostStages stages(data);
  Device device(data, stages.records);
  const StepKernels& kernels = strict_kernels;
  const DeviceState& state = device.state.arrays();
  StepInput* const input = device.tools.input();
  const Launch launch{device.stream.get(), false};

  const auto same_vertices = [&] {
    return difference(device.particles(), data.particles).empty() &&
           (!displaces ||
            difference(device.displacements(), data.step_scratch.displacements).empty());
  };

  // prediction
  const float h = kTimeStep / 2;
  const FreeMotion<float> motion = free_motion(data, data, h);
  const Substep<float> substep{1 / h, 1 / (h * h)};
  (displaces ? predict_displacements : predict_positions)(step, motion);
  kernels.advance(state, input, false, true, launch);
  REQUIRE(same_vertices());

  // contacts
  StepReport report;
  begin_tools(data);
  place_tools(data, 0.5F);
  find_contacts(step, substep, report);
  REQUIRE(report.contacts > 7);
  REQUIRE(report.dropped_contacts.total() > 0);
  kernels.find_contacts(state, device.tools.arrays(), input, 0, launch);
  device.stream.wait();
  const ToolArrays& tools = device.tools.arrays();
  for (Index pusher = 0; pusher < 2; ++pusher) {  // the first tools
    const std::vector<Contact>& expected = data.tools[pusher].contacts;
    Index count = 0;
    device.copy(&count, tools.contact_counts + pusher, 1);
    REQUIRE(count == static_cast<Index>(expected.size()));
    std::vector<Index> places(expected.size());
    device.copy(places.data(), tools.contact_places + pusher * tools.contact_room, places.size());
    for (std::size_t c = 0; c < places.size(); ++c) {
      REQUIRE(places[c] == expected[c].place);
      CapsulePlane plane;
      device.copy(&plane, tools.planes + pusher * state.capacity + places[c], 1);
      REQUIRE(plane.normal.x == expected[c].normal.x());
      REQUIRE(plane.normal.y == expected[c].normal.y());
      REQUIRE(plane.normal.z == expected[c].normal.z());
      REQUIRE(plane.offset == expected[c].offset);
    }
  }

  // sweeps
  for (int iteration = 0; iteration < 2; ++iteration) {
    const Projection projection{variant.mode, data.sets.has_damping, iteration > 0, iteration == 0};
    for (const Stage& stage : stages.plan.stages()) {
      INFO("sweep " << iteration << ", " << name_of(stage));
      stages.project(stage, moving_vertices(step), data.carries, substep);
      kernels.project(stage, projection, state, device.constraints.arrays(), input, launch);
      REQUIRE(same_vertices());
    }
    for (const PhaseKind kind : {PhaseKind::attachment, PhaseKind::contact}) {
      INFO("sweep " << iteration << ", kind " << static_cast<int>(kind));
      for (const Phase& phase : data.plan.phases) {
        if (phase.kind == kind) {
          project_serially(step, phase, substep);
        }
      }
      if (kind == PhaseKind::attachment) {
        kernels.project_attachments(state, tools, input, 0, iteration == 0, launch);
      } else {
        kernels.project_contacts(state, tools, input, launch);
      }
      REQUIRE(same_vertices());
    }
  }

  // velocities, forces and the report
  const float scale = substep.inverse_dt_squared / 2;
  collect_tool_forces(step, scale);
  (displaces ? settle_vertices : update_velocities)(step, motion);
  report_vertices(data, data, report);
  report_constraints(data, data, report);
  report_tubes(data, data, report);
  kernels.collect_forces(state, tools, input, 0, launch);
  kernels.advance(state, input, true, false, launch);
  PinnedBuffer<StepSums> sums;
  PinnedBuffer<Wrench> wrenches;
  kernels.report(state, device.constraints.arrays(), input,
                 {sums.reserve(1), wrenches.reserve(data.tools.size()), nullptr, nullptr}, launch);
  device.stream.wait();
  check_wrenches(wrenches.get(), data.tools);
  CHECK(sums.get()->contacts == report.contacts);
  CHECK(sums.get()->dropped_contacts == report.dropped_contacts);
  CHECK(sums.get()->inverted_tets == report.inverted_tets);
  CHECK(sums.get()->non_finite_vertices == 0);
  CHECK(std::bit_cast<float>(sums.get()->distance_residual) == report.distance_residual);
  CHECK(std::bit_cast<float>(sums.get()->volume_residual) == report.volume_residual);
  REQUIRE(same_vertices());
  REQUIRE(motion_difference(device, data).empty());
}

namespace {

// Of used lanes: the first number that differs.
template <class Row, std::size_t kLanes>
std::string row_difference(const char* what, const std::vector<Row>& device,
                           std::span<const Row> host, RowRange range, Index lane_count,
                           float (Row::*numbers)[kLanes]) {
  for (Index i = range.first; i < range.first + range.count; ++i) {
    for (Index lane = 0; lane < lane_count; ++lane) {
      const float a = (device[i].*numbers)[lane];
      const float b = (host[i].*numbers)[lane];
      if (std::memcmp(&a, &b, sizeof a) != 0) {
        return std::string(what) + " of row " + std::to_string(i) + ", lane " +
               std::to_string(lane) + ": device " + std::to_string(a) + ", host " +
               std::to_string(b);
      }
    }
  }
  return {};
}

std::string row_difference(Device& device, const VertexBlocks& blocks) {
  const VertexBlocks::Arrays host = blocks.arrays();
  const VertexArrays& there = device.vertices.arrays();
  const std::vector<SpringRow> springs = device.all(there.springs, host.springs.size());
  const std::vector<VolumeRow> volumes = device.all(there.volumes, host.volumes.size());
  const std::vector<HingeRow> hinges = device.all(there.hinges, host.hinges.size());
  const std::vector<TriangleRow> triangles = device.all(there.triangles, host.triangles.size());
  for (const VertexBlock& block : host.blocks) {
    for (const std::string& text :
         {row_difference("stiffness", springs, host.springs, block.springs, block.lane_count,
                         &SpringRow::stiffness),
          row_difference("rest", springs, host.springs, block.springs, block.lane_count,
                         &SpringRow::rest),
          row_difference("volume stiffness", volumes, host.volumes, block.volumes, block.lane_count,
                         &VolumeRow::stiffness),
          row_difference("target", volumes, host.volumes, block.volumes, block.lane_count,
                         &VolumeRow::target),
          row_difference("hinge moment", hinges, host.hinges, block.hinges, block.lane_count,
                         &HingeRow::moment),
          row_difference("hinge stiffness", hinges, host.hinges, block.hinges, block.lane_count,
                         &HingeRow::stiffness),
          row_difference("hinge rest", hinges, host.hinges, block.hinges, block.lane_count,
                         &HingeRow::rest),
          row_difference("hinge damping", hinges, host.hinges, block.hinges, block.lane_count,
                         &HingeRow::damping),
          row_difference("hinge start", hinges, host.hinges, block.hinges, block.lane_count,
                         &HingeRow::start),
          row_difference("triangle stiffness", triangles, host.triangles, block.triangles,
                         block.lane_count, &TriangleRow::stiffness),
          row_difference("triangle target", triangles, host.triangles, block.triangles,
                         block.lane_count, &TriangleRow::target)}) {
      if (!text.empty()) {
        return text;
      }
    }
  }
  return {};
}

}  // namespace

TEST_CASE("cuda step: every part of a strict step of vertex blocks has the serial bits",
          "[device]") {
  const float damping = GENERATE(0.0F, 0.01F);
  const bool has_tools = GENERATE(false, true);
  INFO("damping " << damping << (has_tools ? ", with tools" : ", without tools"));
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 2,
                        .over_relaxation = 1.5F,
                        .contact_capacity = 7,
                        .executor = executor::serial(),
                        .composition = PlanComposition::separate};
  Solver solver(make_scene(ProjectionMode::compliance, damping), options);
  std::vector<Eigen::Vector3f> moving = solver.positions();
  for (std::size_t v = 0; v < moving.size(); ++v) {
    moving[v] *= v % 3 == 0 ? 5 : -3;  // m/s
  }
  solver.write_velocities(moving);
  if (has_tools) {
    add_tools(solver);
  }
  SolverData& data = inspect(solver);
  data.step_scratch.fit(data);
  data.part = whole_step(kTimeStep, {2, 2});
  const StepContext step{data, data, data.step_scratch};
  carry_something(data);
  HostStages stages(data);
  Device device(data, stages.records);
  const StepKernels& kernels = strict_kernels;
  const DeviceState& state = device.state.arrays();
  const VertexArrays& vertices = device.vertices.arrays();
  const ToolArrays& tools = device.tools.arrays();
  StepInput* const input = device.tools.input();
  const Launch launch{device.stream.get(), false};
  REQUIRE(motion_difference(device, data).empty());
  REQUIRE(row_difference(device, data.vertex_blocks).empty());

  // two substeps: prediction, contacts, holds, damping, sweeps, forces, and in between velocities
  const float h = kTimeStep / 2;
  const FreeMotion<float> motion = free_motion(data, data, h);
  const Substep<float> lengths{1 / h, 1 / (h * h)};
  StepReport report;
  Index contacts = 0;
  begin_tools(data);
  for (Index substep = 0; substep < 2; ++substep) {
    INFO("substep " << substep);
    if (substep > 0) {
      settle_vertices(step, motion);
    }
    predict_displacements(step, motion);
    kernels.advance(state, input, substep > 0, true, launch);
    REQUIRE(difference(device.particles(), data.particles).empty());
    REQUIRE(motion_difference(device, data).empty());
    REQUIRE(difference(device.of_places(state.flights), data.step_scratch.flights).empty());
    REQUIRE(difference(device.displacements(), data.step_scratch.displacements).empty());
    REQUIRE(same_points(device, data));

    place_tools(data, substep == 0 ? 0.5F : 1.0F);
    find_contacts(step, lengths, report);
    gather_holds(step);
    damp_rows(step, lengths.inverse_dt);
    if (has_tools) {
      contacts += report.contacts;
      kernels.find_contacts(state, tools, input, substep, launch);
    }
    kernels.prepare_vertices(state, vertices, tools, input, has_tools, launch);
    REQUIRE(row_difference(device, data.vertex_blocks).empty());
    if (has_tools) {
      const VertexBlocks& blocks = data.vertex_blocks;
      const std::vector<Index> holds =
          device.all(vertices.holds, static_cast<std::size_t>(blocks.block_count() * kBlockLanes));
      for (Index place = 0; place < state.capacity; ++place) {
        const auto [block, lane] = blocks.place_of(place);
        if (block != kInvalidIndex) {
          INFO("what tools do at place " << place);
          REQUIRE((holds[block * kBlockLanes + lane] == kInvalidIndex) ==
                  (data.step_scratch.first_holds[place] == kInvalidIndex));
        }
      }
    }

    const VertexState linked = vertex_state(step, lengths, 1);
    for (Index block = 0; block < data.vertex_blocks.block_count(); ++block) {
      find_loose_ends(step, linked, block, data.step_scratch.linked[block]);
    }
    find_lone_ends(step, linked);
    Index joints = 0;
    for (const Phase& phase : data.plan.phases) {
      if (phase.kind == PhaseKind::stiff_link) {
        begin_joints(step, linked, phase.color);
        joints += data.sets.of<StiffLinkConstraint>().size(phase.color);
      }
    }
    REQUIRE(joints > 0);
    kernels.find_loose_ends(substep, has_tools, state, device.constraints.arrays(), vertices, tools,
                            input, launch);
    for (const Stage& stage : stages.plan.stages()) {
      if (stage.kind == PhaseKind::stiff_link) {
        kernels.begin_joints(stage, state, device.constraints.arrays(), input, launch);
      }
    }
    REQUIRE(difference(device.of_places(state.flights), data.step_scratch.flights).empty());

    for (int iteration = 0; iteration < 2; ++iteration) {
      const float relaxation =
          relaxation_of(options.over_relaxation, iteration, options.iterations);
      auto phase = data.plan.phases.begin();
      for (const Stage& stage : stages.plan.stages()) {
        INFO("sweep " << iteration << ", " << name_of(stage));
        if (stage.kind == PhaseKind::vertex) {
          REQUIRE(phase->kind == PhaseKind::vertex);
          solve_vertices(step, vertex_state(step, lengths, relaxation), phase->color);
          ++phase;
          kernels.solve_vertices(stage, {substep, relaxation, has_tools, false}, state, vertices,
                                 tools, input, launch);
        } else {
          REQUIRE(phase->kind == stage.kind);
          if (stage.kind == PhaseKind::stiff_link) {
            project_serially(step, *phase, lengths);
          } else {
            stages.project(stage, moving_vertices(step), data.carries, lengths);
          }
          ++phase;
          kernels.project(stage, {options.mode, data.sets.has_damping, false, false}, state,
                          device.constraints.arrays(), input, launch);
        }
        REQUIRE(difference(device.displacements(), data.step_scratch.displacements).empty());
        REQUIRE(difference(device.of_places(state.flights), data.step_scratch.flights).empty());
        REQUIRE(same_points(device, data));
      }
    }
    if (has_tools) {
      collect_tool_forces(step, lengths.inverse_dt_squared / 2);
      kernels.collect_forces(state, tools, input, substep, launch);
    }
  }
  CHECK((contacts > 0) == has_tools);
  settle_vertices(step, motion);
  kernels.advance(state, input, true, false, launch);
  REQUIRE(difference(device.particles(), data.particles).empty());
  REQUIRE(motion_difference(device, data).empty());
  PinnedBuffer<StepSums> sums;
  PinnedBuffer<Wrench> wrenches;
  kernels.report(state, device.constraints.arrays(), input,
                 {sums.reserve(1), wrenches.reserve(data.tools.size()), nullptr, nullptr}, launch);
  device.stream.wait();
  check_wrenches(wrenches.get(), data.tools);
}

}  // namespace pbdsurg::cuda
