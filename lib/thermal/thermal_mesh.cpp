// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/thermal_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "pbdsurg/core/error.h"
#include "pbdsurg/edit/compaction.h"
#include "pbdsurg/mesh/topology.h"

#include "edit/renumbering.h"

namespace pbdsurg {
namespace {

constexpr char kWho[] = "a thermal mesh";  // in errors

}  // namespace

ThermalMesh::ThermalMesh(const TetMesh& mesh, const ThermalProperties& tissue)
    : ThermalMesh(mesh, std::span(&tissue, 1),
                  std::vector<Index>(static_cast<std::size_t>(mesh.tet_count()), 0)) {}

ThermalMesh::ThermalMesh(const TetMesh& mesh, std::span<const ThermalProperties> tissues,
                         std::span<const Index> tet_tissues)
    : tissues_(tissues.begin(), tissues.end()) {
  std::for_each(tissues.begin(), tissues.end(), check_thermal_properties);
  if (tet_tissues.size() != mesh.tets().size()) {
    throw InvalidArgument(std::to_string(tet_tissues.size()) + " tissues are given for " +
                          std::to_string(mesh.tet_count()) + " tets; one each");
  }
  for (std::size_t t = 0; t < tet_tissues.size(); ++t) {
    if (tet_tissues[t] < 0 || tet_tissues[t] >= static_cast<Index>(tissues.size())) {
      throw InvalidArgument("tet " + std::to_string(t) + " is of tissue " +
                            std::to_string(tet_tissues[t]) + "; there are " +
                            std::to_string(tissues.size()));
    }
  }
  resize(mesh.positions().size(), mesh.tets().size());
  add_body(mesh, 0, 0, 0);
  std::copy(tet_tissues.begin(), tet_tissues.end(), tet_tissues_.begin());
  for (Index t = mesh.tet_count() - 1; t >= 0; --t) {
    for (const Index v : tets_[t]) {
      vertex_tissues_[v] = tet_tissues_[t];
    }
  }
  link_all();
}

ThermalMesh::ThermalMesh(const Solver& solver, std::span<const ThermalBody> bodies)
    : followed_(solver) {
  Index body_vertices = 0, body_tets = 0;  // that came with bodies
  for (const Body& body : solver.bodies()) {
    body_vertices += body.vertex_count;
    body_tets += body.tet_count;
  }
  if (solver.vertex_count() > body_vertices ||
      static_cast<Index>(solver.tets().size()) > body_tets) {
    throw InvalidArgument("edits have split tissue; a thermal mesh must be made before");
  }
  resize(static_cast<std::size_t>(solver.vertex_count()), solver.tets().size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const ThermalBody& entry = bodies[i];
    const Body& body = solver.body(entry.body);
    if (std::any_of(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](const ThermalBody& other) { return other.body == entry.body; })) {
      throw InvalidArgument("body '" + body.name + "' is given twice");
    }
    if (entry.mesh == nullptr) {
      throw InvalidArgument("no mesh is given for body '" + body.name + "'");
    }
    if (entry.mesh->vertex_count() != body.vertex_count ||
        entry.mesh->tet_count() != body.tet_count) {
      throw InvalidArgument("the mesh given for body '" + body.name + "' has " +
                            std::to_string(entry.mesh->tet_count()) + " tets; the body has " +
                            std::to_string(body.tet_count));
    }
    check_thermal_properties(entry.tissue);
    add_body(*entry.mesh, body.first_vertex, body.first_tet, static_cast<Index>(tissues_.size()));
    tissues_.push_back(entry.tissue);
  }
  for (Index t = 0; t < tet_count(); ++t) {
    alive_[t] = alive_[t] != 0 && solver.is_tet_alive(t) ? 1 : 0;
  }
  link_all();
}

void ThermalMesh::set_tissue(const ThermalProperties& tissue) {
  check_thermal_properties(tissue);
  std::fill(tissues_.begin(), tissues_.end(), tissue);
}

