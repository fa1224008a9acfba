// SPDX-License-Identifier: Apache-2.0
// Rows and tiles of the vertex-block method follow edits that bring vertices: what is here needs no
// device.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/device/neighbor_lists.h"
#include "lib/device/stage_plan.h"
#include "lib/device/vertex_changes.h"
#include "lib/device/vertex_counts.h"
#include "lib/device/vertex_tiles.h"
#include "lib/device/word_batches.h"
#include "lib/solver/solver_options.h"
#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/edit_maker.h"
#include "tests/support/edit_scenes.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::Choices;
using pbdsurg::testing::EditMaker;
using pbdsurg::testing::inspect;

using Words = std::vector<std::uint32_t>;

constexpr std::uint32_t kNoLane = static_cast<std::uint32_t>(kInvalidIndex);

template <class Element>
Words words_of(std::span<const Element> elements) {
  Words words(elements.size_bytes() / sizeof(std::uint32_t));
  if (!elements.empty())  // memcpy takes no null pointer, not even for no bytes
    std::memcpy(words.data(), elements.data(), elements.size_bytes());
  return words;
}

/// What a device has of vertices, as words: made of a solver, or kept up word by word.
class DeviceRows {
 public:
  DeviceRows(const SolverData& data, Index parts) : counts_(data) {
    const VertexBlocks& blocks = data.vertex_blocks;
    const VertexBlocks::Arrays host = blocks.arrays();
    array(DeviceArray::vertex_blocks) = words_of(host.blocks);
    for (std::size_t b = 0; b < host.blocks.size(); ++b) {  // whose other bytes are any
      constexpr std::size_t kIsDamped = offsetof(VertexBlock, is_damped);
      array(DeviceArray::vertex_blocks)[(b * sizeof(VertexBlock) + kIsDamped) / 4] =
          (host.blocks[b].is_damped ? 1U : 0U) | (host.blocks[b].has_angles ? 0x100U : 0U);
    }
    array(DeviceArray::pull_rows) = words_of(host.pulls);
    array(DeviceArray::spring_rows) = words_of(host.springs);
    array(DeviceArray::volume_rows) = words_of(host.volumes);
    array(DeviceArray::hinge_rows) = words_of(host.hinges);
    array(DeviceArray::damped_spring_rows) = words_of(host.damped_springs);
    array(DeviceArray::damped_volume_rows) = words_of(host.damped_volumes);
    array(DeviceArray::triangle_rows) = words_of(host.triangles);
    array(DeviceArray::fibre_rows) = words_of(host.fibres);
    array(DeviceArray::damped_triangle_rows) = words_of(host.damped_triangles);
    array(DeviceArray::stiffness_shares) = words_of(data.stable_substep.shares());
    for (std::size_t v = 0; v < counts_.places; ++v) {
      array(DeviceArray::lane_of_place)
          .push_back(static_cast<std::uint32_t>(lane_of(blocks, static_cast<Index>(v))));
    }
    tiles_ = VertexTiles(blocks, NeighborLists(blocks), parts);
    array(DeviceArray::tile_blocks) = words_of(std::span<const TileBlock>(tiles_.blocks));
    array(DeviceArray::tile_neighbors) = words_of(std::span<const Neighbor>(tiles_.neighbors));
    tiles_.neighbors.clear();
    for (Index b = 0; b < blocks.block_count(); ++b) {
      pack(b);
    }
  }

  /// As a backend does between steps.
  /// @return  whether it can
  bool follow(const SolverData& data, WordBatches& batches) {
    std::vector<WordChange>& words = batches.last();
    follow_rows(data, data.changes, words);
    counts_.include(VertexCounts(data));
    return tiles_.follow(data.vertex_blocks, data.changes, words);
  }

  /// As it does before a step.
  void write(WordBatches& batches) {
    make_room();
    batches.begin();
    std::size_t first = 0;
    for (const std::size_t end : batches.ends()) {
      std::map<std::pair<DeviceArray, std::uint32_t>, std::uint32_t> batch;
      for (; first < end; ++first) {
        const WordChange& change = batches.words()[first];
        Words& words = array(change.array);
        REQUIRE(change.word < words.size());
        words[change.word] = change.value;
        const auto [known, is_new] =
            batch.emplace(std::pair(change.array, change.word), change.value);
        REQUIRE((is_new || known->second == change.value));  // they are written in no order
      }
    }
    batches.clear();
    for (const Index block : tiles_.take_unpacked()) {
      pack(block);
    }
  }

