// SPDX-License-Identifier: Apache-2.0
#include "tests/support/live_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pbdsurg/mesh/topology.h"

namespace pbdsurg::testing {
namespace {

// Where a point lies in a tetrahedron, as shares of its corners.
using Shares = std::array<double, 4>;

// The distance of two points in a tetrahedron of which all that is known is six lengths, which may
// belong to none once some were changed.
float length_between(const std::array<double, 6>& lengths, const Shares& a, const Shares& b) {
  double square = 0;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    square -= lengths[e] * lengths[e] * (a[i] - b[i]) * (a[j] - b[j]);
  }
  const double shortest = 1e-3 * *std::ranges::max_element(lengths);
  return static_cast<float>(std::max(std::sqrt(std::max(square, 0.0)), shortest));
}

}  // namespace

Edge edge_between(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

LiveModel::LiveModel(const Scene& scene) : gravity(scene.gravity()) {
  add_bodies(scene);
}

void LiveModel::add_bodies(const Scene& added) {
  const Index first_vertex = vertex_count();
  const auto first_tet = static_cast<Index>(tets.size());
  const auto first_triangle = static_cast<Index>(triangles.size());
  stiffnesses.insert(stiffnesses.end(), added.stiffnesses().begin(), added.stiffnesses().end());
  sheet_stiffnesses.insert(sheet_stiffnesses.end(), added.triangle_stiffnesses().begin(),
                           added.triangle_stiffnesses().end());
  fibres.insert(fibres.end(), added.fibres().begin(), added.fibres().end());
  points.insert(points.end(), added.positions().begin(), added.positions().end());
  for (Index v = 0; v < added.vertex_count(); ++v) {
    is_fixed.push_back(added.is_fixed(v));
  }
  for (Body body : added.bodies()) {
    const auto id = static_cast<Index>(bodies.size());
    for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
      vertex_bodies.push_back(id);
      const bool is_particle = body.tet_count == 0 && body.triangle_count == 0;
      particle_masses.push_back(is_particle ? added.masses()[v] : 0);
    }
    for (Tet tet : added.tets().subspan(body.first_tet, body.tet_count)) {
      for (Index& v : tet) {
        v += first_vertex;
      }
      tets.push_back(tet);
      tet_alive.push_back(true);
      tet_bodies.push_back(id);
      rest_volumes.push_back(static_cast<float>(tet_volume(points, tet)));
      for (const auto& [i, j] : kTetEdges) {
        const Edge edge = edge_between(tet[i], tet[j]);
        const double length = (points[edge[0]] - points[edge[1]]).norm();
        rest_lengths[edge] = static_cast<float>(length);
        if (std::isfinite(body.material.max_stretch)) {
          limits[edge] = static_cast<float>(body.material.max_stretch * length);
        }
      }
    }
    for (Triangle triangle : added.triangles().subspan(body.first_triangle, body.triangle_count)) {
      for (Index& v : triangle) {
        v += first_vertex;
      }
      triangles.push_back(triangle);
      triangle_alive.push_back(true);
      triangle_bodies.push_back(id);
      const auto& [a, b, c] = triangle;
      rest_areas.push_back(
          static_cast<float>((points[b] - points[a]).cross(points[c] - points[a]).norm() / 2));
    }
    body.first_triangle += first_triangle;
    body.first_vertex += first_vertex;
    body.first_tet += first_tet;
    bodies.push_back(std::move(body));
  }
  forces.resize(points.size(), Eigen::Vector3f::Zero());
  gravities.resize(bodies.size(), gravity);
  for (Link link : added.links()) {
    link.first += first_vertex;
    link.second += first_vertex;
    links.push_back(link);
  }
  link_alive.resize(links.size(), true);
  for (Hinge hinge : added.hinges()) {
    for (Index& v : hinge.vertices) {
      v += first_vertex;
    }
    hinges.push_back(hinge);
  }
  hinge_alive.resize(hinges.size(), true);
}

std::vector<LiveModel::Element> LiveModel::elements() const {
  constexpr Index kFirstTriangle = 1 << 30;
  std::vector<Element> all;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    all.push_back({{tets[t].begin(), tets[t].end()}, static_cast<Index>(t), tet_alive[t]});
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    all.push_back({{triangles[t].begin(), triangles[t].end()},
                   kFirstTriangle + static_cast<Index>(t),
                   triangle_alive[t]});
  }
  return all;
}

