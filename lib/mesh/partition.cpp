// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/partition.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#if defined(PBDSURG_HAS_METIS)
#include <mutex>
#include <new>

#include <metis.h>
#endif

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

void check_arguments(std::span<const Edge> edges, std::span<const Eigen::Vector3d> positions,
                     Index part_count) {
  if (positions.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw InvalidArgument("a partition may have at most 2147483647 vertices, got " +
                          std::to_string(positions.size()));
  }
  const auto vertex_count = static_cast<Index>(positions.size());
  if (part_count < 1 || part_count > vertex_count) {
    throw InvalidArgument("part_count is " + std::to_string(part_count) +
                          "; it must be in [1, vertex_count], and vertex_count is " +
                          std::to_string(vertex_count));
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) {
      throw InvalidArgument("vertex " + std::to_string(v) +
                            " has a coordinate that is not finite; positions must be finite");
    }
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    for (const Index v : edges[e]) {
      if (v < 0 || v >= vertex_count) {
        throw InvalidArgument("edge " + std::to_string(e) + " refers to vertex " +
                              std::to_string(v) + "; ids must be in [0, " +
                              std::to_string(vertex_count) + ")");
      }
    }
    if (edges[e][0] == edges[e][1]) {
      throw InvalidArgument("edge " + std::to_string(e) + " joins vertex " +
                            std::to_string(edges[e][0]) + " to itself; its ends must differ");
    }
  }
}

Index count_cut_edges(std::span<const Edge> edges, std::span<const Index> part_of_vertex) {
  return static_cast<Index>(std::count_if(edges.begin(), edges.end(), [&](const Edge& edge) {
    return part_of_vertex[edge[0]] != part_of_vertex[edge[1]];
  }));
}

