// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/thermal_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/heat/triangle_coefficients.h"
#include "lib/tissue/renumber.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// Tissue that is there for its topology alone.
std::shared_ptr<const Tissue> tissue_of(const TetMesh& mesh) {
  Scene scene;
  scene.add_body("body", mesh);
  return std::make_shared<const Tissue>(scene);
}

}  // namespace

ThermalMesh::ThermalMesh(const TetMesh& mesh, const ThermalProperties& properties)
    : ThermalMesh(mesh, std::span(&properties, 1),
                  std::vector<Index>(static_cast<std::size_t>(mesh.tet_count()), 0)) {}

ThermalMesh::ThermalMesh(const TetMesh& mesh, std::span<const ThermalProperties> layers,
                         std::span<const Index> tet_layers)
    : tissue_(tissue_of(mesh)), tissues_(layers.begin(), layers.end()) {
  std::for_each(layers.begin(), layers.end(), check_thermal_properties);
  if (tet_layers.size() != mesh.tets().size()) {
    throw InvalidArgument(std::to_string(tet_layers.size()) + " tissues are given for " +
                          std::to_string(mesh.tet_count()) + " tets; one each");
  }
  for (std::size_t t = 0; t < tet_layers.size(); ++t) {
    if (tet_layers[t] < 0 || tet_layers[t] >= static_cast<Index>(layers.size())) {
      throw InvalidArgument("tet " + std::to_string(t) + " is of tissue " +
                            std::to_string(tet_layers[t]) + "; there are " +
                            std::to_string(layers.size()));
    }
  }
  resize();
  std::vector<Index> vertex_layers(mesh.positions().size(), 0);
  for (Index t = mesh.tet_count() - 1; t >= 0; --t) {
    add_element(t, tet_layers[t]);
    for (const Index v : mesh.tets()[t]) {
      vertex_layers[v] = tet_layers[t];
    }
  }
  vertex_tissues_ = UndoArray(std::move(vertex_layers));
}

ThermalMesh::ThermalMesh(const Tissue& tissue, std::span<const ThermalBody> bodies)
    : tissue_(std::shared_ptr<const Tissue>(), &tissue), seen_version_(tissue.version()) {
  resize();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const ThermalBody& entry = bodies[i];
    const Body& body = tissue.body(entry.body);
    if (std::any_of(bodies.begin(), bodies.begin() + static_cast<std::ptrdiff_t>(i),
                    [&](const ThermalBody& other) { return other.body == entry.body; })) {
      throw InvalidArgument("body '" + body.name + "' is given twice");
    }
    check_thermal_properties(entry.properties);
    for (const Index v : tissue.vertices_of(entry.body)) {
      vertex_tissues_.set(v, static_cast<Index>(i));
    }
    for (const Index t : tissue.tets_of(entry.body)) {
      add_element(t, static_cast<Index>(i));
    }
    has_sheets_ = has_sheets_ || is_sheet(body);
    for (Index t = body.first_triangle; t < body.first_triangle + body.triangle_count; ++t) {
      add_element(element_of_triangle(t), static_cast<Index>(i));
    }
    tissues_.push_back(entry.properties);
  }
  tissue.add_follower(*this, FollowerRank::heat);
}

const Tissue& ThermalMesh::tissue() const {
  if (tissue_ == nullptr) {
    throw_moved_from("a thermal mesh");
  }
  return *tissue_;
}

void ThermalMesh::check_current(const char* who) const {
  if (tissue_ == nullptr) {
    throw_moved_from(who);
  }
  if (tet_count() != static_cast<Index>(tissue_->tets().size()) ||
      tissue_->version() != seen_version_) {
    throw InvalidArgument(std::string(who) + " is at topology version " +
                          std::to_string(seen_version_) + ", its tissue at " +
                          std::to_string(tissue_->version()) + ": copies do not follow edits");
  }
}

void ThermalMesh::set_tissue(const ThermalProperties& tissue) {
  check_thermal_properties(tissue);
  std::fill(tissues_.begin(), tissues_.end(), tissue);
}

void ThermalMesh::Elements::resize(std::size_t count) {
  tissues.resize(count, kInvalidIndex);
  volumes.resize(count, 0.0);
  coefficients.resize(count, {});
}

void ThermalMesh::Elements::begin_edit() {
  tissues.begin_edit();
  volumes.begin_edit();
  coefficients.begin_edit();
}

void ThermalMesh::Elements::undo() {
  tissues.undo();
  volumes.undo();
  coefficients.undo();
}

void ThermalMesh::resize() {
  const auto vertices = static_cast<std::size_t>(tissue_->vertex_count());
  vertex_tissues_.resize(vertices, kInvalidIndex);
  touched_at_.resize(vertices);
  tets_.resize(tissue_->tets().size());
  triangles_.resize(tissue_->triangles().size());
}