void ThermalMesh::add_body(const TetMesh& mesh, Index first_vertex, Index first_tet, Index tissue) {
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    points_[first_vertex + v] = mesh.positions()[v];
    vertex_tissues_[first_vertex + v] = tissue;
  }
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    Tet& tet = tets_[first_tet + t] = mesh.tets()[t];
    for (Index& v : tet) {
      v += first_vertex;
    }
    tet_tissues_[first_tet + t] = tissue;
    alive_[first_tet + t] = 1;
    measure(first_tet + t);
  }
}

void ThermalMesh::resize(std::size_t vertex_count, std::size_t tet_count) {
  points_.resize(vertex_count, Eigen::Vector3d::Zero());
  vertex_tissues_.resize(vertex_count, kInvalidIndex);
  first_corners_.resize(vertex_count, kInvalidIndex);
  touched_at_.resize(vertex_count);
  tets_.resize(tet_count);
  alive_.resize(tet_count);
  tet_tissues_.resize(tet_count, kInvalidIndex);
  volumes_.resize(tet_count);
  coefficients_.resize(tet_count);
  next_corners_.resize(tet_count);
}

double ThermalMesh::longest_edge(Index tet) const noexcept {
  double longest = 0;
  for (const auto& [a, b] : kTetEdges) {
    longest = std::max(longest, (points_[tets_[tet][a]] - points_[tets_[tet][b]]).norm());
  }
  return longest;
}

// Of a tetrahedron whose volume is measured.
bool ThermalMesh::is_sliver(Index tet) const noexcept {
  const double longest = longest_edge(tet);
  return !(longest > 0) || volumes_[tet] / (longest * longest * longest) < kLeastVolume;
}

// Gradients are inward area vectors of the faces over three volumes. Scaled areas and lengths keep
// the arithmetic away from underflow for the smallest of slivers.
void ThermalMesh::measure(Index tet) noexcept {
  const Tet& v = tets_[tet];
  const double longest = longest_edge(tet);
  volumes_[tet] = std::max(tet_volume(points_, v), 0.0);
  coefficients_[tet] = {};
  sliver_count_ += is_sliver(tet) ? 1 : 0;
  if (!(longest > 0)) {
    return;
  }
  std::array<Eigen::Vector3d, 4> areas;  // doubled, over longest^2
  for (int i = 0; i < 4; ++i) {
    const auto& [a, b, c] = kTetTriangles[i];
    areas[i] = ((points_[v[c]] - points_[v[a]]) / longest)
                   .cross((points_[v[b]] - points_[v[a]]) / longest);
  }
  const double volume = volumes_[tet] / (longest * longest * longest);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto& [i, j] = kTetEdges[e];
    coefficients_[tet][e] =
        -longest * areas[i].dot(areas[j]) / (36 * std::max(volume, kLeastVolume));
  }
}

// Backwards: each tetrahedron goes to the fronts of lists that then ascend.
void ThermalMesh::link_all() {
  for (Index t = tet_count() - 1; t >= 0; --t) {
    for (Index k = 0; k < 4 && tet_tissues_[t] != kInvalidIndex; ++k) {
      next_corners_[t][k] = first_corners_[tets_[t][k]];
      first_corners_[tets_[t][k]] = 4 * t + k;
    }
  }
}

void ThermalMesh::link(Index corner) noexcept {
  Index* place = &first_corners_[tets_[corner / 4][corner % 4]];
  while (*place != kInvalidIndex && *place < corner) {
    place = &next_corners_[*place / 4][*place % 4];
  }
  next_corners_[corner / 4][corner % 4] = *place;
  *place = corner;
}

void ThermalMesh::unlink(Index corner) noexcept {
  Index* place = &first_corners_[tets_[corner / 4][corner % 4]];
  while (*place != corner) {
    place = &next_corners_[*place / 4][*place % 4];
  }
  *place = next_corners_[corner / 4][corner % 4];
}

void ThermalMesh::move_corner(Index tet, Index from, Index to) noexcept {
  for (Index k = 0; k < 4; ++k) {
    if (tets_[tet][k] == from) {
      unlink(4 * tet + k);
      tets_[tet][k] = to;
      link(4 * tet + k);
      return;
    }
  }
}

