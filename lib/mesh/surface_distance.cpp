// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"
#include "lib/mesh/box_tree.h"
#include "lib/mesh/closest_on_triangle.h"
#include "lib/mesh/triangle_orientation.h"

namespace pbdsurg {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

struct Facet {
  Vector3d a, b, c;

  [[nodiscard]] Vector3d area_vector() const { return 0.5 * (b - a).cross(c - a); }
  [[nodiscard]] Vector3d centroid() const { return (a + b + c) / 3; }
};

// Solid angle over 4 pi (van Oosterom and Strackee 1983).
double winding_of(const Facet& f, const Vector3d& p) {
  const Vector3d a = f.a - p, b = f.b - p, c = f.c - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return numerator == 0 ? 0 : std::atan2(numerator, denominator) / (2 * std::numbers::pi);
}

}  // namespace

// One hierarchy serves both queries: boxes for distances, dipoles for winding numbers.
struct SurfaceDistance::Tree {
  static constexpr double kFarDistance = 2.5;  // in radii; less is coarser and faster

  // What the triangles of a node look like from afar.
  struct Dipole {
    Vector3d center = Vector3d::Zero();  // of area
    Vector3d area = Vector3d::Zero();    // sum of the area vectors
    double radius = 0;                   // around the centre
  };

  std::vector<Facet> facets;  // leaf by leaf
  BoxTree boxes;
  std::vector<Dipole> dipoles;  // of each node
  Index turned_triangles = 0;
  bool is_inside_out = false;

  void build() {
    std::vector<AlignedBox3d> facet_boxes;
    std::vector<Vector3d> centroids;
    for (const Facet& facet : facets) {
      facet_boxes.push_back(AlignedBox3d(facet.a).extend(facet.b).extend(facet.c));
      centroids.push_back(facet.centroid());
    }
    boxes = BoxTree(facet_boxes, centroids,
                    [&](std::span<const Index> members) { dipoles.push_back(summarize(members)); });
    std::vector<Facet> sorted;
    sorted.reserve(facets.size());
    for (const Index i : boxes.order()) {
      sorted.push_back(facets[i]);
    }
    facets = std::move(sorted);
  }

  [[nodiscard]] Dipole summarize(std::span<const Index> members) const {
    Dipole dipole;
    double total = 0;
    for (const Index i : members) {
      const Facet& facet = facets[i];
      const Vector3d area = facet.area_vector();
      dipole.area += area;
      dipole.center += area.norm() * facet.centroid();
      total += area.norm();
    }
    dipole.center /= total;
    double squared = 0;
    for (const Index i : members) {
      for (const Vector3d& corner : {facets[i].a, facets[i].b, facets[i].c}) {
        squared = std::max(squared, (corner - dipole.center).squaredNorm());
      }
    }
    dipole.radius = std::sqrt(squared);
    return dipole;
  }

  [[nodiscard]] Vector3d closest_point(const Vector3d& point) const {
    Vector3d best_point = facets[0].a;
    double best = (best_point - point).squaredNorm();
    const std::vector<BoxTree::Node>& nodes = boxes.nodes();
    std::array<std::pair<Index, double>, BoxTree::kMaxDepth> stack;
    int depth = 0;
    stack[depth++] = {0, nodes[0].box.squaredExteriorDistance(point)};
    while (depth > 0) {
      const auto [id, bound] = stack[--depth];
      if (bound >= best) {
        continue;
      }
      const BoxTree::Node& node = nodes[id];
      if (node.left != kInvalidIndex) {
        std::pair<Index, double> near{node.left,
                                      nodes[node.left].box.squaredExteriorDistance(point)};
        std::pair<Index, double> far{node.left + 1,
                                     nodes[node.left + 1].box.squaredExteriorDistance(point)};
        if (far.second < near.second) {
          std::swap(near, far);
        }
        stack[depth++] = far;
        stack[depth++] = near;
        continue;
      }
      for (Index i = node.first; i < node.first + node.count; ++i) {
        const Vector3d candidate =
            closest_on_triangle(facets[i].a, facets[i].b, facets[i].c, point).point;
        const double distance = (candidate - point).squaredNorm();
        if (distance < best) {
          best = distance;
          best_point = candidate;
        }
      }
    }
    return best_point;
  }