double ThermalMesh::longest_edge(Index element) const noexcept {
  const std::span<const Eigen::Vector3d> points = rest_positions();
  double longest = 0;
  for (const Index a : corners(element)) {
    for (const Index b : corners(element)) {
      longest = std::max(longest, (points[a] - points[b]).norm());
    }
  }
  return longest;
}

// Of an element whose volume is measured.
bool ThermalMesh::is_sliver(Index element) const noexcept {
  const double longest = longest_edge(element);
  if (!(longest > 0)) {
    return true;
  }
  return is_triangle(element)
             ? triangle_area(rest_positions(), tissue_->triangles()[place(element)]) /
                       (longest * longest) <
                   kLeastVolume
             : volume(element) / (longest * longest * longest) < kLeastVolume;
}

void ThermalMesh::add_element(Index element, Index tissue) noexcept {
  of(element).tissues.set(local(element), tissue);
  const double longest = longest_edge(element);
  if (is_triangle(element)) {
    measure_triangle(triangle_of_element(element), longest);
  } else {
    measure_tet(element, longest);
  }
  sliver_count_ += is_sliver(element) ? 1 : 0;
}

// Gradients are inward area vectors of the faces over three volumes. Scaled areas and lengths keep
// the arithmetic away from underflow for the smallest of slivers.
void ThermalMesh::measure_tet(Index tet, double longest) noexcept {
  const std::span<const Eigen::Vector3d> points = rest_positions();
  const Tet& v = tets()[tet];
  tets_.volumes.set(tet, std::max(tet_volume(points, v), 0.0));
  std::array<double, 6> coefficients{};
  if (!(longest > 0)) {
    tets_.coefficients.set(tet, coefficients);
    return;
  }
  std::array<Eigen::Vector3d, 4> areas;  // doubled, over longest^2
  for (int i = 0; i < 4; ++i) {
    const auto& [a, b, c] = kTetTriangles[i];
    areas[i] =
        ((points[v[c]] - points[v[a]]) / longest).cross((points[v[b]] - points[v[a]]) / longest);
  }
  const double volume = tets_.volumes[tet] / (longest * longest * longest);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto& [i, j] = kTetEdges[e];
    coefficients[e] = -longest * areas[i].dot(areas[j]) / (36 * std::max(volume, kLeastVolume));
  }
  tets_.coefficients.set(tet, coefficients);
}

void ThermalMesh::measure_triangle(Index triangle, double longest) noexcept {
  const std::span<const Eigen::Vector3d> points = rest_positions();
  const Triangle& v = tissue_->triangles()[static_cast<std::size_t>(triangle)];
  const double thickness = tissue_->body(tissue_->body_of_triangle(triangle)).thickness;
  const double area = triangle_area(points, v);
  triangles_.volumes.set(triangle, thickness * area);
  triangles_.coefficients.set(
      triangle, triangle_coefficients({points[v[0]], points[v[1]], points[v[2]]}, thickness,
                                      std::max(area, kLeastVolume * longest * longest)));
}

void ThermalMesh::touch(std::span<const Index> vertices) {
  for (const Index v : vertices) {
    if (v < vertex_count() && touched_at_[v] != change_) {
      touched_at_[v] = change_;
      touched_.push_back(v);
    }
  }
}

double ThermalMesh::volume_share(Index vertex) const noexcept {
  double sum = 0;
  for_each_element(vertex, [&](Index e) { sum += volume(e) / corner_count(e); });
  return sum;
}

double ThermalMesh::mass(Index vertex) const noexcept {
  double sum = 0;
  for_each_element(vertex, [&](Index e) {
    sum += tissues_[tissue_of_element(e)].density * volume(e) / corner_count(e);
  });
  return sum;
}

bool ThermalMesh::has_tissue(Index vertex) const noexcept {
  return vertex_tissues_[vertex] != kInvalidIndex &&
         (!tissue_->tets_at(vertex).empty() || !tissue_->triangles_at(vertex).empty());
}

double ThermalMesh::surface_share(Index vertex) const noexcept {
  // two corners of a face at the vertex, and the tetrahedra that have all three
  const auto sharing = [&](Index a, Index b) {
    int count = 0;
    for_each_element(vertex, [&](Index t) {
      const Tet& tet = tets()[t];
      count += std::count(tet.begin(), tet.end(), a) + std::count(tet.begin(), tet.end(), b) == 2;
    });
    return count;
  };
  const std::span<const Eigen::Vector3d> points = rest_positions();
  double area = 0;
  for_each_corner(vertex, [&](Index t, int k) {
    if (is_triangle(t)) {
      area += 2 * triangle_area(points, tissue_->triangles()[place(t)]) / 3;
      return;
    }
    for (int opposite = 0; opposite < 4; ++opposite) {
      if (opposite == k) {
        continue;
      }
      std::array<Index, 2> others;
      int count = 0;
      for (const int corner : kTetTriangles[opposite]) {
        if (corner != k) {
          others[count++] = tets()[t][corner];
        }
      }
      if (sharing(others[0], others[1]) == 1) {
        area +=
            (points[others[0]] - points[vertex]).cross(points[others[1]] - points[vertex]).norm() /
            6;
      }
    }
  });
  return area;
}