std::vector<LiveModel::HingeOwners> LiveModel::hinge_owners() const {
  const std::vector<Element> all = elements();
  std::vector<HingeOwners> found(hinges.size(), {kInvalidIndex, kInvalidIndex});
  for (std::size_t h = 0; h < hinges.size(); ++h) {
    const auto& v = hinges[h].vertices;
    for (const Element& element : all) {
      const auto has = [&](Index vertex) {
        return std::ranges::count(element.corners, vertex) > 0;
      };
      for (std::size_t side = 0; side < 2 && hinge_alive[h]; ++side) {
        if (element.is_alive && has(v[0]) && has(v[1]) && has(v[2 + side])) {
          found[h][side] = element.id;
        }
      }
    }
  }
  return found;
}

// Both its triangles are there, in the tetrahedra or in parts of them, and share the edge.
void LiveModel::follow_hinges(const std::vector<HingeOwners>& before, const TopologyEdit& edit,
                              Index first_new_vertex, Index first_new_tet) {
  const auto comes_of = [&](Index vertex, Index origin) {
    if (vertex < first_new_vertex) {
      return vertex == origin;
    }
    const NewVertex& made = edit.new_vertices[vertex - first_new_vertex];
    return made.first == origin && made.second == origin;
  };
  const auto is_new_tet = [&](Index id) {
    return id >= first_new_tet && id < static_cast<Index>(tets.size());
  };
  const std::vector<Element> all = elements();
  for (std::size_t h = 0; h < hinges.size(); ++h) {
    std::array<std::array<Index, 3>, 2> sides{};
    bool is_whole = hinge_alive[h];
    for (std::size_t side = 0; side < 2 && is_whole; ++side) {
      is_whole = false;
      for (const Element& element : all) {
        const Index origin =
            is_new_tet(element.id) ? edit.new_tets[element.id - first_new_tet].parent : element.id;
        std::array<Index, 3> now{kInvalidIndex, kInvalidIndex, kInvalidIndex};
        for (std::size_t k = 0; k < 3; ++k) {
          const Index vertex = hinges[h].vertices[k == 2 ? 2 + side : k];
          for (const Index corner : element.corners) {
            now[k] = comes_of(corner, vertex) ? corner : now[k];
          }
        }
        if (element.is_alive && origin == before[h][side] &&
            std::ranges::count(now, kInvalidIndex) == 0) {
          sides[side] = now;
          is_whole = true;
        }
      }
    }
    hinge_alive[h] = is_whole && sides[0][0] == sides[1][0] && sides[0][1] == sides[1][1];
    if (hinge_alive[h]) {
      hinges[h].vertices = {sides[0][0], sides[0][1], sides[0][2], sides[1][2]};
    }
  }
}

void LiveModel::remove_body(Index body) {
  for (std::size_t t = 0; t < tets.size(); ++t) {
    tet_alive[t] = tet_alive[t] && tet_bodies[t] != body;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    triangle_alive[t] = triangle_alive[t] && triangle_bodies[t] != body;
  }
  for (std::size_t v = 0; v < points.size(); ++v) {
    particle_masses[v] = vertex_bodies[v] == body ? 0 : particle_masses[v];
  }
}

void LiveModel::apply(const Solver& solver, const TopologyEdit& edit) {
  for (const RestLengthChange& change : edit.rest_lengths) {
    const Edge& edge = solver.tissue().edges()[change.edge];
    if (const auto limit = limits.find(edge); limit != limits.end()) {
      limit->second *= change.rest_length / rest_lengths[edge];
    }
    rest_lengths[edge] = change.rest_length;
  }
  for (const RestVolumeChange& change : edit.rest_volumes) {
    change_volume(change);
  }
  for (const RestAreaChange& change : edit.rest_areas) {
    rest_areas[change.triangle] = change.rest_area;
  }
  for (const StiffnessChange& change : edit.stiffnesses) {
    stiffnesses[change.tet] = change.factor;
  }
  for (const TriangleStiffnessChange& change : edit.triangle_stiffnesses) {
    sheet_stiffnesses[change.triangle] = change.factor;
  }
  for (const FibreChange& change : edit.fibres) {
    fibres[change.tet] = change.fibre;
  }
  for (const LinkLengthChange& change : edit.link_lengths) {
    links[change.link].rest_length = change.rest_length;
  }
  for (const Index v : edit.fix_vertices) {
    is_fixed[v] = true;
  }
  for (const Index v : edit.unfix_vertices) {
    is_fixed[v] = false;
  }
  for (const Index l : edit.remove_links) {
    link_alive[l] = false;
  }
  const Index first_new_vertex = vertex_count();
  const auto first_new_tet = static_cast<Index>(tets.size());
  const std::vector<HingeOwners> hinge_owners_before = hinge_owners();
  for (const NewVertex& vertex : edit.new_vertices) {
    const Eigen::Vector3d along = points[vertex.second] - points[vertex.first];
    points.push_back(points[vertex.first] + double{vertex.share} * along);
    particle_masses.push_back(0);
    vertex_bodies.push_back(vertex_bodies[vertex.first]);
    is_fixed.push_back(is_fixed[vertex.first] && is_fixed[vertex.second]);
  }
  for (const LinkMove& move : edit.link_moves) {
    (links[move.link].first == move.from ? links[move.link].first : links[move.link].second) =
        move.to;
  }
  for (const Index t : edit.remove_tets) {
    tet_alive[t] = false;
  }
  for (const Index t : edit.remove_triangles) {
    triangle_alive[t] = false;
  }
  for (const Index body : edit.remove_bodies) {
    remove_body(body);
  }
  for (const TriangleMove& move : edit.triangle_moves) {
    std::ranges::replace(triangles[move.triangle], move.from, move.to);
  }
  for (const CornerMove& move : edit.corner_moves) {
    move_corner(move);
  }
  for (const NewTet& tet : edit.new_tets) {
    add_tet(tet, edit, first_new_vertex);
  }
  for (const NewTet& tet : edit.new_tets) {
    tet_alive[tet.parent] = false;
  }
  follow_hinges(hinge_owners_before, edit, first_new_vertex, first_new_tet);
  links.insert(links.end(), edit.new_links.begin(), edit.new_links.end());
  link_alive.resize(links.size(), true);
  add_bodies(edit.new_bodies);
  has_grown = has_grown || vertex_count() > first_new_vertex || !edit.new_tets.empty();
}

