// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/smoothing.h"

#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/tet_shape.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

IndexLists find_neighbors(Index point_count, std::span<const Edge> edges) {
  IndexLists lists;
  lists.offsets.assign(static_cast<std::size_t>(point_count) + 1, 0);
  for (const auto& [a, b] : edges) {
    ++lists.offsets[a + 1];
    ++lists.offsets[b + 1];
  }
  for (Index v = 0; v < point_count; ++v) {
    lists.offsets[v + 1] += lists.offsets[v];
  }
  lists.entries.resize(2 * edges.size());
  std::vector<Index> next(lists.offsets.begin(), lists.offsets.end() - 1);
  for (const auto& [a, b] : edges) {
    lists.entries[next[a]++] = b;
    lists.entries[next[b]++] = a;
  }
  return lists;
}

// Each edge of a closed surface is met once in each direction.
std::vector<Edge> boundary_edges(std::span<const Tet> tets) {
  std::vector<Edge> edges;
  for (const BoundaryTriangle& triangle : find_boundary(tets)) {
    for (int i = 0; i < 3; ++i) {
      const Index a = triangle.vertices[i], b = triangle.vertices[(i + 1) % 3];
      if (a < b) {
        edges.push_back({a, b});
      }
    }
  }
  return edges;
}

class Smoother {
 public:
  Smoother(const ImplicitShape& shape, double spacing, std::span<Vector3d> points,
           std::span<const Tet> tets)
      : shape_(shape),
        spacing_(spacing),
        points_(points),
        tets_(tets),
        stars_(find_vertex_tets(static_cast<Index>(points.size()), tets)),
        neighbors_(find_neighbors(static_cast<Index>(points.size()), find_edges(tets))),
        surface_neighbors_(
            find_neighbors(static_cast<Index>(points.size()), boundary_edges(tets))) {
    quality_.reserve(tets.size());
    for (const Tet& tet : tets) {
      quality_.push_back(quality(tet));
    }
  }

  void sweep() {
    for (Index v = 0; v < static_cast<Index>(points_.size()); ++v) {
      improve(v);
    }
  }

 private:
  [[nodiscard]] double quality(const Tet& tet) const {
    return min_squared_sine({points_[tet[0]], points_[tet[1]], points_[tet[2]], points_[tet[3]]});
  }

  [[nodiscard]] Vector3d mean(std::span<const Index> ids) const {
    Vector3d sum = Vector3d::Zero();
    for (const Index v : ids) {
      sum += points_[v];
    }
    return sum / static_cast<double>(ids.size());
  }

  void improve(Index v) {
    const double worst = worst_around(v);
    const bool on_surface = !surface_neighbors_[v].empty();
    const Vector3d start = points_[v];
    const Vector3d step = on_surface ? Vector3d(0.7 * (mean(surface_neighbors_[v]) - start))
                                     : Vector3d(mean(neighbors_[v]) - start);
    for (const double part : {1.0, 0.4, 0.16}) {
      if (try_move(v, start + part * step, worst)) {
        return;
      }
    }
    probe(v, worst);
  }

  // Where the mean of the neighbours is no help and angles are poor: small steps along the axes, as
  // long as they help.
  void probe(Index v, double worst) {
    constexpr double kPoor = 0.5 * 0.5;  // squared sine of 30 degrees
    for (double length = 0.08 * spacing_; length > 0.01 * spacing_; length *= 0.5) {
      for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
          if (worst < kPoor &&
              try_move(v, points_[v] + sign * length * Vector3d::Unit(axis), worst)) {
            worst = worst_around(v);
          }
        }
      }
    }
  }

  [[nodiscard]] double worst_around(Index v) const {
    double worst = std::numeric_limits<double>::infinity();
    for (const Index t : stars_[v]) {
      worst = std::min(worst, quality_[t]);
    }
    return worst;
  }

  // Moves a point if all tetrahedra around it then beat `worst`; else leaves everything as it was.
  bool try_move(Index v, const Vector3d& target, double worst) {
    const Vector3d start = points_[v];
    const bool on_surface = !surface_neighbors_[v].empty();
    points_[v] = on_surface ? shape_.project(target, 0.5 * spacing_) : target;
    const std::span<const Index> star = stars_[v];
    new_quality_.clear();
    for (const Index t : star) {
      new_quality_.push_back(quality(tets_[t]));
      if (!(new_quality_.back() > worst)) {
        points_[v] = start;
        return false;
      }
    }
    for (std::size_t i = 0; i < star.size(); ++i) {
      quality_[star[i]] = new_quality_[i];
    }
    return true;
  }

  const ImplicitShape& shape_;
  double spacing_;
  std::span<Vector3d> points_;
  std::span<const Tet> tets_;
  IndexLists stars_;
  IndexLists neighbors_;
  IndexLists surface_neighbors_;  // empty for interior points
  std::vector<double> quality_;   // [tet_count] squared sine of the worst angle
  std::vector<double> new_quality_;
};

}  // namespace

void smooth(const ImplicitShape& shape, double spacing, int sweeps, std::span<Vector3d> points,
            std::span<const Tet> tets) {
  Smoother smoother(shape, spacing, points, tets);
  for (int i = 0; i < sweeps; ++i) {
    smoother.sweep();
  }
}

}  // namespace pbdsurg
