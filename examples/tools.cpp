// SPDX-License-Identifier: Apache-2.0
// Presses a probe into a block of liver, then lifts it with a grasper, and reads the forces.
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::ToolPose;
using pbdsurg::World;

ToolPose at(float height) {
  return ToolPose(Eigen::Translation3f(0, height, 0));
}

// Moves a tool at a steady pace and returns the force of the tissue on it, N, upwards.
float travel(World& world, pbdsurg::ToolId tool, float from, float to) {
  constexpr int kSteps = 40;
  for (int step = 1; step <= kSteps; ++step) {
    world.move(tool, at(from + (to - from) * static_cast<float>(step) / kSteps));
    const pbdsurg::Frame frame = world.step(5e-3);  // s
    if (!frame.ok()) {
      throw pbdsurg::Error(frame.why());
    }
  }
  return world.force(tool).y();
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape box =
      pbdsurg::rounded_box_shape({0, -0.015, 0}, {0.03, 0.015, 0.03}, 2e-3);  // its top at y = 0
  World world;
  const pbdsurg::BodyId liver = world.add_body("liver", pbdsurg::tetrahedralize(box, options).mesh,
                                               pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.y() < -0.028; });

  // a tool pushes with capsules, in its own frame: here a ball of 8 mm above its tip
  const pbdsurg::ToolId probe = world.add_tool({{{0, 8e-3F, 0}, {0, 8e-3F, 0}, 8e-3F}}, at(5e-3F));
  for (const float depth : {2e-3F, 4e-3F, 6e-3F}) {  // m
    const float force = travel(world, probe, world.pose(probe).translation().y(), -depth);
    std::printf("pressed %.0f mm: %.2f N\n", 1e3F * depth, force);
  }
  travel(world, probe, -6e-3F, 0.02F);
  std::printf("away: %.2f N\n", world.force(probe).norm());

  // a tool without capsules only holds what it grasps
  const pbdsurg::ToolId grasper = world.add_tool({}, at(0));
  const std::size_t held = world.grasp_near(grasper, liver, 6e-3F).size();
  const float pull = travel(world, grasper, 0, 8e-3F);
  std::printf("lifted %zu vertices by 8 mm: %.2f N\n", held, pull);
  world.release(grasper);
  travel(world, grasper, 8e-3F, 0.02F);
  std::printf("released: %.2f N\n", world.force(grasper).norm());
} catch (const std::exception& error) {
  std::fprintf(stderr, "tools: %s\n", error.what());
  return 2;
}
