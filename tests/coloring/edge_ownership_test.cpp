// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/edge_ownership.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using TetEdges = std::vector<std::array<Index, 6>>;

// Each edge has one owner, which knows of it, and nobody owns more than is said.
void check_ownership(const EdgeOwnership& ownership, Index edge_count, const TetEdges& tet_edges) {
  REQUIRE(ownership.owner.size() == static_cast<std::size_t>(edge_count));
  REQUIRE(ownership.owned_edges.size() == tet_edges.size());
  Index owned = 0;
  Index strangers = 0;
  int most = 0;
  for (std::size_t t = 0; t < tet_edges.size(); ++t) {
    const std::uint8_t bits = ownership.owned_edges[t];
    most = std::max(most, std::popcount(bits));
    owned += std::popcount(bits);
    for (int i = 0; i < 6; ++i) {
      if ((bits >> i & 1) != 0 && ownership.owner[tet_edges[t][i]] != static_cast<Index>(t)) {
        ++strangers;
      }
    }
    strangers += bits >> 6;
  }
  CHECK(owned == edge_count);
  CHECK(strangers == 0);
  CHECK(most == ownership.max_owned);
}

// By Hall's theorem: some tets must share all edges that no other tet has.
int least_max_owned(Index edge_count, const TetEdges& tet_edges) {
  std::vector<unsigned> around(static_cast<std::size_t>(edge_count), 0);
  for (std::size_t t = 0; t < tet_edges.size(); ++t) {
    for (const Index edge : tet_edges[t]) {
      around[edge] |= 1u << t;
    }
  }
  int least = 0;
  for (unsigned some = 1; some < 1u << tet_edges.size(); ++some) {
    const auto edges = static_cast<int>(
        std::count_if(around.begin(), around.end(), [&](unsigned a) { return (a & ~some) == 0; }));
    const int tets = std::popcount(some);
    least = std::max(least, (edges + tets - 1) / tets);
  }
  return least;
}

}  // namespace

TEST_CASE("edge ownership: two edges a tet are enough for meshes", "[property]") {
  for (const TetMesh& mesh : {testing::make_box({7, 5, 3}, 1e-3, 0.1), table2_mesh(1)}) {
    const std::vector<Edge> edges = find_edges(mesh.tets());
    const TetEdges tet_edges = find_tet_edges(mesh.tets(), edges);
    const auto edge_count = static_cast<Index>(edges.size());

    const EdgeOwnership ownership = assign_edges_to_tets(edge_count, tet_edges);

    check_ownership(ownership, edge_count, tet_edges);
    CHECK(ownership.max_owned == 2);
  }
}

// Would catch sharing that stops at the first greedy answer: ragged scraps of mesh are tight.
TEST_CASE("edge ownership: no sharing has a smaller maximum", "[property]") {
  const TetMesh box = testing::make_box({2, 2, 2}, 1e-3);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::vector<std::pair<double, Tet>> drawn;
    for (const Tet& tet : box.tets()) {
      drawn.emplace_back(random_unit(seed, drawn.size()), tet);
    }
    std::sort(drawn.begin(), drawn.end());
    std::vector<Tet> tets;
    for (std::uint64_t i = 0; i < 1 + seed % 12; ++i) {
      tets.push_back(drawn[i].second);
    }
    const std::vector<Edge> edges = find_edges(tets);
    const TetEdges tet_edges = find_tet_edges(tets, edges);
    const auto edge_count = static_cast<Index>(edges.size());

    const EdgeOwnership ownership = assign_edges_to_tets(edge_count, tet_edges);

    INFO("seed " << seed);
    check_ownership(ownership, edge_count, tet_edges);
    CHECK(ownership.max_owned == least_max_owned(edge_count, tet_edges));
  }
}

// A closed strip of n tets, each of four consecutive vertices, has 3 n edges: all must own just
// three. Would catch paths followed by recursion, and searches that start over for every path.
TEST_CASE("edge ownership: a strip without any slack is shared out evenly", "[unit]") {
  constexpr Index kTets = 100'000;
  std::vector<Index> name(3 * kTets);
  std::iota(name.begin(), name.end(), 0);
  for (Index i = 3 * kTets - 1; i > 0; --i) {
    std::swap(name[i], name[random_bits(1, i) % (i + 1)]);
  }
  const auto edge = [&](Index from, Index length) { return name[from % kTets * 3 + length - 1]; };
  TetEdges tet_edges;
  for (Index i = 0; i < kTets; ++i) {
    tet_edges.push_back(
        {edge(i, 1), edge(i, 2), edge(i, 3), edge(i + 1, 1), edge(i + 1, 2), edge(i + 2, 1)});
  }

  const EdgeOwnership ownership = assign_edges_to_tets(3 * kTets, tet_edges);

  check_ownership(ownership, 3 * kTets, tet_edges);
  CHECK(ownership.max_owned == 3);
}

TEST_CASE("edge ownership: a tet on its own owns all its edges", "[unit]") {
  const EdgeOwnership ownership = assign_edges_to_tets(6, TetEdges{{5, 4, 3, 2, 1, 0}});

  CHECK(ownership.owner == std::vector<Index>(6, 0));
  CHECK(ownership.owned_edges == std::vector<std::uint8_t>{0x3F});
  CHECK(ownership.max_owned == 6);
  CHECK(assign_edges_to_tets(0, {}).max_owned == 0);
}

TEST_CASE("edge ownership: bad edges are refused by name", "[unit]") {
  const TetEdges one{{0, 1, 2, 3, 4, 5}};
  CHECK_THROWS_WITH(assign_edges_to_tets(5, one),
                    ContainsSubstring("tetrahedron 0 has edge 5") && ContainsSubstring("[0, 5)"));
  CHECK_THROWS_WITH(assign_edges_to_tets(6, TetEdges{{0, 1, 2, 3, 4, -1}}),
                    ContainsSubstring("has edge -1"));
  CHECK_THROWS_WITH(assign_edges_to_tets(6, TetEdges{{0, 1, 2, 3, 4, 2}}),
                    ContainsSubstring("edge 2 twice"));
  CHECK_THROWS_WITH(assign_edges_to_tets(7, one),
                    ContainsSubstring("edge 6 belongs to no tetrahedron"));
  CHECK_THROWS_WITH(assign_edges_to_tets(-1, {}), ContainsSubstring("-1"));
}

}  // namespace pbdsurg