  /// What is wrong, if anything: of all that kernels read.
  [[nodiscard]] std::string difference(const DeviceRows& fresh, const SolverData& data) const {
    const VertexBlocks& blocks = data.vertex_blocks;
    for (Index b = 0; b < blocks.block_count(); ++b) {
      const std::string in_block = " of block " + std::to_string(b);
      const auto same_words = [&](DeviceArray which, std::size_t first, std::size_t count) {
        return std::ranges::equal(std::span(array(which)).subspan(first, count),
                                  std::span(fresh.array(which)).subspan(first, count));
      };
      constexpr std::size_t kBlock = sizeof(VertexBlock) / 4,
                            kRead = offsetof(VertexBlock, strips) / 4;
      if (!same_words(DeviceArray::vertex_blocks, static_cast<std::size_t>(b) * kBlock, kRead)) {
        return "the frame" + in_block;
      }
      const VertexBlock& block = blocks.arrays().blocks[b];
      const VertexBlocks::BlockRoom room = blocks.room_of(b);
      const auto same_rows = [&](DeviceArray which, std::size_t row_bytes, RowRange range) {
        bool are_same = true;
        constexpr auto kLanes = static_cast<std::size_t>(kBlockLanes);
        const std::size_t row_words = row_bytes / 4;
        for (Index i = range.first; i < range.first + range.count; ++i) {
          for (std::size_t kind = 0; kind < row_words; kind += kLanes) {
            are_same &= same_words(which, static_cast<std::size_t>(i) * row_words + kind,
                                   static_cast<std::size_t>(block.lane_count));
          }
        }
        return are_same;
      };
      if (!same_rows(DeviceArray::pull_rows, sizeof(PullRow), room.pulls) ||
          !same_rows(DeviceArray::spring_rows, sizeof(SpringRow), room.springs) ||
          !same_rows(DeviceArray::volume_rows, sizeof(VolumeRow), room.volumes) ||
          !same_rows(DeviceArray::hinge_rows, sizeof(HingeRow), room.hinges) ||
          !same_rows(DeviceArray::triangle_rows, sizeof(TriangleRow), room.triangles) ||
          !same_rows(DeviceArray::fibre_rows, sizeof(FibreRow), room.fibres)) {
        return "rows" + in_block;
      }
      if (blocks.has_damping() &&
          (!same_rows(DeviceArray::damped_spring_rows, sizeof(DampedRow), room.springs) ||
           !same_rows(DeviceArray::damped_volume_rows, sizeof(DampedRow), room.volumes) ||
           !same_rows(DeviceArray::damped_triangle_rows, sizeof(DampedRow), room.triangles))) {
        return "damped rows" + in_block;
      }
      if (is_explicit(data.options) &&
          !same_words(DeviceArray::stiffness_shares,
                      static_cast<std::size_t>(b) * static_cast<std::size_t>(kBlockLanes),
                      static_cast<std::size_t>(kBlockLanes))) {
        return "shares" + in_block;
      }
      const TileBlock here = tile_block(b), there = fresh.tile_block(b);
      if (std::memcmp(&here.counts, &there.counts, sizeof here.counts) != 0) {
        return "counts of tiles" + in_block;
      }
      if (neighbors_of(b) != fresh.neighbors_of(b)) {
        return "neighbours" + in_block;
      }
      const auto packed = packed_.find(here.pulls);
      if (packed == packed_.end() || packed->second != fresh.content_of(b)) {
        return "records" + in_block;
      }
    }
    const std::size_t known = fresh.array(DeviceArray::lane_of_place).size();
    if (!std::ranges::equal(std::span(array(DeviceArray::lane_of_place)).first(known),
                            fresh.array(DeviceArray::lane_of_place))) {
      return "lanes of places";
    }
    return places_of_tiles(blocks.block_count());
  }

 private:
  [[nodiscard]] Words& array(DeviceArray which) { return arrays_[static_cast<std::size_t>(which)]; }
  [[nodiscard]] const Words& array(DeviceArray which) const {
    return arrays_[static_cast<std::size_t>(which)];
  }

