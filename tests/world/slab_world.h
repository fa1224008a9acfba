// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A world of two slabs with strands between them, for tests.

#include <algorithm>
#include <span>
#include <vector>

#include "pbdsurg/tissue/library.h"
#include "pbdsurg/world/world.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr double kEdge = 2e-3;                      // m
inline constexpr double kDt = 0.01;                        // s
inline const Eigen::Vector3f kTop{6e-3F, 6e-3F, 4.2e-3F};  // just above the lower slab
inline const TopologyEdit kBadEdit{.remove_tets = {-1}};

inline TetMesh slab(double height, std::array<Index, 3> cells = {6, 6, 2}) {
  const TetMesh box = make_box(cells, kEdge);
  std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
  for (Eigen::Vector3d& point : points) {
    point.z() += height;
  }
  return TetMesh(points, {box.tets().begin(), box.tets().end()});
}

inline ToolPose at(const Eigen::Vector3f& tip) {
  return ToolPose(Eigen::Translation3f(tip));
}

inline constexpr JoinOptions kJoin{
    .max_distance = 6e-3, .density = 2e6, .strands = {.segments = 3, .tear_stretch = 1.2}};

// Without weight. The lower slab is held and burnt from above, the upper one can be pulled off.
struct SlabWorld {
  explicit SlabWorld(const SolverOptions& options = {.damping = 20}) : world(options) {
    lower = world.add_body("lower", slab(0), tissues::fat());
    upper = world.add_body("upper", slab(7e-3), tissues::fat());
    world.fix(lower, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kEdge; });
    world.set_gravity({0, 0, 0});
    strand_count = world.join(lower, upper, kJoin);
    hook = world.add_tool({}, at(kTop));
    grasper = world.add_tool({}, at({6e-3F, 6e-3F, 11e-3F}));
    burner = world.add_cautery(hook, {lower, upper});
  }

  void burn(double power = 60) { world.energise(burner, cut_settings(power)); }

  // Across all strands, between the slabs.
  void cut_strands() {
    world.sweep({{{-1, -1, 5.5e-3F}, {1, -1, 5.5e-3F}}, {{-1, 1, 5.5e-3F}, {1, 1, 5.5e-3F}}});
  }

  [[nodiscard]] std::uint64_t hash() { return world.solver().state_hash(); }

  World world;
  BodyId lower, upper;
  ToolId hook, grasper;
  CauteryId burner;
  Index strand_count = 0;
};

inline Index count_events(World& world, StrandLoss cause) {
  return static_cast<Index>(
      std::ranges::count(world.strands().events(), cause, &StrandEvent::cause));
}

/// Whether they hold equal values.
template <class Value>
[[nodiscard]] bool same(std::span<const Value> a, std::span<const Value> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

// Parts tissue where x is that, between two heights.
inline CutSurface cut_at(float x, float low, float high) {
  return sweep_blade(std::array{BladeEdge{{x, -0.01F, high}, {x, 0.03F, high}},
                                BladeEdge{{x, -0.01F, low}, {x, 0.03F, low}}});
}

}  // namespace pbdsurg::testing
