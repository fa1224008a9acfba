// SPDX-License-Identifier: Apache-2.0
// Closes the jaws of one tool on a lobe of liver, takes them away, and presses with a probe that a
// spring holds as a hand does.
#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

void step(pbdsurg::World& world) {
  const pbdsurg::Frame frame = world.step(5e-3);  // s
  if (!frame.ok()) {
    throw pbdsurg::Error(frame.why());
  }
}

pbdsurg::ToolPose at(float x, float y) {
  return pbdsurg::ToolPose(Eigen::Translation3f(x, y, 0));
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape lobe =
      pbdsurg::rounded_box_shape({0, 0, 0}, {0.02, 0.005, 0.02}, 3e-3);  // 10 mm thick
  pbdsurg::World world;
  const pbdsurg::BodyId liver = world.add_body("liver", pbdsurg::tetrahedralize(lobe, options).mesh,
                                               pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.x() < -0.012; });
  world.set_gravity({0, 0, 0});

  // two jaws along x, open by 14 mm, and a hinge 30 mm behind them
  const pbdsurg::ToolSurface surface{.friction = 0.1F};
  const pbdsurg::ToolJoint upper{{0.05F, 0, 0}, {0, 0, 1}, 0, 1},
      lower{{0.05F, 0, 0}, {0, 0, 1}, 1, 1};
  const pbdsurg::ToolId jaws = world.add_tool({{{0.005F, 9e-3F, 0}, {0.02F, 9e-3F, 0}, 2e-3F},
                                               {{0.005F, -9e-3F, 0}, {0.02F, -9e-3F, 0}, 2e-3F}},
                                              at(0, 0), surface, std::array{upper, lower});
  for (float angle = 0; angle < 0.1F; angle += 1e-3F) {  // rad, 0.2 a second
    world.set_joint(jaws, 0, angle);
    world.set_joint(jaws, 1, -angle);
    step(world);
  }
  float above = 0, below = 0;
  for (const pbdsurg::ToolContact& contact : world.solver().tool_contacts(jaws)) {
    (contact.normal.y() < 0 ? above : below) += contact.force.y();
  }
  std::printf("jaws: %.2f N above, %.2f N below\n", above, below);
  world.remove_tool(jaws);

  const pbdsurg::ToolId probe =
      world.add_tool({{{0, 0, 0}, {0, 0, 0}, 4e-3F}}, at(0, 9e-3F), surface);
  world.couple(probe, {.stiffness = 500});  // N/m
  for (int i = 1; i <= 200; ++i) {
    world.move(probe, at(0, 9e-3F - 4e-5F * static_cast<float>(std::min(i, 100))));
    step(world);
  }
  const float way =
      world.solver().tool_pose(probe).translation().y() - world.pose(probe).translation().y();
  std::printf("probe: %.2f N, %.2f mm of spring times 500 N/m are %.2f N\n", world.force(probe).y(),
              1e3F * way, 500 * way);
} catch (const std::exception& error) {
  std::fprintf(stderr, "jaws: %s\n", error.what());
  return 2;
}