  // What is new there is nothing.
  void make_room() {
    const auto fit = [&](DeviceArray which, std::size_t count, std::size_t element_bytes,
                         std::uint32_t value = 0) {
      Words& words = array(which);
      words.resize(std::max(words.size(), count * element_bytes / sizeof value), value);
    };
    const bool is_damped = !array(DeviceArray::damped_spring_rows).empty() ||
                           !array(DeviceArray::damped_volume_rows).empty() ||
                           !array(DeviceArray::damped_triangle_rows).empty();
    fit(DeviceArray::vertex_blocks, counts_.blocks, sizeof(VertexBlock));
    fit(DeviceArray::pull_rows, counts_.pulls, sizeof(PullRow));
    fit(DeviceArray::spring_rows, counts_.springs, sizeof(SpringRow));
    fit(DeviceArray::volume_rows, counts_.volumes, sizeof(VolumeRow));
    fit(DeviceArray::hinge_rows, counts_.hinges, sizeof(HingeRow));
    fit(DeviceArray::triangle_rows, counts_.triangles, sizeof(TriangleRow));
    fit(DeviceArray::fibre_rows, counts_.fibres, sizeof(FibreRow));
    if (is_damped) {
      fit(DeviceArray::damped_spring_rows, counts_.springs, sizeof(DampedRow));
      fit(DeviceArray::damped_volume_rows, counts_.volumes, sizeof(DampedRow));
      fit(DeviceArray::damped_triangle_rows, counts_.triangles, sizeof(DampedRow));
    }
    fit(DeviceArray::lane_of_place, counts_.places, sizeof(Index), kNoLane);
    fit(DeviceArray::stiffness_shares, counts_.blocks, kBlockLanes * sizeof(float));
    fit(DeviceArray::tile_blocks, static_cast<std::size_t>(tiles_.most_blocks), sizeof(TileBlock));
    fit(DeviceArray::tile_neighbors, static_cast<std::size_t>(tiles_.neighbor_rows),
        kTileThreads * sizeof(Neighbor));
  }

  template <class Element>
  [[nodiscard]] Element element(DeviceArray which, Index index) const {
    Element found;
    constexpr std::size_t kWords = sizeof(Element) / sizeof(std::uint32_t);
    const std::size_t first = static_cast<std::size_t>(index) * kWords;
    REQUIRE(first + kWords <= array(which).size());
    std::memcpy(static_cast<void*>(&found), array(which).data() + first, sizeof found);
    return found;
  }
  [[nodiscard]] TileBlock tile_block(Index b) const {
    return element<TileBlock>(DeviceArray::tile_blocks, b);
  }

  // Row by row of the threads of a block.
  [[nodiscard]] Words neighbors_of(Index b) const {
    const TileBlock tile = tile_block(b);
    const auto first = static_cast<std::size_t>(tile.neighbors) * kTileThreads;
    const auto count = static_cast<std::size_t>((1 + tile.counts.neighbors) *
                                                tiles_of_block(tiles_.parts) * kTileThreads);
    const Words& all = array(DeviceArray::tile_neighbors);
    REQUIRE(first + count <= all.size());
    return {all.begin() + first, all.begin() + first + count};
  }

  // All that packing makes records of.
  [[nodiscard]] Words content_of(Index b) const {
    const auto block = element<VertexBlock>(DeviceArray::vertex_blocks, b);
    Words content = neighbors_of(b);
    const auto add = [&]<class Row>(DeviceArray which, RowRange range, const Row&) {
      for (Index i = range.first; i < range.first + range.count; ++i) {
        const Row row = element<Row>(which, i);
        const Words words = words_of(std::span(&row, 1));
        for (std::size_t w = 0; w < words.size(); ++w) {
          if (w % kBlockLanes < static_cast<std::size_t>(block.lane_count)) {
            content.push_back(words[w]);
          }
        }
      }
    };
    add(DeviceArray::pull_rows, block.pulls, PullRow{});
    add(DeviceArray::spring_rows, block.springs, SpringRow{});
    add(DeviceArray::volume_rows, block.volumes, VolumeRow{});
    return content;
  }

  void pack(Index b) { packed_[tile_block(b).pulls] = content_of(b); }

  // No two blocks have the same record, and none lies beyond what there is.
  [[nodiscard]] std::string places_of_tiles(Index block_count) const {
    std::array<std::set<Index>, 4> taken;
    const Index tiles = tiles_of_block(tiles_.parts);
    for (Index b = 0; b < block_count; ++b) {
      const TileBlock tile = tile_block(b);
      const auto take = [&](std::size_t which, Index first, Index count, Index end) {
        bool is_free = first >= 0 && first + count * tiles <= end;
        for (Index row = first; row < first + count * tiles; ++row) {
          is_free &= taken[which].insert(row).second;
        }
        return is_free;
      };
      if (!take(0, tile.neighbors, 1 + tile.counts.neighbors, tiles_.neighbor_rows) ||
          !take(1, tile.pulls, tile.counts.pulls, tiles_.pull_rows) ||
          !take(2, tile.springs, tile.counts.springs, tiles_.spring_rows) ||
          !take(3, tile.volumes, tile.counts.volumes, tiles_.volume_rows)) {
        return "places of tiles of block " + std::to_string(b);
      }
    }
    return "";
  }

