// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/blocks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

// m, from zero outwards.
std::vector<double> graded_places(const GradedBlock& block, double end) {
  constexpr double kGrowth = 1.25;
  std::vector<double> places{0};
  for (double edge = block.edge; places.back() < end;) {
    places.push_back(places.back() + edge);
    edge *= places.back() < block.fine ? 1 : kGrowth;
  }
  return places;
}

}  // namespace

TetMesh make_graded_block(const GradedBlock& block) {
  const std::vector<double> down = graded_places(block, block.depth);
  const std::vector<double> out = graded_places(block, block.half_width);
  const auto sides = static_cast<Index>(out.size()) - 1,
             layers = static_cast<Index>(down.size()) - 1;
  const TetMesh cubes = testing::make_box({2 * sides, 2 * sides, layers}, 1);
  std::vector<Eigen::Vector3d> positions;
  const auto place_of = [&](double i) {
    const auto from_middle = std::lround(i) - sides;
    return from_middle < 0 ? -out[-from_middle] : out[from_middle];
  };
  for (const Eigen::Vector3d& x : cubes.positions()) {
    positions.emplace_back(place_of(x.x()), place_of(x.y()), -down[layers - std::lround(x.z())]);
  }
  return TetMesh(std::move(positions), {cubes.tets().begin(), cubes.tets().end()});
}

std::vector<Index> vertices_below(const Scene& scene, double z) {
  std::vector<Index> result;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].z() < z) {
      result.push_back(v);
    }
  }
  return result;
}

ToolPose at(const Eigen::Vector3f& place) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = place;
  return pose;
}

Eigen::Vector3d center_of(const Solver& solver) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& x : solver.positions()) {
    sum += x.cast<double>();
  }
  return sum / solver.vertex_count();
}

void settle(Solver& solver, double most) {
  constexpr float kStill = 2e-6F;  // m/s
  for (int i = 0; i * double{kCaseStep} < most; ++i) {
    solver.step(kCaseStep);
    if (i % 20 == 19) {
      const auto velocities = solver.velocities();
      const auto fastest = std::ranges::max_element(
          velocities, {}, [](const Eigen::Vector3f& v) { return v.squaredNorm(); });
      if (fastest->norm() < kStill) {
        return;
      }
    }
  }
}

void press(Solver& solver, ToolId tool, const Eigen::Vector3f& touch, double depth) {
  constexpr int kSteps = 50;
  for (int i = 1; i <= kSteps; ++i) {
    const auto sunk = static_cast<float>(depth * i / kSteps);
    solver.move_tool(tool, at(touch - Eigen::Vector3f(0, 0, sunk)));
    solver.step(kCaseStep);
  }
  settle(solver, 4);
}

double overlap_of(const Solver& solver, ToolId tool) {
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  double deepest = 0;
  for (const ToolContact& contact : solver.tool_contacts(tool)) {
    Eigen::Vector3f x = Eigen::Vector3f::Zero();
    for (int k = 0; k < 3 && contact.vertices[k] != kInvalidIndex; ++k) {
      x += contact.weights[k] * positions[contact.vertices[k]];
    }
    deepest = std::max(deepest, -double{contact.normal.dot(x - contact.point)});
  }
  return deepest;
}

}  // namespace pbdsurg::bench
