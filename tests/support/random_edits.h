// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random removals of tissue, on meshes of several kinds.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr double kEditEdge = 4e-3;  // m

struct SampleScene {
  std::string name;
  Scene scene;
};

/// A box whose cells of one cross section are left out but for the walls.
inline TetMesh make_tube(std::array<Index, 3> cells) {
  const TetMesh box = make_box(cells, kEditEdge);
  const Eigen::Vector3d end = kEditEdge * Eigen::Vector3d(cells[0], cells[1], cells[2]);
  std::vector<Tet> walls;
  for (const Tet& tet : box.tets()) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Index v : tet) {
      middle += box.positions()[v] / 4;
    }
    const auto is_inside = [&](int axis) {
      return middle[axis] > kEditEdge && middle[axis] < end[axis] - kEditEdge;
    };
    if (!is_inside(0) || !is_inside(1)) {
      walls.push_back(tet);
    }
  }
  std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
  std::vector<Index> ids(points.size(), kInvalidIndex);
  std::vector<Eigen::Vector3d> used;
  for (Tet& tet : walls) {
    for (Index& v : tet) {
      if (ids[v] == kInvalidIndex) {
        ids[v] = static_cast<Index>(used.size());
        used.push_back(points[v]);
      }
      v = ids[v];
    }
  }
  return TetMesh(std::move(used), std::move(walls));
}

/// A lattice, two bodies with links, a tube and an organ of the shape of an egg with a hollow.
/// Each is held at one end.
inline std::vector<SampleScene> make_sample_scenes() {
  std::vector<SampleScene> samples;
  const auto hold = [](Scene& scene) {
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEditEdge; });
  };
  samples.push_back({"lattice", {}});
  samples.back().scene.add_body("block", make_box({5, 4, 3}, kEditEdge, 0.1));
  hold(samples.back().scene);

  samples.push_back({"two bodies", {}});
  Scene& two = samples.back().scene;
  two.add_body("left", make_box({3, 3, 2}, kEditEdge, 0.1));
  two.add_body("right", make_box({2, 3, 3}, kEditEdge, 0.1, 2));
  for (Index v = 0; v < two.body(0).vertex_count; v += 3) {
    two.add_link({v, two.body(1).first_vertex + v, 1e-3F, {}});
  }
  hold(two);

  samples.push_back({"tube", {}});
  samples.back().scene.add_body("tube", make_tube({3, 3, 7}));
  hold(samples.back().scene);

  samples.push_back({"organ", {}});
  const ImplicitShape egg = shell_shape(ellipsoid_shape({0, 0, 0}, {0.02, 0.015, 0.012}), 0.005);
  TetrahedralizeOptions options;
  options.spacing = 4e-3;
  samples.back().scene.add_body("organ", tetrahedralize(egg, options).mesh);
  hold(samples.back().scene);
  return samples;
}

/// Removes up to `most` live tetrahedra: scattered, around one, or along a plane through it.
inline TopologyEdit random_removal(const Scene& scene, const Solver& solver, Index most,
                                   std::uint64_t seed) {
  std::vector<Index> live;
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
    if (solver.tissue().is_tet_alive(t)) {
      live.push_back(t);
    }
  }
  TopologyEdit edit;
  if (live.empty()) {
    return edit;
  }
  const auto place = [&](Index t) { return scene.positions()[scene.tets()[t][0]]; };
  const Eigen::Vector3d middle = place(live[random_bits(seed, 1) % live.size()]);
  const Eigen::Vector3d normal(random_unit(seed, 2, 0) - 0.5, random_unit(seed, 2, 1) - 0.5,
                               random_unit(seed, 2, 2) - 0.5);
  const auto pattern = random_bits(seed, 3) % 3;
  std::vector<std::pair<double, Index>> order;
  for (const Index t : live) {
    const Eigen::Vector3d away = place(t) - middle;
    order.emplace_back(pattern == 0   ? random_unit(seed, 4, static_cast<std::uint64_t>(t))
                       : pattern == 1 ? away.norm()
                                      : std::abs(normal.dot(away)),
                       t);
  }
  std::sort(order.begin(), order.end());
  order.resize(std::min(order.size(), 1 + random_bits(seed, 5) % most));
  for (const auto& [key, t] : order) {
    edit.remove_tets.push_back(t);
  }
  return edit;
}

}  // namespace pbdsurg::testing
