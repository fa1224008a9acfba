// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/region_conductances.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pbdsurg/mesh/topology.h"

#include "lib/heat/triangle_coefficients.h"

namespace pbdsurg {
namespace {

constexpr double kLeastShare = 0.1;  // of an element's volume at rest

// As ThermalMesh::edge_coefficients(), of a tetrahedron that may be flat, inverted or a point:
// gradients are inward area vectors of faces over three volumes, so that with any volume > 0 the
// sums remain those of a positive semidefinite matrix, which is zero for uniform potentials.
std::array<double, 6> current_coefficients(std::span<const Eigen::Vector3f> positions,
                                           const Tet& tet, double rest_volume) {
  std::array<Eigen::Vector3d, 4> x;
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = positions[tet[i]].cast<double>();
  }
  std::array<Eigen::Vector3d, 4> areas;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [a, b, c] = kTetTriangles[i];
    areas[i] = 0.5 * (x[b] - x[a]).cross(x[c] - x[a]);
  }
  const double volume = std::abs((x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0])) / 6;
  double longest = 0;
  for (const auto& [a, b] : kTetEdges) {
    longest = std::max(longest, (x[a] - x[b]).norm());
  }
  const double counted = std::max(
      {volume, kLeastShare * rest_volume, ThermalMesh::kLeastVolume * longest * longest * longest});
  std::array<double, 6> coefficients{};
  if (!(longest > 0)) {
    return coefficients;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [a, b] = kTetEdges[k];
    coefficients[k] = -areas[a].dot(areas[b]) / (9 * counted);
  }
  return coefficients;
}

// The same of a triangle, which may be a line or a point. A stretched sheet does not get thinner.
std::array<double, 6> current_coefficients(std::span<const Eigen::Vector3f> positions,
                                           const Triangle& triangle, double thickness,
                                           double rest_area) {
  std::array<Eigen::Vector3d, 3> x;
  double longest = 0;  // squared
  for (std::size_t i = 0; i < 3; ++i) {
    x[i] = positions[triangle[i]].cast<double>();
    longest =
        std::max(longest, (x[i] - positions[triangle[(i + 1) % 3]].cast<double>()).squaredNorm());
  }
  const double area = (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
  return triangle_coefficients(
      x, thickness, std::max({area, kLeastShare * rest_area, ThermalMesh::kLeastVolume * longest}));
}

std::array<double, 6> current_coefficients(const ThermalMesh& mesh, Index element,
                                           std::span<const Eigen::Vector3f> positions) {
  if (!is_triangle(element)) {
    return current_coefficients(positions, mesh.tets()[element], mesh.volume(element));
  }
  const Tissue& tissue = mesh.tissue();
  const Index triangle = triangle_of_element(element);
  const double thickness = tissue.body(tissue.body_of_triangle(triangle)).thickness;
  return current_coefficients(positions, tissue.triangles()[triangle], thickness,
                              mesh.volume(element) / thickness);
}

}  // namespace

// Of the i-th element.
void RegionConductances::use(const Source& source, std::size_t i, bool is_on_device) {
  const double conductivity = source.conductivities[i];
  used_[i] = conductivity;
  if (conductivity == 0) {
    values_[i] = {};  // wherever its corners may be now
    return;
  }
  const Index element = source.region.elements[i];
  values_[i] = source.positions.empty()
                   ? source.mesh.edge_coefficients(element)
                   : current_coefficients(source.mesh, element, source.positions);
  for (double& value : values_[i]) {
    value *= is_on_device ? 1 : conductivity;
  }
}

void RegionConductances::set(const Source& source, const Takers& takers) {
  const std::size_t count = source.region.elements.size();
  used_.resize(count);
  values_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    use(source, i, takers.device != nullptr);
  }
  used_positions_.resize(source.positions.empty() ? 0 : source.region.vertices.size());
  for (std::size_t row = 0; row < used_positions_.size(); ++row) {
    used_positions_[row] = source.positions[source.region.vertices[row]];
  }
  if (takers.device != nullptr) {
    takers.device->set_conductances(values_);
  } else {
    takers.system.set_couplings(values_);
  }
}

bool RegionConductances::update(const Source& source, double most_change, double most_move,
                                bool is_due, const Takers& takers) {
  if (has_moved(source, most_move)) {
    set(source, takers);
    return true;
  }
  const std::size_t count = used_.size();
  for (std::size_t i = 0; i < count && !is_due; ++i) {
    const double now = source.conductivities[i];
    is_due = (now == 0) != (used_[i] == 0) || std::abs(now - used_[i]) > most_change * used_[i];
  }
  if (!is_due) {
    return false;
  }
  if (takers.device != nullptr) {
    std::ranges::copy(source.conductivities, used_.begin());
    return true;
  }
  changed_rows_.clear();
  is_changed_.assign(source.region.vertices.size(), 0);
  for (std::size_t i = 0; i < count; ++i) {
    if (source.conductivities[i] == used_[i]) {
      continue;
    }
    use(source, i, false);
    for (const Index row : source.region.corners[i]) {
      if (is_changed_[row] == 0) {
        is_changed_[row] = 1;
        changed_rows_.push_back(row);
      }
    }
  }
  takers.system.update_couplings(values_, changed_rows_);
  return true;
}

bool RegionConductances::has_moved(const Source& source, double most) const {
  if (source.positions.empty()) {
    return !used_positions_.empty();
  }
  if (used_positions_.empty()) {
    return true;
  }
  const auto most_squared = static_cast<float>(most * most);
  for (std::size_t row = 0; row < used_positions_.size(); ++row) {
    const Index v = source.region.vertices[row];
    const float squared = (source.positions[v] - used_positions_[row]).squaredNorm();
    if (squared > most_squared && source.mesh.has_tissue(v)) {
      return true;
    }
  }
  return false;
}

}  // namespace pbdsurg
