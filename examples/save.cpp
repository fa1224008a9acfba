// SPDX-License-Identifier: Apache-2.0
// Burns an organ, writes it to a file in the middle of the burn, and goes on from the file.
// Usage: save [FILE]
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world_file.h"

namespace {

constexpr double kDt = 5e-3;  // s

// From below, where the organ hangs lowest.
// @return  tetrahedra that went
pbdsurg::Index burn(pbdsurg::World& world, pbdsurg::BodyId organ, pbdsurg::ToolId hook) {
  const pbdsurg::Surface& skin = world.surface(organ);
  pbdsurg::Index tets = 0;
  for (int step = 0; step < 200; ++step) {
    const Eigen::Vector3f tip =
        *std::ranges::min_element(skin.positions(), {}, [](const auto& x) { return x.z(); });
    world.move(hook, pbdsurg::ToolPose(Eigen::Translation3f(tip)));
    tets += world.step(kDt).removed_tets;
  }
  return tets;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::filesystem::path file = argc > 1 ? argv[1] : "burn.world";
  pbdsurg::World world;
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 3e-3;  // m
  const pbdsurg::TetMesh mesh = pbdsurg::tetrahedralize(pbdsurg::gallbladder_outer(), options).mesh;
  const pbdsurg::BodyId liver = world.add_body("liver", mesh, pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.z() > 0; });
  const pbdsurg::ToolId hook = world.add_tool({});
  world.energise(world.add_cautery(hook, {liver}), pbdsurg::cut_settings(60));

  world.record();  // before the first edit: the file has the scene
  std::printf("%d tets burnt\n", burn(world, liver, hook));
  world.record();  // again, so that the burn goes on to the bit
  pbdsurg::write_world(file, world.save());
  std::printf("%ju bytes\n", std::filesystem::file_size(file));

  pbdsurg::World other = pbdsurg::read_world(file);
  const pbdsurg::Index tets = burn(world, liver, hook), others = burn(other, liver, hook);
  std::printf("then %d tets, and %d in the world of the file\n", tets, others);
  const bool is_same = world.solver().state_hash() == other.solver().state_hash();
  std::printf("%s\n", is_same ? "the same bits" : "other bits");
  return is_same ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "save: %s\n", error.what());
  return 1;
}
