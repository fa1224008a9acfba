// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/partition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

struct Block {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Edge> edges;
};

/// The first two axes along the six monotone paths from one corner of a cube to the opposite one.
constexpr std::array<std::array<int, 2>, 6> kFirstTwoSteps{
    {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}}};

/// A block of cubes of six tets each; its numbering is shuffled so that ids say nothing about
/// place.
Block make_block(int nx, int ny, int nz) {
  std::vector<Index> label(static_cast<std::size_t>((nx + 1) * (ny + 1) * (nz + 1)));
  for (std::size_t i = 0; i < label.size(); ++i) {
    label[i] = static_cast<Index>(i);
    std::swap(label[i], label[random_bits(7, i) % (i + 1)]);
  }
  const auto id = [&](int x, int y, int z) { return label[(z * (ny + 1) + y) * (nx + 1) + x]; };
  Block block;
  block.positions.resize(label.size());
  std::vector<Tet> tets;
  for (int z = 0; z <= nz; ++z) {
    for (int y = 0; y <= ny; ++y) {
      for (int x = 0; x <= nx; ++x) {
        block.positions[id(x, y, z)] = 1e-3 * Eigen::Vector3d(x, y, z);
        if (x == nx || y == ny || z == nz) {
          continue;
        }
        for (const auto& [a, b] : kFirstTwoSteps) {
          std::array<int, 3> corner{x, y, z};
          Tet tet{id(x, y, z), 0, 0, id(x + 1, y + 1, z + 1)};
          ++corner[a];
          tet[1] = id(corner[0], corner[1], corner[2]);
          ++corner[b];
          tet[2] = id(corner[0], corner[1], corner[2]);
          tets.push_back(tet);
        }
      }
    }
  }
  block.edges = find_edges(tets);
  return block;
}

std::vector<Index> part_sizes(const Partition& partition) {
  std::vector<Index> sizes(static_cast<std::size_t>(partition.part_count), 0);
  for (const Index part : partition.part_of_vertex) {
    REQUIRE(part >= 0);
    REQUIRE(part < partition.part_count);
    ++sizes[part];
  }
  return sizes;
}

std::vector<PartitionMethod> built_methods() {
  std::vector<PartitionMethod> methods{PartitionMethod::recursive_bisection};
  if (has_metis()) {
    methods.push_back(PartitionMethod::metis);
  }
  return methods;
}

}  // namespace

TEST_CASE("partition: parts are balanced and none is empty", "[property]") {
  const Block block = make_block(19, 9, 6);
  const auto vertex_count = static_cast<Index>(block.positions.size());
  for (const PartitionMethod method : built_methods()) {
    for (const Index part_count : {1, 2, 3, 7, 16, 100, 1399, 1400}) {
      const Partition partition =
          partition_vertices(block.edges, block.positions, part_count, method);
      const std::vector<Index> sizes = part_sizes(partition);

      INFO("method " << partition.method << ", parts " << part_count);
      CHECK(partition.part_of_vertex.size() == block.positions.size());
      const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end());
      CHECK(*smallest > 0);
      if (partition.method == "metis") {
        CHECK(*largest <= std::ceil(1.03 * vertex_count / part_count));
      } else {
        CHECK(*largest - *smallest <= 1);
      }
    }
  }
}

// Would catch METIS being replaced by the fallback where it has an easy graph.
TEST_CASE("partition: the method that was asked for is the one used", "[unit]") {
  const Block block = make_block(19, 9, 6);
  const auto method_of = [&](PartitionMethod method) {
    return partition_vertices(block.edges, block.positions, 8, method).method;
  };

  CHECK(method_of(PartitionMethod::recursive_bisection) == "recursive bisection");
  if (has_metis()) {
    CHECK(method_of(PartitionMethod::metis) == "metis");
    CHECK(method_of(PartitionMethod::best) == "metis");
  } else {
    CHECK(method_of(PartitionMethod::best) == "recursive bisection");
    CHECK_THROWS_AS(method_of(PartitionMethod::metis), BackendUnavailable);
  }
}

