// SPDX-License-Identifier: Apache-2.0
// Hangs a peritoneum by one side, blows at it, rips it, and takes a hole out of it.
#include <cstdio>
#include <exception>
#include <vector>

#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::Index;

constexpr Index kCells = 16;      // squares of each side
constexpr double kEdge = 2.5e-3;  // m

Index vertex(Index i, Index j) {
  return i + (kCells + 1) * j;
}

// How far the middle of the lower side has come out of the plane, once the sheet rests.
void rest_and_print(pbdsurg::World& world, const char* what) {
  for (int step = 0; step < 200; ++step) {
    world.step(5e-3);  // s
  }
  const Eigen::Vector3f middle = world.solver().positions()[vertex(kCells / 2, 0)];
  std::printf("%s: %.1f mm out, %.1f mm down\n", what, 1e3 * middle.z(), -1e3 * middle.y());
}

}  // namespace

int main() try {
  std::vector<Eigen::Vector3d> positions;  // m
  std::vector<pbdsurg::Triangle> triangles;
  for (Index j = 0; j <= kCells; ++j) {
    for (Index i = 0; i <= kCells; ++i) {
      positions.emplace_back(i * kEdge, (j - kCells) * kEdge, 0);
    }
  }
  for (Index j = 0; j < kCells; ++j) {
    for (Index i = 0; i < kCells; ++i) {
      triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }

  pbdsurg::SolverOptions options;
  options.damping = 10;  // 1/s
  pbdsurg::World world(options);
  const float thickness = 0.3e-3F;  // m
  const pbdsurg::BodyId sheet =
      world.add_sheet("peritoneum", positions, triangles, thickness, pbdsurg::tissues::membrane());
  world.fix(sheet, [](const Eigen::Vector3d& x) { return x.y() > -0.5 * kEdge; });
  rest_and_print(world, "hanging");

  // a pressure of 3 Pa on one side: at each vertex as much as its share of the area
  const float area_of_mass = 1 / (pbdsurg::tissues::membrane().mechanics.density * thickness);
  world.set_forces(sheet, [&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
    return {0, 0, 3 * static_cast<float>(world.tissue().masses()[v]) * area_of_mass};
  });
  rest_and_print(world, "blown at");
  world.clear_forces();

  // up the middle: each vertex of the rip has a copy, which the triangles to its right go to
  const pbdsurg::Tissue& tissue = world.tissue();
  pbdsurg::TopologyEdit rip;
  for (Index j = 0; j < kCells / 2; ++j) {
    const Index from = vertex(kCells / 2, j);
    const Index copy = tissue.vertex_count() + static_cast<Index>(rip.new_vertices.size());
    rip.new_vertices.push_back({from, from, 0});
    for (const Index t : tissue.triangles_at(from)) {
      double center = 0;
      for (const Index v : tissue.triangles()[t]) {
        center += tissue.rest_positions()[v].x() / 3;
      }
      if (center > kCells / 2 * kEdge) {
        rip.triangle_moves.push_back({t, from, copy});
      }
    }
  }
  world.edit(rip);
  world.step(5e-3);
  std::printf("ripped: %zu hinges go\n", tissue.last_change().removed_hinges.size());
  rest_and_print(world, "hanging in two");

  const std::span<const Index> around = tissue.triangles_at(vertex(kCells / 4, kCells / 2));
  world.edit({.remove_triangles = {around.begin(), around.end()}});
  world.step(5e-3);
  const pbdsurg::Surface& skin = world.surface(sheet);
  Index sides = 0;
  for (const auto& [a, b, c] : skin.triangles()) {
    sides += a != b ? 1 : 0;
  }
  std::printf("%zu triangles go, %d are left, with both sides\n",
              tissue.last_change().removed_triangles.size(), sides);
} catch (const std::exception& error) {
  std::fprintf(stderr, "sheet: %s\n", error.what());
  return 2;
}
