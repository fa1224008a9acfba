// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_tiles.h"

#include <algorithm>
#include <set>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::cuda {
namespace {

VertexBlocks make_blocks() {
  const TetMesh mesh = pbdsurg::testing::make_box({5, 4, 3}, 4e-3, 0.2);
  std::vector<bool> moves(mesh.positions().size());
  for (std::size_t v = 0; v < moves.size(); ++v) {
    moves[v] = v % 7 != 0;
  }
  std::vector<VertexTet> tets;
  for (const Tet& tet : mesh.tets()) {
    tets.push_back({.vertices = tet, .weights = {1, 1, 1, 1, 1, 1}, .stiffness = 1, .target = 1});
  }
  tets[5].fibre_stiffness = 1;
  const VertexTriangle triangle{.vertices = {2, 44, 61}, .stiffness = 1, .target = 1};
  return VertexBlocks(moves, tets, {{{1, 9}, 1, 1, 0}}, {{{4, 5, 20, 41}, 1, 0, 0}}, {}, kUsualUnit,
                      false, {triangle});
}

}  // namespace

// Would catch a thread that reads another's vertex, a neighbour that no thread waits for or that
// two do, and a vertex that idle threads move.
TEST_CASE("vertex tiles: threads of a vertex share its neighbours") {
  const auto parts = static_cast<Index>(GENERATE(4, 8, 16));
  const VertexBlocks blocks = make_blocks();
  const NeighborLists lists(blocks);

  const VertexTiles tiles(blocks, lists, parts);

  const Index count = tiles_of_block(parts);
  REQUIRE(count * kTileThreads == kBlockLanes * parts);
  REQUIRE(tiles.blocks.size() == static_cast<std::size_t>(blocks.block_count()));
  Index most = 0;
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = blocks.rows().blocks[b];
    const TileBlock& tile = tiles.blocks[b];
    most = std::max<Index>(most, tile.counts.neighbors);
    for (Index lane = 0; lane < kBlockLanes; ++lane) {
      std::vector<Neighbor> found;
      for (Index part = 0; part < parts; ++part) {
        const auto entry = [&](Index row) {
          const auto first = static_cast<std::size_t>(tile.neighbors + row * count) * kTileThreads;
          return tiles.neighbors[first + static_cast<std::size_t>(lane * parts + part)];
        };
        const bool is_idle = lane >= block.lane_count;
        CHECK((entry(0) & ~kNeighborFlags) == block.corners[lane]);
        CHECK(((entry(0) & kIsIdle) != 0) == is_idle);
        for (Index k = 0; k < tile.counts.neighbors; ++k) {
          const Neighbor neighbor = entry(1 + k);
          if ((neighbor & ~kNeighborFlags) == block.corners[lane]) {
            CHECK((neighbor & kStandsStill) != 0);
          } else {
            found.push_back(neighbor);
          }
          REQUIRE((!is_idle || (neighbor & ~kNeighborFlags) == block.corners[lane]));
        }
      }
      if (lane < block.lane_count) {
        std::vector<Neighbor> expected;
        for (const Neighbor neighbor : lists.of(b, lane)) {
          if ((neighbor & ~kNeighborFlags) != block.corners[lane]) {
            expected.push_back(neighbor);
          }
        }
        std::ranges::sort(found);
        std::ranges::sort(expected);
        CHECK(found == expected);
      }
    }
  }
  CHECK(tiles.most_neighbors == most);
}

// Would catch a kernel that leaves out rows beyond those it always adds.
TEST_CASE("vertex tiles: blocks with rows beyond the usual say so") {
  const auto parts = static_cast<Index>(GENERATE(4, 8, 16));
  const VertexBlocks blocks = make_blocks();

  const VertexTiles tiles(blocks, NeighborLists(blocks), parts);

  const TileCounts usual = usual_counts(parts);
  for (Index b = 0; b < blocks.block_count(); ++b) {
    const VertexBlock& block = blocks.rows().blocks[b];
    const TileCounts& counts = tiles.blocks[b].counts;
    CHECK(counts.pulls * parts >= block.pulls.count);
    CHECK(counts.springs * parts >= block.springs.count);
    CHECK(counts.volumes * parts >= block.volumes.count);
    CHECK(counts.others == block.hinges.count + block.triangles.count + block.fibres.count);
    CHECK(counts.volumes >= usual.volumes);
    CHECK((counts.more != 0) == (counts.neighbors > usual.neighbors || counts.pulls > usual.pulls ||
                                 counts.volumes > usual.volumes || block.springs.count > 0 ||
                                 block.hinges.count > 0 || block.triangles.count > 0 ||
                                 block.fibres.count > 0));
  }
}

}  // namespace pbdsurg::cuda
