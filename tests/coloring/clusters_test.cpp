// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/clusters.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/greedy.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// Every constraint is in one cluster of at most `size`, whose vertices are those of its members.
void check_clusters(const ConstraintClusters& clusters, const ConstraintVertices& constraints,
                    Index size) {
  std::vector<int> seen(static_cast<std::size_t>(constraints.constraint_count()), 0);
  Index misshapen = 0;
  REQUIRE(clusters.vertices.list_count() == clusters.members.list_count());
  for (Index k = 0; k < clusters.members.list_count(); ++k) {
    const auto members = clusters.members[k];
    std::set<Index> vertices;
    for (const Index c : members) {
      ++seen[c];
      vertices.insert(constraints[c].begin(), constraints[c].end());
    }
    const auto listed = clusters.vertices[k];
    if (members.empty() || members.size() > static_cast<std::size_t>(size) ||
        !std::equal(listed.begin(), listed.end(), vertices.begin(), vertices.end())) {
      ++misshapen;
    }
  }
  CHECK(misshapen == 0);
  CHECK(std::count(seen.begin(), seen.end(), 1) == constraints.constraint_count());
}

}  // namespace

// Would catch clusters that are ragged or left half empty: they need more colours.
TEST_CASE("clusters: twice the size takes fewer colours", "[property]") {
  struct Expected {
    Index size;
    Index gallbladder;
    Index lattice;
  };
  const TetMesh gallbladder = table2_mesh(1);
  const TetMesh lattice = testing::make_box({15, 15, 15}, 1e-3);
  for (const auto& [size, most_gallbladder, most_lattice] :
       {Expected{2, 23, 21}, Expected{4, 16, 16}, Expected{8, 13, 14}, Expected{16, 10, 13}}) {
    for (const auto& [mesh, most] :
         {std::pair(&gallbladder, most_gallbladder), std::pair(&lattice, most_lattice)}) {
      const ConstraintVertices constraints(mesh->tets(), mesh->vertex_count());

      const ConstraintClusters clusters = cluster_constraints(constraints, size);
      const ConstraintVertices blocks(clusters.vertices, mesh->vertex_count());
      const Coloring coloring = color_greedy(blocks, GreedyOrder::saturation);

      INFO("size " << size << ", " << mesh->tet_count() << " tets");
      check_clusters(clusters, constraints, size);
      CHECK(clusters.members.list_count() <= 1.02 * mesh->tet_count() / size);
      CHECK(coloring.color_count <= most);
      CHECK_FALSE(find_conflict(coloring, blocks));
    }
  }
}

TEST_CASE("clusters: the neighbour that adds the fewest vertices joins", "[unit]") {
  const std::vector<Tet> tets{{0, 1, 2, 3}, {3, 4, 5, 6}, {1, 2, 3, 7}};

  const ConstraintClusters clusters = cluster_constraints({std::span<const Tet>(tets), 8}, 2);

  CHECK(clusters.members.entries == std::vector<Index>{0, 2, 1});
  CHECK(clusters.members.offsets == std::vector<Index>{0, 2, 3});
  CHECK(clusters.vertices.entries == std::vector<Index>{0, 1, 2, 3, 7, 3, 4, 5, 6});
  CHECK(clusters.vertices.offsets == std::vector<Index>{0, 5, 9});
}

// Both neighbours of the first link add one vertex. Would catch one left alone at the end of a
// chain: with the inner one taken, the outer one has nobody to join.
TEST_CASE("clusters: the neighbour that would be left alone joins first", "[unit]") {
  const std::vector<Edge> chain{{1, 2}, {2, 3}, {3, 4}, {0, 1}};

  const ConstraintClusters clusters = cluster_constraints({std::span<const Edge>(chain), 5}, 2);

  CHECK(clusters.members.entries == std::vector<Index>{0, 3, 1, 2});
  CHECK(clusters.members.offsets == std::vector<Index>{0, 2, 4});
}

TEST_CASE("clusters: constraints of any arity, apart or with a common hub, are grouped", "[unit]") {
  IndexLists lists;
  for (Index i = 0; i < 300; ++i) {
    const std::vector<Index> ids =
        i % 3 == 0 ? std::vector<Index>{i + 1} : std::vector<Index>{0, i + 1};
    lists.entries.insert(lists.entries.end(), ids.begin(), ids.end());
    lists.offsets.push_back(static_cast<Index>(lists.entries.size()));
  }
  const ConstraintVertices constraints(lists, 301);

  const ConstraintClusters clusters = cluster_constraints(constraints, 8);

  check_clusters(clusters, constraints, 8);
  CHECK(clusters.members.list_count() == 100 + 200 / 8);
}

TEST_CASE("clusters: nothing makes no cluster, and room for all makes one", "[unit]") {
  const TetMesh box = testing::make_box({2, 2, 2}, 1e-3);
  const ConstraintVertices constraints(box.tets(), box.vertex_count());

  CHECK(cluster_constraints({std::span<const Tet>(), 0}, 4).members.list_count() == 0);
  CHECK(cluster_constraints(constraints, 1000).members.list_count() == 1);
  check_clusters(cluster_constraints(constraints, 1), constraints, 1);
}

TEST_CASE("clusters: bad sizes and constraints are refused", "[unit]") {
  const std::vector<Edge> edges{{0, 1}, {1, 4}};
  CHECK_THROWS_WITH(cluster_constraints({std::span<const Edge>(edges), 5}, 0),
                    ContainsSubstring("cluster of 0"));
  CHECK_THROWS_WITH(cluster_constraints({std::span<const Edge>(edges), 4}, 2),
                    ContainsSubstring("vertex 4"));
}

}  // namespace pbdsurg