  VertexCounts counts_;
  std::array<Words, kDeviceArrayCount> arrays_;
  VertexTiles tiles_;
  std::map<Index, Words> packed_;  // by where the pulls of a block lie
};

/// Follows a solver, made anew where it says so.
class RowsFollower {
 public:
  RowsFollower(Solver& solver, Index parts)
      : data_(inspect(solver)), parts_(parts), rows_(data_, parts) {
    data_.changes.clear();
  }

  /// After an edit or an undo.
  void follow() {
    const bool grown = data_.changes.grown;
    batches_.begin();
    if (is_followed_ && !data_.changes.rows_anew && rows_.follow(data_, batches_)) {
      followed_growth += grown ? 1 : 0;
    } else {
      is_followed_ = false;
    }
    data_.changes.clear();
  }

  [[nodiscard]] std::string difference() {
    if (!is_followed_) {
      batches_.clear();
      rows_ = DeviceRows(data_, parts_);
      is_followed_ = true;
      ++made_anew;
    }
    rows_.write(batches_);
    return rows_.difference(DeviceRows(data_, parts_), data_);
  }

  [[nodiscard]] std::size_t word_count() { return batches_.last().size(); }

  int followed_growth = 0;
  int made_anew = 0;

 private:
  SolverData& data_;
  Index parts_;
  DeviceRows rows_;
  WordBatches batches_;
  bool is_followed_ = true;
};

TopologyEdit make_rows_edit(const Solver& solver, Choices& choices) {
  const Index what = choices.below(4);
  EditMaker maker(solver, choices,
                  what < 2 ? pbdsurg::testing::make_cut(solver, {}, choices).edit : TopologyEdit{});
  for (Index more = choices.below(3); more > 0; --more) {
    maker.add();
  }
  if (choices.below(3) == 0) {
    maker.add_links();
  }
  maker.fix_some();
  return maker.edit();
}

}  // namespace

// Would catch what an edit or its undo changes and nobody writes: of rows, their places and lanes,
// neighbours and who of them moves earlier, and records that nobody packs again.
TEST_CASE("cuda vertex growth: what follows any edits and their undo is as if made anew",
          "[equivalence]") {
  constexpr std::uint64_t kTrials = 160;
  int followed_growth = 0;
  int made_anew = 0;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const std::vector<std::uint8_t> bytes = pbdsurg::testing::random_bytes(seed, 400);
    Choices choices(bytes);
    const auto& scene = choices.one_of(pbdsurg::testing::edit_scenes());
    SolverOptions options = pbdsurg::testing::small_steps(
        {.method = SolverMethod::vertex_block, .executor = pbdsurg::testing::fake_device()});
    const auto parts = static_cast<Index>(choices.one_of(std::array{4, 8, 16}));
    INFO("seed " << seed << ", " << scene.name << ", " << parts << " parts");
    Solver solver(scene.scene, options);
    RowsFollower follower(solver, parts);
    while (!choices.is_spent()) {
      const TopologyEdit edit = make_rows_edit(solver, choices);
      const TissueChange result = solver.tissue().apply(edit);
      follower.follow();
      if (choices.below(3) > 0) {
        REQUIRE(follower.difference() == "");
      }
      if (choices.below(3) == 0) {
        solver.tissue().undo();
        follower.follow();
        if (choices.below(2) == 0) {
          REQUIRE(follower.difference() == "");
        }
      }
    }
    REQUIRE(follower.difference() == "");
    followed_growth += follower.followed_growth;
    made_anew += follower.made_anew;
  }
  CHECK(followed_growth > 400);
  CHECK(made_anew > 20);
}

namespace {

Solver make_block(std::array<Index, 3> cells, SolverMethod method, float damping) {
  const TetMesh mesh = pbdsurg::testing::make_box(cells, 4e-3, 0.1);
  Material material{.model = ElasticModel::neo_hookean, .damping = damping};
  Scene scene;
  scene.add_body("block", mesh, material);
  SolverOptions options{.method = method, .executor = pbdsurg::testing::fake_device()};
  if (method == SolverMethod::vertex_block) {
    options.substeps = 2;
  }
  return Solver(scene, options);
}

}  // namespace

