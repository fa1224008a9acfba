// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/topology.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "lib/mesh/vertex_ids.h"

namespace pbdsurg {
namespace {

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

Index find_root(std::vector<Index>& parent, Index v) {
  while (parent[v] != v) {
    parent[v] = parent[parent[v]];  // path halving
    v = parent[v];
  }
  return v;
}

template <class Element>
Components components_of(Index vertex_count, std::span<const Element> elements) {
  check_vertex_ids(vertex_count, elements);
  std::vector<Index> parent(static_cast<std::size_t>(vertex_count));
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<bool> used(parent.size(), false);
  for (const Element& element : elements) {
    for (const Index v : element) {
      used[v] = true;
      // the smaller root wins, so that components are numbered by their smallest vertex
      const Index a = find_root(parent, element[0]);
      const Index b = find_root(parent, v);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  Components result;
  result.of_vertex.assign(parent.size(), kInvalidIndex);
  for (Index v = 0; v < vertex_count; ++v) {
    if (!used[v]) {
      continue;
    }
    const Index root = find_root(parent, v);
    result.of_vertex[v] = root == v ? result.count++ : result.of_vertex[root];
  }
  return result;
}

}  // namespace

std::vector<Edge> find_edges(std::span<const Tet> tets) {
  std::vector<Edge> edges;
  edges.reserve(6 * tets.size());
  for (const Tet& tet : tets) {
    for (const auto& [i, j] : kTetEdges) {
      edges.push_back({std::min(tet[i], tet[j]), std::max(tet[i], tet[j])});
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

Index find_edge(std::span<const Edge> edges, Index a, Index b) {
  const Edge key{std::min(a, b), std::max(a, b)};
  const auto place = std::lower_bound(edges.begin(), edges.end(), key);
  if (place == edges.end() || *place != key) {
    throw InvalidArgument("there is no edge between vertices " + std::to_string(a) + " and " +
                          std::to_string(b) + " in the list");
  }
  return static_cast<Index>(place - edges.begin());
}

std::vector<std::array<Index, 6>> find_tet_edges(std::span<const Tet> tets,
                                                 std::span<const Edge> edges) {
  std::vector<std::array<Index, 6>> result(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      result[t][e] = find_edge(edges, tets[t][kTetEdges[e][0]], tets[t][kTetEdges[e][1]]);
    }
  }
  return result;
}

std::vector<BoundaryTriangle> find_boundary(std::span<const Tet> tets) {
  struct Face {
    Triangle key;
    Index id;  // 4 * tet + local face
  };
  std::vector<Face> faces;
  faces.reserve(4 * tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (int f = 0; f < 4; ++f) {
      const auto& [i, j, k] = kTetTriangles[f];
      faces.push_back(
          {sorted({tets[t][i], tets[t][j], tets[t][k]}), static_cast<Index>(4 * t + f)});
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.key != b.key ? a.key < b.key : a.id < b.id;
  });

  std::vector<Index> single;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].key == faces[i].key) {
      ++end;
    }
    if (end - i == 1) {
      single.push_back(faces[i].id);
    }
    i = end;
  }
  std::sort(single.begin(), single.end());

  std::vector<BoundaryTriangle> boundary;
  boundary.reserve(single.size());
  for (const Index id : single) {
    const Tet& tet = tets[id / 4];
    const auto& [i, j, k] = kTetTriangles[id % 4];
    boundary.push_back({{tet[i], tet[j], tet[k]}, id / 4});
  }
  return boundary;
}

IndexLists find_vertex_tets(Index vertex_count, std::span<const Tet> tets) {
  check_vertex_ids(vertex_count, tets);
  IndexLists lists;
  lists.offsets.assign(static_cast<std::size_t>(vertex_count) + 1, 0);
  for (const Tet& tet : tets) {
    for (const Index v : tet) {
      ++lists.offsets[v + 1];
    }
  }
  std::partial_sum(lists.offsets.begin(), lists.offsets.end(), lists.offsets.begin());
  lists.entries.resize(4 * tets.size());
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (const Index v : tets[t]) {
      lists.entries[next[v]++] = static_cast<Index>(t);
    }
  }
  return lists;
}

Components find_components(Index vertex_count, std::span<const Tet> tets) {
  return components_of(vertex_count, tets);
}

Components find_components(Index vertex_count, std::span<const Triangle> triangles) {
  return components_of(vertex_count, triangles);
}

}  // namespace pbdsurg
