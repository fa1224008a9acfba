// SPDX-License-Identifier: Apache-2.0
#include "lib/device/neighbor_lists.h"

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::cuda {
namespace {

Index color_of(const VertexBlocks& blocks, Index vertex) {
  const Index block = blocks.place_of(vertex).block;
  Index color = 0;
  while (block >= blocks.blocks(color).first + blocks.blocks(color).count) {
    ++color;
  }
  return color;
}

}  // namespace

// Would catch a vertex that does not wait for one that moves it, or waits for a sweep that does not
// come before its own.
TEST_CASE("neighbor lists: all that rows name, with what each has done before") {
  const TetMesh mesh = pbdsurg::testing::make_box({5, 4, 3}, 4e-3, 0.2);
  const auto vertex_count = static_cast<Index>(mesh.positions().size());
  std::vector<bool> moves(mesh.positions().size());
  for (Index v = 0; v < vertex_count; ++v) {
    moves[v] = v % 7 != 0;
  }
  std::vector<std::set<Index>> expected(mesh.positions().size());
  const auto join = [&](auto vertices) {
    for (const Index a : vertices) {
      for (const Index b : vertices) {
        if (a != b) {
          expected[a].insert(b);
        }
      }
    }
  };
  std::vector<VertexTet> tets;
  for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
    const float stiffness = t % 5 == 0 ? 0.0F : 1.0F;
    tets.push_back({.vertices = mesh.tets()[t], .stiffness = stiffness, .target = 1});
    if (stiffness > 0) {
      join(mesh.tets()[t]);
    }
  }
  const Tet fibres{9, 30, 55, 77};  // of a tetrahedron without anything else
  tets.push_back({.vertices = fibres, .fibre_shares = {1, 2, 3}, .fibre_stiffness = 1});
  join(fibres);
  const std::vector<VertexSpring> springs{{{1, vertex_count - 2}, 1, 1, 0}, {{2, 3}, 0, 0, 0}};
  join(springs[0].vertices);
  const VertexHinge hinge{.vertices = {4, 5, 20, 41}, .stiffness = 1};
  join(hinge.vertices);
  const std::vector<VertexTriangle> triangles{{.vertices = {6, 50, 71}, .stiffness = 1},
                                              {.vertices = {8, 52, 73}}};  // gone
  join(triangles[0].vertices);
  const VertexBlocks blocks(moves, tets, springs, {hinge}, {}, kUsualUnit, false, triangles);

  const NeighborLists lists(blocks);

  Index longest = 0;
  for (Index v = 0; v < vertex_count; ++v) {
    const auto [block, lane] = blocks.place_of(v);
    REQUIRE((block == kInvalidIndex) == !moves[v]);
    if (!moves[v]) {
      continue;
    }
    std::set<Index> found;
    for (const Neighbor neighbor : lists.of(block, lane)) {
      const Index other = place_at(neighbor & ~kNeighborFlags);
      const Neighbor flags = neighbor & kNeighborFlags;
      INFO("vertex " << v << ", neighbour " << other);
      if (other == v) {
        CHECK(flags == kStandsStill);
        continue;
      }
      CHECK(found.insert(other).second);
      if (!moves[other]) {
        CHECK(flags == kStandsStill);
      } else {
        CHECK(flags == (color_of(blocks, other) < color_of(blocks, v) ? kMovesEarlier : 0));
      }
    }
    CHECK(found == expected[v]);
    longest = std::max(longest, static_cast<Index>(expected[v].size()));
  }
  CHECK(lists.longest == longest);
}

TEST_CASE("neighbor lists: none without blocks") {
  const NeighborLists lists{VertexBlocks()};

  CHECK(lists.ranges.empty());
  CHECK(lists.longest == 0);
}

}  // namespace pbdsurg::cuda
