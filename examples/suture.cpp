// SPDX-License-Identifier: Apache-2.0
// Draws two strips of liver together with stitches, lets one of them go, and takes it along.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::Index;

constexpr float kGap = 4e-3F;       // m, between the strips at first
constexpr float kThread = 2e-4F;    // m/N, of a stitch
constexpr double kTimeStep = 5e-3;  // s

pbdsurg::BodyId add_strip(pbdsurg::World& world, const char* name, double x) {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const auto shape = pbdsurg::rounded_box_shape({x, 0, 0}, {0.02, 0.005, 0.01}, 1e-3);
  return world.add_body(name, pbdsurg::tetrahedralize(shape, options).mesh,
                        pbdsurg::tissues::liver());
}

// In mm, how long stitches are on average, and in N what the threads pull with together.
void print(pbdsurg::World& world, const char* what) {
  const std::vector<Eigen::Vector3f> x = world.solver().positions();
  float length = 0, pull = 0;
  for (const pbdsurg::Link& stitch : world.tissue().links()) {
    const float own = (x[stitch.first] - x[stitch.second]).norm();
    length += own / static_cast<float>(world.tissue().links().size());
    pull += (own - stitch.rest_length) / kThread;
  }
  const Eigen::Vector3f& end = x.back();
  std::printf("%s: %.1f mm apart, %.2f N, the end at %.0f, %.0f mm\n", what, 1e3 * length, pull,
              1e3 * end.x(), 1e3 * end.y());
}

void run(pbdsurg::World& world, double seconds) {
  for (double time = 0; time < seconds; time += kTimeStep) {
    world.step(kTimeStep);
  }
}

}  // namespace

int main() try {
  pbdsurg::SolverOptions solver;
  solver.damping = 20;  // 1/s
  pbdsurg::World world(solver);
  const auto left = add_strip(world, "left", -0.02 - kGap / 2);
  const auto right = add_strip(world, "right", 0.02 + kGap / 2);
  world.fix(left, [](const Eigen::Vector3d& x) { return x.x() < -0.04; });
  world.fix(right, [](const Eigen::Vector3d& x) { return x.x() > 0.04; });
  world.set_gravity({0, -9.81F, 0});

  // a stitch from each vertex of the one face to the nearest of the other
  const auto rest = world.tissue().rest_positions();
  const Index count = world.tissue().vertex_count();
  pbdsurg::TopologyEdit stitches;
  for (Index v = 0; v < count; ++v) {
    if (rest[v].x() > 0 || rest[v].x() < -kGap / 2 - 1e-3) {
      continue;
    }
    Index nearest = v;
    for (Index w = 0; w < count; ++w) {
      const bool is_closer =
          nearest == v || (rest[w] - rest[v]).norm() < (rest[nearest] - rest[v]).norm();
      nearest = rest[w].x() > 0 && is_closer ? w : nearest;
    }
    stitches.new_links.push_back(
        {v, nearest, static_cast<float>((rest[nearest] - rest[v]).norm()), {1, kThread}});
  }
  world.edit(stitches);
  run(world, 0.5);
  print(world, "stitched");

  for (int pull = 0; pull < 30; ++pull) {  // 0.1 mm of thread every 20 ms
    pbdsurg::TopologyEdit drawn;
    for (Index link = 0; link < static_cast<Index>(world.tissue().links().size()); ++link) {
      const float length = world.tissue().links()[link].rest_length;
      drawn.link_lengths.push_back({link, std::max(length - 1e-4F, 5e-4F)});
    }
    world.edit(drawn);
    run(world, 0.02);
  }
  run(world, 1);
  print(world, "drawn together");

  // a frame that takes tissue along is a tool without capsules
  std::vector<Index> held;
  for (Index v = 0; v < count; ++v) {
    if (world.tissue().is_fixed(v) && rest[v].x() > 0) {
      held.push_back(v);
    }
  }
  world.edit({.unfix_vertices = held});
  run(world, 1.5);
  print(world, "let go");

  const pbdsurg::ToolId frame = world.add_tool({});
  world.grasp(frame, held);
  pbdsurg::ToolPose pose = pbdsurg::ToolPose::Identity();
  for (int step = 0; step < 100; ++step) {
    pose.translation().y() += 2e-4F;
    world.move(frame, pose);
    world.step(kTimeStep);
  }
  run(world, 1);
  print(world, "lifted");
} catch (const std::exception& error) {
  std::fprintf(stderr, "suture: %s\n", error.what());
  return 2;
}