void ThermalMesh::begin_change() {
  ++change_;
  touched_.clear();
  seen_version_ = tissue_->version();
}

void ThermalMesh::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  const auto move = [&](auto& array, const std::vector<Index>& map, std::size_t count) {
    using Value = std::decay_t<decltype(array[0])>;
    array = UndoArray(moved<Value>(map, count, [&](Index i) { return array[i]; }));
  };
  const auto move_all = [&](Elements& elements, const std::vector<Index>& map, std::size_t count) {
    move(elements.tissues, map, count);
    move(elements.volumes, map, count);
    move(elements.coefficients, map, count);
  };
  const auto vertices = static_cast<std::size_t>(tissue.vertex_count());
  move(vertex_tissues_, ids.vertices, vertices);
  move_all(tets_, ids.tets, tissue.tets().size());
  move_all(triangles_, ids.triangles, tissue.triangles().size());
  sliver_count_ = 0;
  const auto count = [&](Index element) {
    sliver_count_ += is_alive(element) && is_sliver(element) ? 1 : 0;
  };
  for (Index t = 0; t < tet_count(); ++t) {
    count(t);
  }
  for (Index t = 0; t < triangle_count(); ++t) {
    count(element_of_triangle(t));
  }
  touched_at_.assign(vertices, 0);
  begin_change();
  version_ = ++newest_version_;
  ++growth_;
}

void ThermalMesh::follow(const Tissue&, const TissueChange& change) noexcept {
  begin_change();
  version_before_ = version_;
  slivers_before_ = sliver_count_;
  vertex_tissues_.begin_edit();
  tets_.begin_edit();
  triangles_.begin_edit();
  resize();  // new bodies do not conduct
  const TopologyEdit& edit = change.edit;
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    vertex_tissues_.set(change.first_new_vertex + static_cast<Index>(i),
                        vertex_tissues_[edit.new_vertices[i].first]);
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const Index parent = edit.new_tets[i].parent;
    if (tets_.tissues[parent] != kInvalidIndex) {
      add_element(change.first_new_tet + static_cast<Index>(i), tets_.tissues[parent]);
    }
  }
  const bool grows = touch_changed(change);
  if (!touched_.empty()) {
    version_ = ++newest_version_;
  }
  growth_ += grows ? 1 : 0;
}

// Vertices of all that went, came or moved, as they were and as they are.
// @return  whether any came or moved
bool ThermalMesh::touch_changed(const TissueChange& change) {
  const TopologyEdit& edit = change.edit;
  bool grows = false;
  for (const Index t : change.removed_tets) {
    if (tets_.tissues[t] != kInvalidIndex) {
      touch(tets()[t]);
    }
  }
  for (const Index t : change.removed_triangles) {
    if (triangles_.tissues[t] != kInvalidIndex) {
      touch(tissue_->triangles()[t]);
    }
  }
  for (std::size_t i = 0; i < edit.corner_moves.size(); ++i) {
    const CornerMove& move = edit.corner_moves[i];
    if (tets_.tissues[move.tet] != kInvalidIndex) {
      grows = true;
      touch(change.reshaped_tets[i].vertices);
      touch(std::array{move.from, move.to});
    }
  }
  for (const TriangleMove& move : edit.triangle_moves) {
    if (triangles_.tissues[move.triangle] != kInvalidIndex) {
      grows = true;
      touch(tissue_->triangles()[move.triangle]);
      touch(std::array{move.from, move.to});
    }
  }
  for (const NewTet& tet : edit.new_tets) {
    if (tets_.tissues[tet.parent] != kInvalidIndex) {
      grows = true;
      touch(tet.vertices);
    }
  }
  return grows;
}

void ThermalMesh::undo(const Tissue&, const TissueChange& change) noexcept {
  begin_change();
  version_ = version_before_;
  // in the order of the undo: sums over what is touched keep their bits
  for (const NewTet& tet : change.edit.new_tets) {
    if (tets_.tissues[tet.parent] != kInvalidIndex) {
      touch(tet.vertices);
    }
  }
  for (std::size_t i = change.edit.corner_moves.size(); i-- > 0;) {
    const CornerMove& move = change.edit.corner_moves[i];
    if (tets_.tissues[move.tet] != kInvalidIndex) {
      Tet after = change.reshaped_tets[i].vertices;
      std::ranges::replace(after, move.from, move.to);
      touch(after);
      touch(change.reshaped_tets[i].vertices);
    }
  }
  touch_changed(change);
  growth_ += touched_.empty() ? 0 : 1;
  vertex_tissues_.undo();
  tets_.undo();
  triangles_.undo();
  touched_at_.resize(static_cast<std::size_t>(vertex_count()));
  sliver_count_ = slivers_before_;
}

}  // namespace pbdsurg