  [[nodiscard]] double winding_number(const Vector3d& point) const {
    double sum = 0;
    std::array<Index, BoxTree::kMaxDepth> stack;
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Index id = stack[--depth];
      const BoxTree::Node& node = boxes.nodes()[id];
      const Dipole& dipole = dipoles[id];
      const Vector3d to_center = dipole.center - point;
      const double far = kFarDistance * dipole.radius;
      const double squared = to_center.squaredNorm();
      if (squared > far * far) {
        sum += dipole.area.dot(to_center) / (4 * std::numbers::pi * squared * std::sqrt(squared));
      } else if (node.left != kInvalidIndex) {
        stack[depth++] = node.left + 1;
        stack[depth++] = node.left;
      } else {
        for (Index i = node.first; i < node.first + node.count; ++i) {
          sum += winding_of(facets[i], point);
        }
      }
    }
    return is_inside_out ? -sum : sum;
  }

  // Looks just behind and just before the triangles. Behind a closed surface the winding number
  // is 1 or more; before one that is inside out it is -1 or less.
  void find_inside() {
    constexpr std::size_t kMostSamples = 1000;
    const std::size_t stride = facets.size() / kMostSamples + 1;
    double total = 0, inside_behind = 0, inside_before = 0;
    double largest = 0;
    for (std::size_t i = 0; i < facets.size(); i += stride) {
      const Vector3d area_vector = facets[i].area_vector();
      const double area = area_vector.norm();
      const Vector3d step = 0.01 / std::sqrt(area) * area_vector;
      const double behind = winding_number(facets[i].centroid() - step);
      const double before = winding_number(facets[i].centroid() + step);
      total += area;
      inside_behind += behind > 0.75 ? area : 0;
      inside_before += before < -0.75 ? area : 0;
      largest = std::max({largest, behind, -before});
    }
    is_inside_out = inside_before > inside_behind;
    if (!(std::max(inside_behind, inside_before) >= 0.5 * total)) {
      throw InvalidMesh("the surface encloses nothing: its winding number is near 1 behind only " +
                        describe(100 * std::max(inside_behind, inside_before) / total) +
                        " % of its area (largest " + describe(largest) +
                        "); close it, or wind its triangles alike");
    }
  }
};

SurfaceDistance::SurfaceDistance(std::span<const Vector3d> points,
                                 std::span<const Triangle> triangles) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const Index v : triangles[t]) {
      if (v < 0 || static_cast<std::size_t>(v) >= points.size()) {
        throw InvalidMesh("triangle " + std::to_string(t) + " refers to vertex " +
                          std::to_string(v) + "; ids must be in [0, " +
                          std::to_string(points.size()) + ")");
      }
      if (!points[v].allFinite()) {
        throw InvalidMesh("vertex " + std::to_string(v) + " is at " + describe(points[v]) +
                          "; positions must be finite");
      }
    }
  }
  std::vector<Triangle> oriented(triangles.begin(), triangles.end());
  auto tree = std::make_shared<Tree>();
  tree->turned_triangles = orient_triangles(points, oriented);
  for (const auto& [a, b, c] : oriented) {
    const Facet facet{points[a], points[b], points[c]};
    if (facet.area_vector().squaredNorm() > 0) {
      tree->facets.push_back(facet);
    }
  }
  if (tree->facets.empty()) {
    throw InvalidMesh("the surface encloses nothing: none of its " +
                      std::to_string(triangles.size()) + " triangles has an area");
  }
  tree->build();
  tree->find_inside();
  tree_ = std::move(tree);
}

Vector3d SurfaceDistance::closest_point(const Vector3d& point) const {
  return tree_->closest_point(point);
}

double SurfaceDistance::winding_number(const Vector3d& point) const {
  return tree_->winding_number(point);
}

double SurfaceDistance::signed_distance(const Vector3d& point) const {
  const double distance = (closest_point(point) - point).norm();
  // Full distance unless the winding number is well between 0 and 1, as it is in holes only. There
  // it varies over the width of the hole, which is what the distance measures.
  const double depth = winding_number(point) - 0.5;
  return -std::copysign(distance * std::min(1.0, 2.2 * std::abs(depth)), depth);
}

const AlignedBox3d& SurfaceDistance::bounds() const noexcept {
  return tree_->boxes.nodes()[0].box;
}

Index SurfaceDistance::turned_triangles() const noexcept {
  return tree_->turned_triangles;
}

bool SurfaceDistance::was_inside_out() const noexcept {
  return tree_->is_inside_out;
}

ImplicitShape surface_shape(std::span<const Vector3d> points, std::span<const Triangle> triangles) {
  const SurfaceDistance surface(points, triangles);
  return ImplicitShape([surface](const Vector3d& p) { return surface.signed_distance(p); },
                       surface.bounds(),
                       [surface](const Vector3d& p) { return surface.closest_point(p); });
}

}  // namespace pbdsurg