// Would catch shares of explicit steps that stay where their vertices were, damping that one row
// has not, and growth that lays all out anew each time.
TEST_CASE("cuda vertex growth: a run of cuts is followed without laying anything out anew",
          "[equivalence]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const float damping = GENERATE(0.0F, 1e-3F);
  if (method == SolverMethod::explicit_steps && damping > 0) {
    return;  // has none
  }
  Solver solver = make_block({8, 6, 3}, method, damping);
  RowsFollower follower(solver, 16);
  for (std::uint64_t round = 0; round < 90; ++round) {
    INFO("round " << round);
    const TissueChange result = solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
    follower.follow();
    REQUIRE(follower.difference() == "");
    if (round % 3 == 1) {
      solver.tissue().undo();
      follower.follow();
      REQUIRE(follower.difference() == "");
    }
  }
  CHECK(follower.followed_growth > 100);
  CHECK(follower.made_anew == 0);
}

namespace {

// Triangles between any three vertices: few of their edges have hinges, which join vertices, too.
pbdsurg::testing::SheetMesh make_tangle() {
  constexpr Index kVertices = 80, kTriangles = 160;
  constexpr std::uint64_t kSeed = 3;
  pbdsurg::testing::SheetMesh mesh;
  for (Index v = 0; v < kVertices; ++v) {
    mesh.positions.emplace_back(random_unit(kSeed, v, 0), random_unit(kSeed, v, 1),
                                random_unit(kSeed, v, 2));
    mesh.positions.back() *= 0.03;
  }
  for (Index t = 0; t < kTriangles; ++t) {  // each vertex has some, and none is there twice
    const Index step = 1 + t / kVertices;
    mesh.triangles.push_back(
        {t % kVertices, (t + 7 * step) % kVertices, (t + 31 * step) % kVertices});
  }
  return mesh;
}

}  // namespace

// Would catch triangles that a rip moves and no row, tile or colour follows, and their neighbours.
TEST_CASE(
    "cuda vertex growth: a run of rips in a sheet is followed without laying anything out anew",
    "[equivalence]") {
  const float damping = GENERATE(0.0F, 1e-3F);
  const bool is_tangled = GENERATE(false, true);
  const auto mesh = is_tangled ? make_tangle() : pbdsurg::testing::make_sheet({14, 12}, 4e-3, 0.2);
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles, {.damping = damping});
  Solver solver(scene, {.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .executor = pbdsurg::testing::fake_device()});
  RowsFollower follower(solver, 16);
  for (Index round = 0; round < 60; ++round) {
    INFO("round " << round);
    const Index vertex = (7 + 31 * round) % static_cast<Index>(mesh.positions.size());
    TopologyEdit edit = pbdsurg::testing::rip_vertex(solver, vertex);
    const Index t = 5 * round % static_cast<Index>(mesh.triangles.size());
    if (solver.tissue().is_triangle_alive(t) && round % 4 == 0) {
      edit = {.remove_triangles = {t}};
    }
    // a link may leave one of its ends without a colour
    const Index other = (vertex + 3 + round) % static_cast<Index>(mesh.positions.size());
    if (solver.tissue().has_tissue(vertex) && solver.tissue().has_tissue(other) && round % 4 > 0) {
      edit.new_links.push_back({vertex, other, 0.01F, {0.5F, 2e-2F}});
    }
    const TissueChange result = solver.tissue().apply(edit);
    follower.follow();
    REQUIRE(follower.difference() == "");
    if (round % 3 == 1) {
      solver.tissue().undo();
      follower.follow();
      REQUIRE(follower.difference() == "");
    }
  }
  CHECK(follower.followed_growth > 30);
  CHECK(follower.made_anew == 0);
}

// Would catch anything that is written, or laid out, for all of a body.
TEST_CASE("cuda vertex growth: what is written for a cut does not grow with the body", "[unit]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const auto count_words = [&](std::array<Index, 3> cells) {
    Solver solver = make_block(cells, method, 0);
    SolverData& data = inspect(solver);
    RowsFollower follower(solver, 16);
    std::vector<std::size_t> counts;
    for (std::uint64_t round = 0; round < 24; ++round) {
      const TissueChange result = solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
      follower.follow();
      counts.push_back(follower.word_count());
      REQUIRE(follower.difference() == "");
      static_cast<void>(data);
    }
    std::ranges::sort(counts);
    return counts[counts.size() / 2];
  };
  const std::size_t small = count_words({8, 8, 6}), large = count_words({16, 16, 12});
  INFO(small << " words of a small body, " << large << " of a large one");
  CHECK(small > 100);
  CHECK(large < 1.5 * static_cast<double>(small));
  CHECK(large < 40'000);
}

}  // namespace pbdsurg::cuda