// A Neo-Hookean body has no rest lengths: limits follow the shapes around an edge, each of n by the
// n-th root.
void LiveModel::change_volume(const RestVolumeChange& change) {
  const double ratio = double{change.rest_volume} / rest_volumes[change.tet];
  rest_volumes[change.tet] = change.rest_volume;
  if (body_of_tet(change.tet).material.model != ElasticModel::neo_hookean) {
    return;
  }
  for (const auto& [i, j] : kTetEdges) {
    const Edge edge = edge_between(tets[change.tet][i], tets[change.tet][j]);
    const auto limit = limits.find(edge);
    if (limit == limits.end()) {
      continue;
    }
    int around = 0;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      around += tet_alive[t] && std::ranges::count(tets[t], edge[0]) > 0 &&
                std::ranges::count(tets[t], edge[1]) > 0;
    }
    limit->second = static_cast<float>(limit->second * std::pow(ratio, 1.0 / (3 * around)));
  }
}

void LiveModel::move_corner(const CornerMove& move) {
  Tet& tet = tets[move.tet];
  for (const Index v : tet) {
    if (v != move.from) {
      const Edge before = edge_between(move.from, v);
      rest_lengths[edge_between(move.to, v)] = rest_lengths[before];
      if (const auto limit = limits.find(before); limit != limits.end()) {
        limits[edge_between(move.to, v)] = limit->second;
      }
    }
  }
  std::ranges::replace(tet, move.from, move.to);
}

void LiveModel::add_tet(const NewTet& added, const TopologyEdit& edit, Index first_new_vertex) {
  const Tet& parent = tets[added.parent];
  std::array<Shares, 4> shares{};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto add = [&](Index vertex, double share) {
      shares[k][std::ranges::find(parent, vertex) - parent.begin()] += share;
    };
    if (added.vertices[k] < first_new_vertex) {
      add(added.vertices[k], 1);
    } else {
      const NewVertex& vertex = edit.new_vertices[added.vertices[k] - first_new_vertex];
      add(vertex.first, 1 - double{vertex.share});
      add(vertex.second, vertex.share);
    }
  }
  // the first tetrahedron to have an edge says how long it is
  for (std::map<Edge, float>* const lengths : {&rest_lengths, &limits}) {
    std::array<double, 6> of_parent{};
    for (std::size_t e = 0; e < 6 && !lengths->empty(); ++e) {
      const auto length =
          lengths->find(edge_between(parent[kTetEdges[e][0]], parent[kTetEdges[e][1]]));
      of_parent[e] = length == lengths->end() ? 0 : length->second;
    }
    for (std::size_t e = 0; e < 6 && of_parent[0] > 0; ++e) {
      const auto [i, j] = kTetEdges[e];
      lengths->try_emplace(edge_between(added.vertices[i], added.vertices[j]),
                           length_between(of_parent, shares[i], shares[j]));
    }
  }
  const double share = tet_volume(points, added.vertices) / tet_volume(points, parent);
  const Index body = tet_bodies[added.parent];
  const float volume = rest_volumes[added.parent] * static_cast<float>(share);
  tets.push_back(added.vertices);
  tet_alive.push_back(true);
  tet_bodies.push_back(body);
  rest_volumes.push_back(volume);
  stiffnesses.push_back(stiffnesses[added.parent]);
  fibres.push_back(fibres[added.parent]);
}

}  // namespace pbdsurg::testing
