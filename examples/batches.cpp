// SPDX-License-Identifier: Apache-2.0
// Presses eight copies of a scene to eight depths at once, starts one of them anew, then makes it
// of other tissue.
#include <cstdint>
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::ReplicaId;
using pbdsurg::ToolPose;

constexpr pbdsurg::Index kReplicas = 8;
constexpr int kSteps = 40;

ToolPose at(float height) {
  return ToolPose(Eigen::Translation3f(0, height, 0));
}

// How far the probe of a replica has come by a step, m.
float height(pbdsurg::Index replica, int step) {
  return -1e-3F * static_cast<float>(replica * step) / kSteps;
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 6e-3;  // m
  const pbdsurg::ImplicitShape box =
      pbdsurg::rounded_box_shape({0, -0.015, 0}, {0.03, 0.015, 0.03}, 2e-3);
  pbdsurg::SolverOptions solver;
  solver.copies = kReplicas;
  pbdsurg::World world(solver);
  const pbdsurg::BodyId liver = world.add_body("liver", pbdsurg::tetrahedralize(box, options).mesh,
                                               pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.y() < -0.028; });
  world.set_gravity({0, 0, 0});
  const pbdsurg::ToolId probe = world.add_tool({{{0, 8e-3F, 0}, {0, 8e-3F, 0}, 8e-3F}}, at(0));
  const pbdsurg::Snapshot start = world.replica(ReplicaId(0)).snapshot();

  for (int step = 1; step <= kSteps; ++step) {
    for (pbdsurg::Index each = 0; each < kReplicas; ++each) {
      world.replica(ReplicaId(each)).move(probe, at(height(each, step)));
    }
    world.step(5e-3);  // s, all of them
  }
  for (pbdsurg::Index each = 0; each < kReplicas; ++each) {
    std::printf("%d mm: %.3f N\n", each, world.replica(ReplicaId(each)).force(probe).y());
  }

  // an episode ends: replica 7 starts anew and does what replica 3 did, while others rest
  const std::uint64_t third = world.replica(ReplicaId(3)).state_hash();
  world.replica(ReplicaId(7)).restore(start);
  for (int step = 1; step <= kSteps; ++step) {
    world.replica(ReplicaId(7)).move(probe, at(height(3, step)));
    world.step(5e-3);
  }
  const bool is_same = world.replica(ReplicaId(7)).state_hash() == third;
  std::printf("replica 7 now has %s\n", is_same ? "the bits that 3 had" : "other bits than 3 had");

  // another patient: half as stiff
  const float before = world.replica(ReplicaId(3)).force(probe).y();
  world.replica(ReplicaId(7)).set_factors({.stiffness = 0.5F});
  for (int step = 0; step < 3 * kSteps; ++step) {
    world.step(5e-3);
  }
  const float share = world.replica(ReplicaId(7)).force(probe).y() / before;
  std::printf("half as stiff, it takes %.2f of the force\n", double{share});
  return is_same ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "batches: %s\n", error.what());
  return 2;
}