void ThermalMesh::touch(Index tet) {
  for (const Index v : tets_[tet]) {
    if (touched_at_[v] != change_) {
      touched_at_[v] = change_;
      touched_.push_back(v);
    }
  }
}

double ThermalMesh::volume_share(Index vertex) const noexcept {
  double sum = 0;
  for_each_tet(vertex, [&](Index t) { sum += volumes_[t] / 4; });
  return sum;
}

double ThermalMesh::mass(Index vertex) const noexcept {
  double sum = 0;
  for_each_tet(vertex,
               [&](Index t) { sum += tissues_[tet_tissues_[t]].density * volumes_[t] / 4; });
  return sum;
}

bool ThermalMesh::has_tissue(Index vertex) const noexcept {
  Index corner = first_corners_[vertex];
  while (corner != kInvalidIndex && !is_alive(corner / 4)) {
    corner = next_corners_[corner / 4][corner % 4];
  }
  return corner != kInvalidIndex;
}

double ThermalMesh::surface_share(Index vertex) const noexcept {
  // two corners of a face at the vertex, and the tetrahedra that have all three
  const auto sharing = [&](Index a, Index b) {
    int count = 0;
    for_each_tet(vertex, [&](Index t) {
      const Tet& tet = tets_[t];
      count += std::count(tet.begin(), tet.end(), a) + std::count(tet.begin(), tet.end(), b) == 2;
    });
    return count;
  };
  double area = 0;
  for_each_corner(vertex, [&](Index t, int k) {
    for (int opposite = 0; opposite < 4; ++opposite) {
      if (opposite == k) {
        continue;
      }
      std::array<Index, 2> others;
      int count = 0;
      for (const int corner : kTetTriangles[opposite]) {
        if (corner != k) {
          others[count++] = tets_[t][corner];
        }
      }
      if (sharing(others[0], others[1]) == 1) {
        area += (points_[others[0]] - points_[vertex])
                    .cross(points_[others[1]] - points_[vertex])
                    .norm() /
                6;
      }
    }
  });
  return area;
}

void ThermalMesh::validate(const Solver& solver, const TopologyEdit&) const {
  followed_.check(solver, kWho);
}

// Of tetrahedra that conduct, against those of the solver that they become.
void ThermalMesh::check_corners(const Solver& solver, const Renumbering& ids) const {
  for (Index t = 0; t < tet_count(); ++t) {
    const Index id = ids.tets[t];
    if (!is_alive(t)) {
      continue;
    }
    if (id == kInvalidIndex) {
      throw InvalidArgument("tet " + std::to_string(t) + " of " + kWho +
                            " lives, and does not after the compaction, which is of another "
                            "solver");
    }
    for (std::size_t k = 0; k < 4; ++k) {
      if (solver.tets()[id][k] != ids.vertices[tets_[t][k]]) {
        throw InvalidArgument("tet " + std::to_string(t) + " of " + kWho + " has corner " +
                              std::to_string(tets_[t][k]) +
                              ", and another after the compaction, which is of another solver");
      }
    }
  }
}

void ThermalMesh::renumber(const Solver& solver, const Renumbering& ids) {
  FollowedVersion followed = followed_;
  followed.renumber(solver, ids, kWho);
  check_map_size(kWho, "vertices", ids.vertices, points_.size());
  check_map_size(kWho, "tets", ids.tets, tets_.size());
  check_corners(solver, ids);
  followed_ = followed;

  const auto vertices = static_cast<std::size_t>(solver.vertex_count());
  const std::size_t tets = solver.tets().size();
  renumber_values(points_, ids.vertices, vertices);
  renumber_values(vertex_tissues_, ids.vertices, vertices);
  tets_ = moved<Tet>(ids.tets, tets,
                     [&](Index t) { return is_alive(t) ? solver.tets()[ids.tets[t]] : Tet{}; });
  renumber_values(alive_, ids.tets, tets);
  renumber_values(tet_tissues_, ids.tets, tets);
  renumber_values(volumes_, ids.tets, tets);
  renumber_values(coefficients_, ids.tets, tets);
  first_corners_.assign(vertices, kInvalidIndex);
  next_corners_.resize(tets);
  link_all();
  sliver_count_ = 0;
  for (Index t = 0; t < tet_count(); ++t) {
    sliver_count_ += is_alive(t) && is_sliver(t) ? 1 : 0;
  }
  touched_.clear();
  touched_at_.assign(vertices, 0);
  ++change_;
  version_ = ++newest_version_;
  ++growth_;
  ++renumberings_;
}

