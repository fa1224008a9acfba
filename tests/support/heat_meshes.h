// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Boxes for tests of heat, and how to set, heat and compare fields in them.

#include <array>
#include <functional>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// A box whose inner vertices alone are displaced, so that its faces stay plane.
inline TetMesh make_jittered_box(std::array<Index, 3> cells, double edge, double jitter) {
  const TetMesh regular = make_box(cells, edge);
  std::vector<Eigen::Vector3d> points(regular.positions().begin(), regular.positions().end());
  for (std::size_t v = 0; v < points.size(); ++v) {
    bool is_inner = true;
    for (int axis = 0; axis < 3; ++axis) {
      is_inner =
          is_inner && points[v][axis] > 0.5 * edge && points[v][axis] < (cells[axis] - 0.5) * edge;
    }
    for (int axis = 0; axis < 3 && is_inner; ++axis) {
      points[v][axis] += jitter * edge * (2 * random_unit(7, v, axis) - 1);
    }
  }
  return {points, {regular.tets().begin(), regular.tets().end()}};
}

using Where = std::function<bool(const Eigen::Vector3d&)>;

inline std::vector<Index> vertices_where(const TetMesh& mesh, const Where& where) {
  std::vector<Index> found;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (where(mesh.positions()[v])) {
      found.push_back(v);
    }
  }
  return found;
}

using Profile = std::function<double(const Eigen::Vector3d&)>;

/// Sets the temperature of some vertices. @param profile  degrees Celsius
inline void set_profile(HeatField& field, const std::vector<Index>& vertices,
                        const Profile& profile) {
  std::vector<double> temperatures;
  for (const Index v : vertices) {
    temperatures.push_back(profile(field.mesh().rest_positions()[v]));
  }
  field.set_temperatures(vertices, temperatures);
}

/// The largest deviation from a profile, K.
inline double largest_error(const HeatField& field, const Profile& profile) {
  double largest = 0;
  for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
    largest = std::max(
        largest, std::abs(field.temperatures()[v] - profile(field.mesh().rest_positions()[v])));
  }
  return largest;
}

/// Root of the mean square of that, by mass, K.
inline double mean_error(const HeatField& field, const Profile& profile) {
  double sum = 0, mass = 0;
  for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
    const double error = field.temperatures()[v] - profile(field.mesh().rest_positions()[v]);
    sum += field.mesh().mass(v) * error * error;
    mass += field.mesh().mass(v);
  }
  return std::sqrt(sum / mass);
}

/// Power that heats a part of the surface evenly.
/// @param where  holds for all corners of its triangles
/// @param flux   W/m^2
inline std::vector<HeatSource> heat_face(const TetMesh& mesh, const Where& where, double flux) {
  std::vector<double> powers(mesh.positions().size(), 0.0);
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
    const auto [a, b, c] = triangle.vertices;
    const auto& x = mesh.positions();
    if (where(x[a]) && where(x[b]) && where(x[c])) {
      for (const Index v : triangle.vertices) {
        powers[v] += flux * (x[b] - x[a]).cross(x[c] - x[a]).norm() / 6;
      }
    }
  }
  std::vector<HeatSource> sources;
  for (std::size_t v = 0; v < powers.size(); ++v) {
    if (powers[v] > 0) {
      sources.push_back({static_cast<Index>(v), powers[v]});
    }
  }
  return sources;
}

/// What the ledger says came in less what it says became of it, J.
inline double ledger_error(const HeatLedger& ledger) {
  return ledger.in - ledger.sensible - ledger.latent - ledger.removed - ledger.surface -
         ledger.perfusion;
}

}  // namespace pbdsurg::testing
