// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/cavity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/views/face_surface.h"

namespace pbdsurg {
namespace {

std::string name_of(const Triangle& triangle) {
  return "triangle " + std::to_string(triangle[0]) + "-" + std::to_string(triangle[1]) + "-" +
         std::to_string(triangle[2]);
}

// @throws InvalidArgument  naming the triangle, unless it is a face at the surface
TetFace face_of(const Tissue& tissue, const Triangle& triangle) {
  for (const Index v : triangle) {
    check_id("vertex", v, static_cast<std::size_t>(tissue.vertex_count()));
  }
  for (const Index t : tissue.tets_at(triangle[0])) {
    for (Index f = 0; f < 4; ++f) {
      const TetFace face{t, f};
      const Triangle corners = corners_of(tissue, face);
      if (!std::is_permutation(corners.begin(), corners.end(), triangle.begin())) {
        continue;
      }
      if (!is_bare(tissue, face)) {
        throw InvalidArgument(name_of(triangle) +
                              " lies between two tetrahedra; a wall must be of the surface");
      }
      return face;
    }
  }
  throw InvalidArgument(name_of(triangle) + " is no face of living tissue");
}

// Free edges, one after the other, as rims. Each is a fan of triangles, wound against it.
struct Caps {
  std::vector<Triangle> triangles;
  std::vector<Index> ends;
};

Caps caps_over(std::vector<FaceEdge> edges) {
  std::ranges::stable_sort(edges, {}, &FaceEdge::from);
  std::vector<bool> is_taken(edges.size(), false);
  Caps caps;
  for (std::size_t first = 0; first < edges.size(); ++first) {
    if (is_taken[first]) {
      continue;
    }
    const Index start = edges[first].from;
    std::size_t at = first;
    while (true) {
      is_taken[at] = true;
      const Index from = edges[at].from, to = edges[at].to;
      if (to == start) {
        break;
      }
      if (from != start) {
        caps.triangles.push_back({start, to, from});
      }
      const auto next = std::ranges::lower_bound(edges, to, {}, &FaceEdge::from);
      at = static_cast<std::size_t>(next - edges.begin());
      while (is_taken[at]) {  // as many edges of a rim leave a vertex as come to it
        ++at;
      }
    }
    caps.ends.push_back(static_cast<Index>(caps.triangles.size()));
  }
  return caps;
}

// New tetrahedra of an edit, by the tetrahedra whose place they take.
std::vector<std::pair<Index, Index>> children_of(const TissueChange& change) {
  std::vector<std::pair<Index, Index>> children;
  for (const NewTet& made : change.edit.new_tets) {
    children.emplace_back(made.parent, change.first_new_tet + static_cast<Index>(children.size()));
  }
  std::ranges::sort(children);
  return children;
}

// Adds the faces that lie on that of a divided tetrahedron: those all of whose corners are the
// face's, copies of these, or lie between two of them.
void add_parts(const Tissue& tissue, const TissueChange& change,
               std::span<const std::pair<Index, Index>> children, const TetFace& parent,
               std::vector<TetFace>& faces) {
  const Triangle corners = corners_of(tissue, parent);
  const auto is_corner = [&](Index v) { return std::ranges::find(corners, v) != corners.end(); };
  const auto lies_on_it = [&](Index v) {
    const Index made = v - change.first_new_vertex;
    if (made < 0) {
      return is_corner(v);
    }
    const NewVertex& vertex = change.edit.new_vertices[made];
    return is_corner(vertex.first) && is_corner(vertex.second);
  };
  auto child = std::ranges::lower_bound(children, parent.tet, {}, &std::pair<Index, Index>::first);
  for (; child != children.end() && child->first == parent.tet; ++child) {
    for (Index f = 0; f < 4; ++f) {
      const TetFace face{child->second, f};
      if (std::ranges::all_of(corners_of(tissue, face), lies_on_it)) {
        faces.push_back(face);
      }
    }
  }
}

// What is left of a wall.
std::vector<TetFace> living(const Tissue& tissue, const TissueChange& change,
                            const std::vector<TetFace>& wall) {
  const std::vector<std::pair<Index, Index>> children = children_of(change);
  std::vector<TetFace> faces;
  for (const TetFace& face : wall) {
    if (tissue.is_tet_alive(face.tet)) {
      faces.push_back(face);
    } else {
      add_parts(tissue, change, children, face, faces);
    }
  }
  return faces;
}

bool changes(const TissueChange& change, const std::vector<TetFace>& wall) {
  const auto is_of_wall = [&](Index tet) {
    return std::ranges::binary_search(wall, tet, {}, &TetFace::tet);
  };
  return std::ranges::any_of(change.removed_tets, is_of_wall) ||
         std::ranges::any_of(change.reshaped_tets, is_of_wall, &ReshapedTet::tet);
}

}  // namespace

// Of a wall that may have holes.
Cavity::State Cavity::make_state(const Tissue& tissue, std::vector<TetFace> wall) {
  std::ranges::sort(wall, is_before);
  State state;
  for (const TetFace& face : wall) {
    const Triangle corners = corners_of(tissue, face);
    state.triangles.push_back({corners[0], corners[2], corners[1]});
  }
  std::vector<FaceEdge> rims = free_edges(tissue, wall);
  for (FaceEdge& edge : rims) {
    std::swap(edge.from, edge.to);  // as the triangles are wound
  }
  const Caps caps = caps_over(std::move(rims));
  state.triangles.insert(state.triangles.end(), caps.triangles.begin(), caps.triangles.end());
  for (const Index end : caps.ends) {
    state.hole_ends.push_back(static_cast<Index>(wall.size()) + end);
  }
  state.is_open = wall.empty() || !caps.ends.empty();
  state.origins = std::move(wall);
  for (const Triangle& triangle : state.triangles) {
    state.vertices.insert(state.vertices.end(), triangle.begin(), triangle.end());
  }
  std::ranges::sort(state.vertices);
  state.vertices.erase(std::unique(state.vertices.begin(), state.vertices.end()),
                       state.vertices.end());
  return state;
}

std::vector<std::vector<Triangle>> find_cavities(const Tissue& tissue, Index body) {
  std::vector<TetFace> seen;
  std::vector<std::vector<Triangle>> cavities;
  std::vector<TetFace> bare;
  for (const Index t : tissue.tets_of(body)) {
    for (Index f = 0; f < 4 && tissue.is_tet_alive(t); ++f) {
      if (is_bare(tissue, {t, f})) {
        bare.push_back({t, f});
      }
    }
  }
  while (!bare.empty()) {
    const std::vector<TetFace> surface = closed_surface(tissue, {bare.front()});
    if (enclosed_volume(tissue, surface) < 0) {
      std::vector<Triangle>& wall = cavities.emplace_back();
      for (const TetFace& face : surface) {
        const Triangle corners = corners_of(tissue, face);
        wall.push_back({corners[0], corners[2], corners[1]});
      }
    }
    std::vector<TetFace> rest;
    std::ranges::set_difference(bare, surface, std::back_inserter(rest), is_before);
    bare = std::move(rest);
  }
  return cavities;
}

Cavity::Cavity(const Tissue& tissue, std::span<const Triangle> wall) {
  std::vector<TetFace> faces;
  for (const Triangle& triangle : wall) {
    faces.push_back(face_of(tissue, triangle));
  }
  std::ranges::sort(faces, is_before);
  for (std::size_t i = 1; i < faces.size(); ++i) {
    if (!is_before(faces[i - 1], faces[i])) {
      throw InvalidArgument(name_of(corners_of(tissue, faces[i])) + " is in the wall twice");
    }
  }
  const std::vector<FaceEdge> open = free_edges(tissue, faces);
  if (!open.empty()) {
    throw InvalidArgument("the wall is open at edge " + std::to_string(open.front().from) + "-" +
                          std::to_string(open.front().to) + "; it must be closed");
  }
  if (!(enclosed_volume(tissue, faces) < 0)) {
    throw InvalidArgument("the wall of " + std::to_string(faces.size()) +
                          " triangles bounds no hollow; it must enclose what is not tissue");
  }
  state_ = make_state(tissue, std::move(faces));
  tissue.add_follower(*this, FollowerRank::view);
}

std::span<const Triangle> Cavity::caps(Index hole) const {
  check_id("hole", hole, state_.hole_ends.size());
  const Index first = hole == 0 ? wall_count() : state_.hole_ends[hole - 1];
  return triangles().subspan(static_cast<std::size_t>(first),
                             static_cast<std::size_t>(state_.hole_ends[hole] - first));
}

void Cavity::check(std::span<const Eigen::Vector3f> positions) const {
  for (const Triangle& triangle : state_.triangles) {
    for (const Index v : triangle) {
      if (static_cast<std::size_t>(v) >= positions.size()) {
        throw InvalidArgument("the wall has vertex " + std::to_string(v) + "; there are " +
                              std::to_string(positions.size()) + " positions");
      }
    }
  }
}

double Cavity::volume(std::span<const Eigen::Vector3f> positions) const {
  check(positions);
  double sum = 0;
  for (const Triangle& triangle : state_.triangles) {
    const auto way = [&](int i) -> Eigen::Vector3d {
      return (positions[triangle[i]] - positions[state_.triangles.front()[0]]).cast<double>();
    };
    sum += way(0).dot(way(1).cross(way(2)));
  }
  return sum / 6;
}

double Cavity::hole_area(std::span<const Eigen::Vector3f> positions) const {
  check(positions);
  double sum = 0;
  for (Index hole = 0; hole < hole_count(); ++hole) {
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    for (const Triangle& cap : caps(hole)) {
      const Eigen::Vector3d a = positions[cap[0]].cast<double>();
      area += (positions[cap[1]].cast<double>() - a).cross(positions[cap[2]].cast<double>() - a);
    }
    sum += area.norm() / 2;
  }
  return sum;
}

void Cavity::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  has_changed_ = changes(change, state_.origins);
  if (!has_changed_) {
    return;
  }
  std::vector<TetFace> wall = living(tissue, change, state_.origins);
  if (!state_.is_open) {
    std::vector<TetFace> closed = closed_surface(tissue, wall);
    if (enclosed_volume(tissue, closed) < 0) {
      wall = std::move(closed);
    }
  }
  before_ = std::exchange(state_, make_state(tissue, std::move(wall)));
  ++version_;
}

void Cavity::undo(const Tissue&, const TissueChange&) noexcept {
  if (std::exchange(has_changed_, false)) {
    state_ = std::move(before_);
    ++version_;
  }
}

void Cavity::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  std::vector<TetFace> wall = state_.origins;
  for (TetFace& face : wall) {
    face.tet = ids.tets[face.tet];
  }
  state_ = make_state(tissue, std::move(wall));
  has_changed_ = false;
  ++version_;
}

}  // namespace pbdsurg