/// The axis along which some vertices reach farthest.
int longest_axis(std::span<const Eigen::Vector3d> positions, std::span<const Index> vertices) {
  Eigen::Vector3d low = positions[vertices.front()];
  Eigen::Vector3d high = low;
  for (const Index v : vertices) {
    low = low.cwiseMin(positions[v]);
    high = high.cwiseMax(positions[v]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

/// Gives the parts [first_part, first_part + part_count) to `vertices`, whose count is
/// part_count * smaller_size plus the number of those parts with an index below larger_parts.
void bisect(std::span<const Eigen::Vector3d> positions, std::span<Index> vertices, Index first_part,
            Index part_count, Index smaller_size, Index larger_parts,
            std::vector<Index>& part_of_vertex) {
  if (part_count == 1) {
    for (const Index v : vertices) {
      part_of_vertex[v] = first_part;
    }
    return;
  }
  const Index low_parts = part_count / 2;
  const Index larger_in_low = std::clamp<Index>(larger_parts - first_part, 0, low_parts);
  const Index low_count = low_parts * smaller_size + larger_in_low;
  const auto low_size = static_cast<std::size_t>(low_count);
  const int axis = longest_axis(positions, vertices);
  // ties are broken by id, so the two halves do not depend on the order they came in
  std::nth_element(vertices.begin(), vertices.begin() + low_count, vertices.end(),
                   [&](Index a, Index b) {
                     const double xa = positions[a][axis], xb = positions[b][axis];
                     return xa != xb ? xa < xb : a < b;
                   });
  bisect(positions, vertices.first(low_size), first_part, low_parts, smaller_size, larger_parts,
         part_of_vertex);
  bisect(positions, vertices.subspan(low_size), first_part + low_parts, part_count - low_parts,
         smaller_size, larger_parts, part_of_vertex);
}

std::vector<Index> bisect_recursively(std::span<const Eigen::Vector3d> positions,
                                      Index part_count) {
  const auto vertex_count = static_cast<Index>(positions.size());
  std::vector<Index> vertices(positions.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  std::vector<Index> part_of_vertex(positions.size());
  bisect(positions, vertices, 0, part_count, vertex_count / part_count, vertex_count % part_count,
         part_of_vertex);
  return part_of_vertex;
}

#if defined(PBDSURG_HAS_METIS)

/// Adjacency in METIS's own integer type, each neighbour once.
struct MetisGraph {
  std::vector<idx_t> offsets;
  std::vector<idx_t> neighbours;
};

MetisGraph make_graph(std::span<const Edge> edges, std::size_t vertex_count) {
  std::vector<Edge> directed;
  directed.reserve(2 * edges.size());
  for (const auto& [a, b] : edges) {
    directed.push_back({a, b});
    directed.push_back({b, a});
  }
  std::sort(directed.begin(), directed.end());
  directed.erase(std::unique(directed.begin(), directed.end()), directed.end());
  MetisGraph graph;
  graph.offsets.assign(vertex_count + 1, 0);
  graph.neighbours.reserve(directed.size());
  for (const auto& [from, to] : directed) {
    ++graph.offsets[from + 1];
    graph.neighbours.push_back(to);
  }
  std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
  return graph;
}

/// Whether no part is empty or more than 3 % above the mean, rounded up.
bool is_balanced(std::span<const Index> part_of_vertex, Index part_count) {
  std::vector<Index> sizes(static_cast<std::size_t>(part_count), 0);
  for (const Index part : part_of_vertex) {
    ++sizes[part];
  }
  const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end());
  // whole numbers: largest <= ceil(1.03 vertex_count / part_count)
  const std::int64_t allowed = (103 * static_cast<std::int64_t>(part_of_vertex.size()) +
                                100 * std::int64_t{part_count} - 1) /
                               (100 * std::int64_t{part_count});
  return *smallest > 0 && *largest <= allowed;
}

/// The parts that METIS finds, or nothing where it cannot balance them.
std::vector<Index> partition_with_metis(std::span<const Edge> edges, std::size_t vertex_count,
                                        Index part_count, std::uint64_t seed) {
  if (part_count == 1) {
    return std::vector<Index>(vertex_count, 0);
  }
  if (edges.empty()) {
    return {};
  }
  MetisGraph graph = make_graph(edges, vertex_count);
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = static_cast<idx_t>(seed & 0x7fffffff);
  options[METIS_OPTION_UFACTOR] = 30;  // thousandths above the mean
  idx_t vertices = static_cast<idx_t>(vertex_count), constraints = 1, parts = part_count, cut = 0;
  std::vector<idx_t> part(vertex_count);
  int status = METIS_OK;
  {
    // METIS seeds and draws from rand(): two calls at once would disturb each other
    static std::mutex turn;
    const std::lock_guard lock(turn);
    status = METIS_PartGraphKway(&vertices, &constraints, graph.offsets.data(),
                                 graph.neighbours.data(), nullptr, nullptr, nullptr, &parts,
                                 nullptr, nullptr, options, &cut, part.data());
  }
  if (status == METIS_ERROR_MEMORY) {
    throw std::bad_alloc();
  }
  if (status != METIS_OK) {
    throw Error("METIS could not partition " + std::to_string(vertex_count) + " vertices into " +
                std::to_string(part_count) + " parts: it returned code " + std::to_string(status));
  }
  std::vector<Index> part_of_vertex(part.begin(), part.end());
  if (!is_balanced(part_of_vertex, part_count)) {
    return {};
  }
  return part_of_vertex;
}

#endif

}  // namespace

bool has_metis() noexcept {
#if defined(PBDSURG_HAS_METIS)
  return true;
#else
  return false;
#endif
}

Partition partition_vertices(std::span<const Edge> edges,
                             std::span<const Eigen::Vector3d> positions, Index part_count,
                             PartitionMethod method, [[maybe_unused]] std::uint64_t seed) {
  check_arguments(edges, positions, part_count);
  if (method == PartitionMethod::metis && !has_metis()) {
    throw BackendUnavailable("this pbdsurg was built without METIS");
  }
  Partition partition;
  partition.part_count = part_count;
#if defined(PBDSURG_HAS_METIS)
  if (method != PartitionMethod::recursive_bisection) {
    partition.part_of_vertex = partition_with_metis(edges, positions.size(), part_count, seed);
    partition.method = "metis";
  }
#endif
  if (partition.part_of_vertex.empty()) {
    partition.part_of_vertex = bisect_recursively(positions, part_count);
    partition.method = "recursive bisection";
  }
  partition.cut_edges = count_cut_edges(edges, partition.part_of_vertex);
  return partition;
}

}  // namespace pbdsurg
