// SPDX-License-Identifier: Apache-2.0
// Pulls at the edge of a liver with a grasper: it holds, slips, and tears.
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/tissue/tear_strength.h"
#include "pbdsurg/world/world.h"

namespace {

pbdsurg::ToolPose at(float x) {
  return pbdsurg::ToolPose(Eigen::Translation3f(x, 0, 0));
}

void step(pbdsurg::World& world) {
  const pbdsurg::Frame frame = world.step(5e-3);  // s
  if (!frame.ok()) {
    throw pbdsurg::Error(frame.why());
  }
}

// Moves a tool on, by up to so far, until it holds no more or begins to slip. Tells how that ends.
pbdsurg::GripReport pull(pbdsurg::World& world, pbdsurg::ToolId tool, float way) {
  const float from = world.pose(tool).translation().x();
  for (float gone = 0; gone < way; gone += 1e-4F) {  // m, 20 mm/s
    world.move(tool, at(from + gone));
    step(world);
    if (world.grip(tool).state != pbdsurg::GripState::holding) {
      break;
    }
  }
  return world.grip(tool);
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 6e-3;  // m: coarser than the jaws are wide
  const pbdsurg::ImplicitShape lobe =
      pbdsurg::rounded_box_shape({0, 0, 0}, {0.03, 0.006, 0.02}, 3e-3);  // 12 mm thick
  pbdsurg::World world;
  const pbdsurg::BodyId liver = world.add_body("liver", pbdsurg::tetrahedralize(lobe, options).mesh,
                                               pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.x() < -0.022; });

  // both jaws are along x, one above the other
  pbdsurg::Grip grip;
  grip.pad.normal = {0, 1, 0};
  grip.pad.half_length = 6e-3F;  // m
  grip.clamp_force = 2;          // N
  grip.friction = 0.8F;          // profiled
  grip.tear_strength = pbdsurg::tear_strength::kLiver;
  const pbdsurg::ToolId grasper = world.add_tool({}, at(0.022F));
  const std::size_t held = world.grasp_between(grasper, liver, 16e-3F, grip);
  pbdsurg::GripReport report = pull(world, grasper, 5e-3F);
  std::printf("%zu points hold %.2f N of %.2f N\n", held, report.pull.norm(), report.slip_limit);

  for (int i = 1; i <= 20; ++i) {  // the hand relaxes, in a tenth of a second
    world.set_clamp_force(grasper, 2 - 1.75F * static_cast<float>(i) / 20);
    step(world);
  }
  report = pull(world, grasper, 10e-3F);
  std::printf("slips at %.2f N of %.2f N\n", report.pull.norm(), report.slip_limit);

  world.set_clamp_force(grasper, 10);  // and clenches
  report = pull(world, grasper, 50e-3F);
  if (report.state != pbdsurg::GripState::torn) {
    throw pbdsurg::Error("nothing tore");
  }
  std::printf("tears at %.2f N: %zu tets go\n", report.pull.norm(), report.torn_tets.size());
  world.edit({.remove_tets = report.torn_tets});
  step(world);
} catch (const std::exception& error) {
  std::fprintf(stderr, "grasp: %s\n", error.what());
  return 2;
}
