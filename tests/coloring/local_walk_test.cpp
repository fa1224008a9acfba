// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/local_walk.h"

#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/coloring/coloring.h"

#include "lib/coloring/fewer_colors.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

constexpr std::array<Index, 8> kColors{0, 1, 2, 3, 4, 5, 6, 7};

// Vertices of a block, each in the last of eight colours that those before it leave.
struct Block {
  explicit Block(Index length) {
    const TetMesh mesh = testing::make_box({length, 4, 4}, 1e-3);
    const std::vector<Tet> tets(mesh.tets().begin(), mesh.tets().end());
    const IndexLists at_vertex = find_vertex_constraints({std::span(tets), mesh.vertex_count()});
    const IndexLists found = find_conflicts({at_vertex, static_cast<Index>(tets.size())});
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      conflicts.emplace_back(found[v].begin(), found[v].end());
    }
    color_of.assign(conflicts.size(), kInvalidIndex);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const auto last = std::find_if(kColors.rbegin(), kColors.rend(),
                                     [&](Index color) { return is_free(v, color); });
      REQUIRE(last != kColors.rend());
      color_of[v] = *last;
    }
  }

  [[nodiscard]] bool is_free(Index vertex, Index color) const {
    return std::ranges::none_of(conflicts[vertex],
                                [&](Index other) { return color_of[other] == color; });
  }

  // Takes its colour, and joins it to vertices until it has neighbours of all.
  void crowd(Index vertex) {
    color_of[vertex] = kInvalidIndex;
    for (const Index color : kColors) {
      const auto all = with(color);
      const auto next = std::ranges::lower_bound(all, vertex);
      if (is_free(vertex, color) && next != all.end()) {
        conflicts[vertex].push_back(*next);
        conflicts[*next].push_back(vertex);
      }
    }
  }

  bool run(LocalWalk& walk, std::span<const Index> uncolored, std::span<const Index> colors,
           std::int64_t effort) {
    return walk.run(
        uncolored, colors, color_of,
        [&](Index v) {
          ++lists_asked;
          return std::span<const Index>(conflicts[v]);
        },
        effort);
  }

  [[nodiscard]] std::vector<Index> with(Index color) const {
    std::vector<Index> found;
    for (Index v = 0; v < static_cast<Index>(color_of.size()); ++v) {
      if (color_of[v] == color) {
        found.push_back(v);
      }
    }
    return found;
  }

  void apply(const LocalWalk& walk) {
    for (const auto& [vertex, color] : walk.changes()) {
      CHECK(color_of[vertex] != color);
      color_of[vertex] = color;
    }
  }

  void check() const {
    for (Index v = 0; v < static_cast<Index>(color_of.size()); ++v) {
      REQUIRE(color_of[v] != kInvalidIndex);
      for (const Index other : conflicts[v]) {
        REQUIRE(color_of[v] != color_of[other]);
      }
    }
  }

  std::vector<std::vector<Index>> conflicts;
  std::vector<Index> color_of;
  int lists_asked = 0;
};

}  // namespace

// Would catch changes of what has its colour already, and lists that a walk takes for those of
// another.
TEST_CASE("local walk: those without a colour get one, others move", "[property]") {
  Block block(8);
  LocalWalk walk;
  for (Index v = 40; v < 60; v += 3) {
    INFO("vertex " << v);
    block.crowd(v);
    const std::vector<Index> before = block.color_of;
    REQUIRE(block.run(walk, std::array{v}, kColors, 100'000));
    CHECK(block.color_of == before);
    CHECK(walk.changes().size() > 1);
    LocalWalk another;
    REQUIRE(block.run(another, std::array{v}, kColors, 100'000));
    CHECK(std::ranges::equal(walk.changes(), another.changes(), [](auto a, auto b) {
      return a.constraint == b.constraint && a.color == b.color;
    }));
    block.apply(walk);
    block.check();
    walk.forget_conflicts();
  }
}

// Would catch lists that are asked for again, and a failure that leaves something behind.
TEST_CASE("local walk: a colour is emptied, or nothing has changed", "[property]") {
  Block block(8);
  LocalWalk walk;
  std::vector<Index> colors(kColors.begin(), kColors.end());
  for (Index gone = 7; gone >= 0; --gone) {
    INFO("colour " << gone);
    std::erase(colors, gone);
    const std::vector<Index> before = block.color_of;
    if (block.run(walk, block.with(gone), colors, 1'000'000)) {
      block.apply(walk);
      block.check();
      CHECK(block.with(gone).empty());
    } else {
      CHECK(walk.changes().empty());
      CHECK(block.color_of == before);
      colors.push_back(gone);
    }
  }
  CHECK(colors.size() < kColors.size());
  CHECK(colors.size() >= 4);  // as a tetrahedron needs
  CHECK(block.lists_asked <= static_cast<int>(block.color_of.size()));
}

TEST_CASE("local walk: without colours or effort it fails", "[unit]") {
  Block block(4);
  LocalWalk walk;
  block.color_of[7] = kInvalidIndex;
  CHECK_FALSE(block.run(walk, std::array{Index{7}}, {}, 1000));
  CHECK_FALSE(block.run(walk, std::array{Index{7}}, kColors, 0));
  CHECK(block.run(walk, {}, {}, 0));
  CHECK(block.run(walk, std::array{Index{7}}, kColors, 100'000));
}

// Would catch anything that is looked at for all.
TEST_CASE("local walk: what it asks for does not grow with the mesh", "[unit]") {
  const auto count_lists = [](Index length) {
    Block block(length);
    const Index middle = static_cast<Index>(block.color_of.size()) / 2;
    block.crowd(middle);
    LocalWalk walk;
    REQUIRE(block.run(walk, std::array{middle}, kColors, 100'000));
    return block.lists_asked;
  };
  const int few = count_lists(10), many = count_lists(200);  // of 275 and 5025 vertices
  CHECK(few > 1);
  CHECK(many < 5 * few);
}

}  // namespace pbdsurg
