// SPDX-License-Identifier: Apache-2.0
#include "edit/split_tets.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory_resource>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "edit/removal.h"
#include "solver/growth.h"
#include "solver/neo_hookean_record.h"

namespace pbdsurg {
namespace {

// A part's numbers, taken from the parent while that is there.
struct Part {
  Index tet;
  std::optional<ConstraintRecord<VolumeConstraint>> volume;
  std::optional<ConstraintRecord<NeoHookeanConstraint>> neo_hookean;
};

// Of an edge of a part, from the six lengths of the parent.
float length_between(const std::array<double, 4>& a, const std::array<double, 4>& b,
                     const std::array<double, 6>& lengths) {
  double square = 0;
  double longest = 0;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    square -= lengths[e] * lengths[e] * (a[i] - b[i]) * (a[j] - b[j]);
    longest = std::max(longest, lengths[e]);
  }
  constexpr double kShortest = 1e-3;  // lengths that were changed may belong to no tetrahedron
  return static_cast<float>(std::max(std::sqrt(std::max(square, 0.0)), kShortest * longest));
}

EdgeNumbers part_numbers(const std::array<EdgeNumbers, 6>& parent, const std::array<double, 4>& a,
                         const std::array<double, 4>& b) {
  EdgeNumbers numbers = parent.front();
  std::array<double, 6> lengths{};
  if (numbers.distance) {
    for (std::size_t e = 0; e < 6; ++e) {
      lengths[e] = (*parent[e].distance)[DistanceConstraint::kRest];
    }
    (*numbers.distance)[DistanceConstraint::kRest] = length_between(a, b, lengths);
  }
  if (numbers.limit) {
    for (std::size_t e = 0; e < 6; ++e) {
      lengths[e] = (*parent[e].limit)[StrainLimitConstraint::kLimit];
    }
    (*numbers.limit)[StrainLimitConstraint::kLimit] = length_between(a, b, lengths);
  }
  return numbers;
}

Eigen::Matrix3d sides_of(const Shares& shares) {
  Eigen::Matrix3d sides;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      sides(i, k) = shares[k + 1][i + 1] - shares[0][i + 1];
    }
  }
  return sides;
}

// kInvalidIndex if no live tetrahedron has it.
Index find_live_edge(const SolverData& data, Index a, Index b) {
  for (const Index tet : data.vertex_tets[a]) {
    for (const Index edge : data.tet_edges[tet]) {
      if (data.edges[edge] == Edge{std::min(a, b), std::max(a, b)}) {
        return edge;
      }
    }
  }
  return kInvalidIndex;
}

Part add_part(SolverData& data, const NewTet& tet, const Shares& shares,
              std::pmr::vector<std::pair<Index, EdgeNumbers>>& added) {
  std::array<EdgeNumbers, 6> parent;
  for (std::size_t e = 0; e < 6; ++e) {
    parent[e] = numbers_of(data, data.tet_edges[tet.parent][e]);
  }
  const double share = volume_share(shares);
  const Index id = add_tet(data, tet.vertices, data.body_of_tet(tet.parent),
                           share * data.tet_masses[tet.parent]);
  std::array<Index, 6> edges;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    const Index a = tet.vertices[i], b = tet.vertices[j];
    edges[e] = find_live_edge(data, a, b);
    if (edges[e] == kInvalidIndex) {
      edges[e] = add_edge(data, {std::min(a, b), std::max(a, b)});
      added.emplace_back(edges[e], part_numbers(parent, shares[i], shares[j]));
    }
    data.set_edge_tets(edges[e], data.edge_tets[edges[e]] + 1);
  }
  data.set_tet(id, tet.vertices, edges);
  for (const Index v : tet.vertices) {
    data.add_tet_at(v, id);
  }
  Part part{id, {}, {}};
  const Tet places = data.places_of(tet.vertices);
  if (data.volumes.is_alive(tet.parent)) {
    part.volume = data.volumes.record(tet.parent);
    part.volume->places = places;
    part.volume->parameters[VolumeConstraint::kRest] *= static_cast<float>(share);
  }
  if (data.neo_hookeans.is_alive(tet.parent)) {
    part.neo_hookean = make_part(data.neo_hookeans.record(tet.parent), sides_of(shares), places);
  }
  return part;
}

}  // namespace

std::optional<Shares> find_shares(const SolverData& data, const TopologyEdit& edit,
                                  const NewTet& tet, Index first_new_vertex) {
  const Tet& corners = data.tets[tet.parent];
  Shares shares{};
  const auto add = [&](std::size_t k, Index vertex, double share) {
    const auto corner = std::ranges::find(corners, vertex) - corners.begin();
    if (corner == 4) {
      return false;
    }
    shares[k][corner] += share;
    return true;
  };
  for (std::size_t k = 0; k < 4; ++k) {
    const Index v = tet.vertices[k];
    bool is_found = false;
    if (v >= first_new_vertex) {
      const NewVertex& vertex = edit.new_vertices[v - first_new_vertex];
      is_found = add(k, vertex.first, 1 - double{vertex.share}) &&
                 add(k, vertex.second, double{vertex.share});
    } else {
      is_found = add(k, v, 1);
    }
    if (!is_found) {
      return std::nullopt;
    }
  }
  return shares;
}

double volume_share(const Shares& shares) {
  return sides_of(shares).determinant();
}

void replace_parents(SolverData& data, const TopologyEdit& edit, EditResult& result) {
  std::pmr::vector<Part> parts(data.scratch.get());
  std::pmr::vector<std::pair<Index, EdgeNumbers>> added(data.scratch.get());
  for (const NewTet& tet : edit.new_tets) {
    parts.push_back(
        add_part(data, tet, *find_shares(data, edit, tet, result.first_new_vertex), added));
  }
  for (const NewTet& tet : edit.new_tets) {
    if (data.tet_alive[tet.parent]) {
      remove_tet(data, tet.parent, result);
    }
  }
  for (const Part& part : parts) {
    const Tet& vertices = data.tets[part.tet];
    if (part.volume) {
      const Index group = find_free_group(data, PhaseKind::volume, vertices);
      data.volumes.add(part.tet, group, *part.volume);
      data.log_constraint(PhaseKind::volume, part.tet);
    }
    if (part.neo_hookean) {
      const Index group = find_free_group(data, PhaseKind::neo_hookean, vertices);
      data.neo_hookeans.add(part.tet, group, *part.neo_hookean);
      data.log_constraint(PhaseKind::neo_hookean, part.tet);
    }
  }
  for (const auto& [edge, numbers] : added) {
    add_edge_constraints(data, edge, numbers);
  }
}

}  // namespace pbdsurg
