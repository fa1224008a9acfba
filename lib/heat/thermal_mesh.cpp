// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/thermal_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

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

Tet moved(Tet vertices, const CornerMove& move) {
  std::ranges::replace(vertices, move.from, move.to);
  return vertices;
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
    tet_tissues_.set(t, tet_layers[t]);
    measure(t);
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
    if (is_sheet(body)) {
      throw InvalidArgument("body '" + body.name +
                            "' is a sheet, which has no heat: only "
                            "tetrahedra do");
    }
    check_thermal_properties(entry.properties);
    for (const Index v : tissue.vertices_of(entry.body)) {
      vertex_tissues_.set(v, static_cast<Index>(i));
    }
    for (const Index t : tissue.tets_of(entry.body)) {
      tet_tissues_.set(t, static_cast<Index>(i));
      measure(t);
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
  if (volumes_.size() != static_cast<Index>(tissue_->tets().size()) ||
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

void ThermalMesh::resize() {
  const auto vertices = static_cast<std::size_t>(tissue_->vertex_count());
  const std::size_t tets = tissue_->tets().size();
  vertex_tissues_.resize(vertices, kInvalidIndex);
  touched_at_.resize(vertices);
  tet_tissues_.resize(tets, kInvalidIndex);
  volumes_.resize(tets, 0.0);
  coefficients_.resize(tets, {});
}

double ThermalMesh::longest_edge(Index tet) const noexcept {
  const std::span<const Eigen::Vector3d> points = rest_positions();
  const Tet& corners = tets()[tet];
  double longest = 0;
  for (const auto& [a, b] : kTetEdges) {
    longest = std::max(longest, (points[corners[a]] - points[corners[b]]).norm());
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
  const std::span<const Eigen::Vector3d> points = rest_positions();
  const Tet& v = tets()[tet];
  const double longest = longest_edge(tet);
  volumes_.set(tet, std::max(tet_volume(points, v), 0.0));
  std::array<double, 6> coefficients{};
  sliver_count_ += is_sliver(tet) ? 1 : 0;
  if (!(longest > 0)) {
    coefficients_.set(tet, coefficients);
    return;
  }
  std::array<Eigen::Vector3d, 4> areas;  // doubled, over longest^2
  for (int i = 0; i < 4; ++i) {
    const auto& [a, b, c] = kTetTriangles[i];
    areas[i] =
        ((points[v[c]] - points[v[a]]) / longest).cross((points[v[b]] - points[v[a]]) / longest);
  }
  const double volume = volumes_[tet] / (longest * longest * longest);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto& [i, j] = kTetEdges[e];
    coefficients[e] = -longest * areas[i].dot(areas[j]) / (36 * std::max(volume, kLeastVolume));
  }
  coefficients_.set(tet, coefficients);
}

void ThermalMesh::touch(const Tet& vertices) {
  for (const Index v : vertices) {
    if (v < vertex_count() && touched_at_[v] != change_) {
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
  return vertex_tissues_[vertex] != kInvalidIndex && !tissue_->tets_at(vertex).empty();
}

double ThermalMesh::surface_share(Index vertex) const noexcept {
  // two corners of a face at the vertex, and the tetrahedra that have all three
  const auto sharing = [&](Index a, Index b) {
    int count = 0;
    for_each_tet(vertex, [&](Index t) {
      const Tet& tet = tets()[t];
      count += std::count(tet.begin(), tet.end(), a) + std::count(tet.begin(), tet.end(), b) == 2;
    });
    return count;
  };
  const std::span<const Eigen::Vector3d> points = rest_positions();
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
  const auto vertices = static_cast<std::size_t>(tissue.vertex_count());
  move(vertex_tissues_, ids.vertices, vertices);
  move(tet_tissues_, ids.tets, tissue.tets().size());
  move(volumes_, ids.tets, tissue.tets().size());
  move(coefficients_, ids.tets, tissue.tets().size());
  sliver_count_ = 0;
  for (Index t = 0; t < tet_count(); ++t) {
    sliver_count_ += is_alive(t) && is_sliver(t) ? 1 : 0;
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
  tet_tissues_.begin_edit();
  volumes_.begin_edit();
  coefficients_.begin_edit();
  resize();  // new bodies do not conduct
  const TopologyEdit& edit = change.edit;
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    vertex_tissues_.set(change.first_new_vertex + static_cast<Index>(i),
                        vertex_tissues_[edit.new_vertices[i].first]);
  }
  for (const Index t : change.removed_tets) {
    if (tet_tissues_[t] != kInvalidIndex) {
      touch(tets()[t]);
    }
  }
  bool grows = false;
  for (std::size_t i = 0; i < edit.corner_moves.size(); ++i) {
    const CornerMove& move = edit.corner_moves[i];
    if (tet_tissues_[move.tet] != kInvalidIndex) {
      grows = true;
      touch(change.reshaped_tets[i].vertices);
      touch(moved(change.reshaped_tets[i].vertices, move));
    }
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const Index t = change.first_new_tet + static_cast<Index>(i);
    tet_tissues_.set(t, tet_tissues_[edit.new_tets[i].parent]);
    if (tet_tissues_[t] != kInvalidIndex) {
      grows = true;
      measure(t);
      touch(tets()[t]);
    }
  }
  if (!touched_.empty()) {
    version_ = ++newest_version_;
  }
  growth_ += grows ? 1 : 0;
}

void ThermalMesh::undo(const Tissue&, const TissueChange& change) noexcept {
  begin_change();
  const TopologyEdit& edit = change.edit;
  version_ = version_before_;
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    if (tet_tissues_[change.first_new_tet + static_cast<Index>(i)] != kInvalidIndex) {
      touch(edit.new_tets[i].vertices);
    }
  }
  for (std::size_t i = edit.corner_moves.size(); i-- > 0;) {
    const CornerMove& move = edit.corner_moves[i];
    if (tet_tissues_[move.tet] != kInvalidIndex) {
      touch(moved(change.reshaped_tets[i].vertices, move));
      touch(change.reshaped_tets[i].vertices);
    }
  }
  for (const Index t : change.removed_tets) {
    if (tet_tissues_[t] != kInvalidIndex) {
      touch(tets()[t]);
    }
  }
  growth_ += touched_.empty() ? 0 : 1;
  vertex_tissues_.undo();
  tet_tissues_.undo();
  volumes_.undo();
  coefficients_.undo();
  touched_at_.resize(static_cast<std::size_t>(vertex_count()));
  sliver_count_ = slivers_before_;
}

}  // namespace pbdsurg