TEST_CASE("partition: the same input gives the same parts", "[property]") {
  const Block block = make_block(12, 8, 6);
  for (const PartitionMethod method : built_methods()) {
    const Partition first = partition_vertices(block.edges, block.positions, 9, method, 5);
    const Partition other = partition_vertices(block.edges, block.positions, 4, method, 1);
    const Partition second = partition_vertices(block.edges, block.positions, 9, method, 5);

    CHECK(other.part_count == 4);  // asked for between the two, it must leave no trace
    CHECK(first.part_of_vertex == second.part_of_vertex);
    CHECK(first.cut_edges == second.cut_edges);
  }
}

// Would catch parts that ignore the mesh: with 8 random parts 7 of 8 edges are cut.
TEST_CASE("partition: few edges are cut, and they are counted right", "[property]") {
  const Block block = make_block(19, 9, 6);
  for (const PartitionMethod method : built_methods()) {
    const Partition partition = partition_vertices(block.edges, block.positions, 8, method);
    Index counted = 0, random_cut = 0;
    for (const auto& [a, b] : block.edges) {
      counted += partition.part_of_vertex[a] != partition.part_of_vertex[b];
      random_cut += random_bits(3, static_cast<std::uint64_t>(a)) % 8 !=
                    random_bits(3, static_cast<std::uint64_t>(b)) % 8;
    }

    INFO("method " << partition.method);
    CHECK(partition.cut_edges == counted);
    CHECK(3 * partition.cut_edges < random_cut);
  }
}

// Would catch a split along a fixed axis: the first cut of a bar must be across its length.
TEST_CASE("partition: a bar is halved across its length", "[unit]") {
  const int axis = GENERATE(0, 1, 2);
  const Block block = make_block(axis == 0 ? 9 : 1, axis == 1 ? 9 : 1, axis == 2 ? 9 : 1);

  const Partition partition =
      partition_vertices(block.edges, block.positions, 2, PartitionMethod::recursive_bisection);

  for (std::size_t v = 0; v < block.positions.size(); ++v) {
    CHECK(partition.part_of_vertex[v] == (block.positions[v][axis] > 4.5e-3 ? 1 : 0));
  }
}

TEST_CASE("partition: vertices at one place and vertices without edges get parts", "[unit]") {
  const std::vector<Eigen::Vector3d> same(10, Eigen::Vector3d(1, 2, 3));
  for (const PartitionMethod method : built_methods()) {
    for (const std::vector<Edge>& edges :
         {std::vector<Edge>{}, std::vector<Edge>{{0, 1}, {0, 1}}}) {
      const std::vector<Index> sizes = part_sizes(partition_vertices(edges, same, 5, method));

      CHECK(std::count(sizes.begin(), sizes.end(), 0) == 0);
    }
  }
}

TEST_CASE("partition: what breaks a rule is refused by name", "[unit]") {
  std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const std::vector<Edge> edges{{0, 1}, {1, 2}};

  CHECK_THROWS_WITH(partition_vertices(edges, points, 0), ContainsSubstring("part_count is 0"));
  CHECK_THROWS_WITH(partition_vertices(edges, points, -1), ContainsSubstring("part_count is -1"));
  CHECK_THROWS_WITH(partition_vertices(edges, points, 4), ContainsSubstring("part_count is 4"));
  CHECK_THROWS_AS(partition_vertices({}, {}, 1), InvalidArgument);
  CHECK_THROWS_WITH(partition_vertices(std::vector<Edge>{{0, 1}, {1, 3}}, points, 2),
                    ContainsSubstring("edge 1") && ContainsSubstring("vertex 3"));
  CHECK_THROWS_WITH(partition_vertices(std::vector<Edge>{{-1, 1}}, points, 2),
                    ContainsSubstring("edge 0") && ContainsSubstring("vertex -1"));
  CHECK_THROWS_WITH(partition_vertices(std::vector<Edge>{{1, 1}}, points, 2),
                    ContainsSubstring("edge 0") && ContainsSubstring("itself"));
  points[2].y() = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(partition_vertices(edges, points, 2), ContainsSubstring("vertex 2"));
}

}  // namespace pbdsurg
