// SPDX-License-Identifier: Apache-2.0
// Pulls at a gallbladder that hangs on its bed, and burns it with a hook from below, for 1.2 s.
#include "pbdsurg/world/world.h"

#include <algorithm>
#include <cstdio>
#include <exception>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/mesh/tetrahedralize.h"

namespace {

using pbdsurg::BodyId;
using pbdsurg::ToolPose;

pbdsurg::TetMesh mesh_of(const pbdsurg::ImplicitShape& shape) {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 6e-3;  // m
  return pbdsurg::tetrahedralize(shape, options).mesh;
}

constexpr float kHookRadius = 0.5e-3F;  // m

// Where the hook touches the skin from below.
Eigen::Vector3f below(const pbdsurg::Surface& skin) {
  return *std::ranges::min_element(skin.positions(), {}, [](const auto& x) { return x.z(); }) -
         kHookRadius * Eigen::Vector3f::UnitZ();
}

ToolPose at(const Eigen::Vector3f& tip) {
  return ToolPose(Eigen::Translation3f(tip));
}

}  // namespace

int main() try {
  // the wall is stiff: 2 %, the default, takes five times as long
  pbdsurg::World world({.accuracy = 0.2F});
  const pbdsurg::ImplicitShape shape = pbdsurg::gallbladder_outer();
  const BodyId liver =
      world.add_body("liver", mesh_of(pbdsurg::liver_bed(shape)), pbdsurg::tissues::liver());
  const BodyId sac =
      world.add_body("gallbladder", mesh_of(shape), pbdsurg::tissues::gallbladder_wall());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.z() > 0.05; });
  std::printf("%d strands\n", world.join(sac, liver, {.max_distance = 6e-3}));

  const pbdsurg::Surface& skin = world.surface(sac);
  const Eigen::Vector3f fundus(-0.01F, 0, 0);
  const pbdsurg::ToolId grasper = world.add_tool({}, at(fundus));
  const pbdsurg::ToolId hook =
      world.add_tool({{{0, 0, 0}, {0, 0, -0.1F}, kHookRadius}}, at(below(skin)));
  world.couple(hook, {.stiffness = 300});  // N/m, of a hand
  const pbdsurg::CauteryId burner = world.add_cautery(hook, {liver, sac});
  std::printf("the grasper holds %zu vertices\n", world.grasp_near(grasper, sac, 12e-3F).size());

  pbdsurg::Index tets = 0, strands = 0;
  for (int step = 0; step < 240; ++step) {
    world.move(grasper, at(fundus - Eigen::Vector3f(0, 0, 5e-5F * static_cast<float>(step))));
    world.move(hook, at(below(skin)));
    const bool pedal = step >= 40;
    world.energise(burner, pedal ? pbdsurg::cut_settings(60) : pbdsurg::off_settings());
    const pbdsurg::Frame frame = world.step(5e-3);
    if (!frame.ok()) {
      std::fprintf(stderr, "world: step %d: %s\n", step, frame.why().c_str());
      return 1;
    }
    tets += frame.removed_tets;
    strands += frame.parted_strands;
    if (step % 40 == 39) {
      std::printf(
          "%.1f s: grasper %.2f N, hook %.2f N; hottest skin %.0f C, %d tets burnt, %d strands "
          "gone\n",
          5e-3 * (step + 1), world.force(grasper).norm(), world.force(hook).norm(),
          std::ranges::max(skin.temperatures()), tets, strands);
    }
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "world: %s\n", error.what());
  return 2;
}