void ThermalMesh::apply(const Solver&, const TopologyEdit& edit,
                        const EditResult& result) noexcept {
  followed_.apply(result);
  ++change_;
  version_before_ = version_;
  touched_.clear();
  vertices_before_ = points_.size();
  tets_before_ = tets_.size();
  slivers_before_ = sliver_count_;
  const Scene& bodies = edit.new_bodies;  // which have no tissue here
  if (!edit.new_vertices.empty() || !edit.new_tets.empty() || !bodies.bodies().empty()) {
    resize(static_cast<std::size_t>(result.first_new_vertex) + edit.new_vertices.size() +
               static_cast<std::size_t>(bodies.vertex_count()),
           static_cast<std::size_t>(result.first_new_tet) + edit.new_tets.size() +
               bodies.tets().size());
  }
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    const NewVertex& added = edit.new_vertices[i];
    const std::size_t v = static_cast<std::size_t>(result.first_new_vertex) + i;
    vertex_tissues_[v] = vertex_tissues_[added.first];
    points_[v] =
        added.first == added.second
            ? points_[added.first]
            : Eigen::Vector3d((1 - static_cast<double>(added.share)) * points_[added.first] +
                              added.share * points_[added.second]);
  }
  for (const Index t : result.tets) {
    if (is_alive(t)) {
      touch(t);
      alive_[t] = 0;
    }
  }
  bool grows = false;
  for (const CornerMove& move : edit.corner_moves) {
    if (is_alive(move.tet)) {
      grows = true;
      touch(move.tet);
      move_corner(move.tet, move.from, move.to);
      touch(move.tet);
    }
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const NewTet& added = edit.new_tets[i];
    const Index t = result.first_new_tet + static_cast<Index>(i);
    tets_[t] = added.vertices;
    tet_tissues_[t] = tet_tissues_[added.parent];
    if (tet_tissues_[t] != kInvalidIndex) {
      grows = true;
      alive_[t] = 1;
      measure(t);
      for (Index k = 0; k < 4; ++k) {
        link(4 * t + k);
      }
      touch(t);
    }
  }
  if (!touched_.empty()) {
    version_ = ++newest_version_;
  }
  growth_ += grows ? 1 : 0;
}

void ThermalMesh::undo(const Solver&, const TopologyEdit& edit, const EditResult& result) noexcept {
  followed_.undo();
  ++change_;
  version_ = version_before_;
  touched_.clear();
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const Index t = result.first_new_tet + static_cast<Index>(i);
    if (is_alive(t)) {
      touch(t);
      for (Index k = 0; k < 4; ++k) {
        unlink(4 * t + k);
      }
    }
  }
  for (auto move = edit.corner_moves.rbegin(); move != edit.corner_moves.rend(); ++move) {
    if (is_alive(move->tet)) {
      touch(move->tet);
      move_corner(move->tet, move->to, move->from);
      touch(move->tet);
    }
  }
  for (const Index t : result.tets) {
    if (tet_tissues_[t] != kInvalidIndex) {
      alive_[t] = 1;
      touch(t);
    }
  }
  growth_ += touched_.empty() ? 0 : 1;
  resize(vertices_before_, tets_before_);
  sliver_count_ = slivers_before_;
  std::erase_if(touched_, [&](Index v) { return v >= vertex_count(); });
}

}  // namespace pbdsurg
