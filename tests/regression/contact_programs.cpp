// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <vector>

#include "tests/regression/programs.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {
namespace {

using Eigen::Vector3d;

constexpr float kStep = 5e-3F;  // s
constexpr int kSteps = 60;
constexpr double kTableEdge = 5e-3, kUpperEdge = 4e-3, kGap = 0.4e-3;  // m
constexpr double kTop = 3 * kTableEdge + kGap + 2 * kUpperEdge;        // m
constexpr TissueContact kContact{0.5e-3F, 0.2F};

struct NamedMethod {
  const char* name;
  SolverOptions options;
};

const std::array kMethods{
    NamedMethod{"projection",
                {.method = SolverMethod::projection,
                 .substeps = 4,
                 .iterations = 4,
                 .composition = PlanComposition::separate}},
    NamedMethod{"vertex-block",
                {.method = SolverMethod::vertex_block, .composition = PlanComposition::separate}},
    NamedMethod{"vertex-block-bdf2",
                {.method = SolverMethod::vertex_block,
                 .integration = TimeIntegration::bdf2,
                 .composition = PlanComposition::separate}},
    NamedMethod{
        "explicit",
        {.method = SolverMethod::explicit_steps, .composition = PlanComposition::separate}}};

Eigen::Affine3d at(const Vector3d& x) {
  return Eigen::Affine3d(Eigen::Translation3d(x));
}

ToolPose pose_at(const Eigen::Vector3f& x) {
  return ToolPose(Eigen::Translation3f(x));
}

// A table that stands fast, a block that falls on it with other edges, and a thread across that.
Scene make_stack(bool is_explicit) {
  Material soft = tissue(3e3F), firm = tissue(50e3F);
  if (is_explicit) {
    soft.damping = firm.damping = 0;
  }
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  scene.fix_where(
      scene.add_body("table", placed_box({6, 6, 3}, kTableEdge, Eigen::Affine3d::Identity()), firm),
      [](const Vector3d& x) { return x.z() < 1e-9; });
  scene.add_body("block",
                 placed_box({5, 5, 2}, kUpperEdge, at({5.3e-3, 4.1e-3, 3 * kTableEdge + kGap})),
                 soft);
  constexpr int kParticles = 12;
  constexpr float kLink = 2.1e-3F;  // m
  std::vector<Vector3d> points;
  for (int i = 0; i < kParticles; ++i) {
    points.emplace_back(2e-3 + kLink * i, 13.3e-3, kTop + 0.7e-3);
  }
  const BodyId thread = scene.add_particles("thread", points, 1e-4);
  const Index first = scene.body(thread).first_vertex;
  for (Index i = 0; i + 1 < kParticles; ++i) {
    scene.add_link({first + i, first + i + 1, kLink, {.compliance = is_explicit ? 1e-2F : 0.0F}});
  }
  scene.fix_vertices(thread, std::array{0});
  return scene;
}

// Two shafts, one of them on a spring where there are any, press the block from above and slide on
// it.
class Shafts {
 public:
  explicit Shafts(Solver& solver) {
    const Capsule along{{-5e-3F, 0, 0}, {25e-3F, 0, 0}, 1e-3F};
    for (int i = 0; i < 2; ++i) {
      ids_[i] = solver.add_tool({&along, 1}, pose(i, 0), {ContactFeatures::all, 0.3F});
    }
    if (solver.options().method != SolverMethod::explicit_steps) {
      solver.couple_tool(ids_[1], {500});
    }
  }

  void move(Solver& solver, int step) const {
    for (int i = 0; i < 2; ++i) {
      solver.move_tool(ids_[i], pose(i, step));
    }
  }

 private:
  static ToolPose pose(int shaft, int step) {
    const float way = 4e-3F * static_cast<float>(step) / kSteps;
    return pose_at({5e-3F + way, 7e-3F + 12e-3F * static_cast<float>(shaft),
                    static_cast<float>(kTop) + 2e-3F - way});
  }

  std::array<ToolId, 2> ids_;
};

// Jaws around points of faces of the block.
ToolId add_jaws(Solver& solver) {
  constexpr Index kFirst = 40, kPoints = 5;
  constexpr std::array kWeights{0.5F, 0.25F, 0.25F};
  const std::vector<Eigen::Vector3f> x = solver.positions();
  std::vector<TissuePoint> points;
  Eigen::Vector3f middle = Eigen::Vector3f::Zero();
  for (Index i = 0; i < kPoints; ++i) {
    const Tet& tet = solver.tissue().tets()[solver.tissue().body(1).first_tet + kFirst + i];
    points.push_back({{tet[0], tet[1], tet[2]}, kWeights});
    for (int k = 0; k < 3; ++k) {
      middle += kWeights[k] / kPoints * x[tet[k]];
    }
  }
  const ToolId jaws = solver.add_tool({}, pose_at(middle));
  Grip grip;
  grip.pad = {.normal = {0, 0, 1}, .half_length = 10e-3F, .half_width = 10e-3F};
  grip.clamp_force = 0.02F;
  solver.grasp(jaws, points, grip);
  return jaws;
}

// Bodies meet, are cut where they do, and taken back; shafts and jaws come and go.
void run_stack(SolverOptions options, Index copies, const Executor& executor, Record& record) {
  const bool is_explicit = options.method == SolverMethod::explicit_steps;
  options.copies = copies;
  Driver driver(make_stack(is_explicit), options, executor);
  driver.follow_contacts();
  Solver& solver = driver.solver();
  solver.set_body_contact(0, 1, kContact);
  solver.set_body_contact(1, 2, kContact);
  const Shafts shafts(solver);
  ToolId jaws;
  for (int step = 1; step <= kSteps; ++step) {
    shafts.move(solver, step);
    switch (step) {
      case 20:
        if (!is_explicit) {
          jaws = add_jaws(solver);
        }
        break;
      case 25:  // corners of both bodies where they touch, and of the thread
        driver.edit({.remove_tets = {solver.tissue().body(0).first_tet + 400,
                                     solver.tissue().body(1).first_tet,
                                     solver.tissue().body(1).first_tet + 7},
                     .remove_links = {9}});
        break;
      case 30:
        driver.undo();
        break;
      case 35:
        driver.edit({.remove_tets = {solver.tissue().body(1).first_tet + 20}});
        solver.clear_body_contact(1, 2);
        break;
      case 50:
        driver.compact();
        if (jaws.is_valid()) {
          solver.release(jaws);
        }
        break;
      default:
        break;
    }
    if (jaws.is_valid()) {
      ToolPose pose = solver.tool_target(jaws);
      pose.translation().x() -= 0.1e-3F;
      solver.move_tool(jaws, pose);
    }
    driver.step(kStep);
    if (step % 15 == 0) {
      driver.look(record, step);
    }
  }
}

}  // namespace

std::vector<Program> contact_programs() {
  std::vector<Program> programs;
  for (const NamedMethod& named : kMethods) {
    for (const Index copies : {1, 2}) {
      programs.push_back({std::string(copies == 1 ? "contact-" : "contact-copies-") + named.name,
                          [&named, copies](const Executor& executor, Record& record) {
                            run_stack(named.options, copies, executor, record);
                          }});
    }
  }
  return programs;
}

}  // namespace pbdsurg::testing
