// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/cut_surface.h"

#include <algorithm>
#include <limits>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/mesh/closest_on_triangle.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

// Relative to the square of the longest edge: twice the area below which a triangle has no normal.
constexpr double kLeastArea = 1e-6;
// Cosine between the normals of neighbours that fold back on each other.
constexpr double kFlatFold = -0.9999;

struct Side {
  Edge edge;  // smaller point first
  Index triangle;
  int corner;  // where it starts
  bool forward;
};

std::string name_of(Index triangle) {
  return "triangle " + std::to_string(triangle);
}

std::string name_of(const Edge& edge) {
  return "edge " + std::to_string(edge[0]) + "-" + std::to_string(edge[1]);
}

std::vector<Side> sorted_sides(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  for (Index t = 0; t < static_cast<Index>(triangles.size()); ++t) {
    for (int i = 0; i < 3; ++i) {
      const Index from = triangles[t][i], to = triangles[t][(i + 1) % 3];
      sides.push_back({{std::min(from, to), std::max(from, to)}, t, i, from < to});
    }
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.edge < b.edge; });
  return sides;
}

}  // namespace

Vector3d unit_normal(const CutSurface& surface, const Triangle& triangle) {
  const Vector3d a = surface.points[triangle[0]].cast<double>();
  const Vector3d ab = surface.points[triangle[1]].cast<double>() - a;
  const Vector3d ac = surface.points[triangle[2]].cast<double>() - a;
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  const Vector3d normal = ab.cross(ac);
  return normal.norm() > kLeastArea * longest ? normal.normalized() : Vector3d::Zero();
}

// What is nearest decides the side, on edges and corners by the normals of all triangles there, at
// corners weighted by angle: Baerentzen and Aanaes 2005, "Signed distance computation using the
// angle weighted pseudonormal".
CutSides::CutSides(const CutSurface& surface) {
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    if (!surface.points[i].allFinite()) {
      throw InvalidArgument("point " + std::to_string(i) + " of the cut's surface is not finite");
    }
  }
  std::vector<Feature> corners(surface.points.size());
  for (Index t = 0; t < static_cast<Index>(surface.triangles.size()); ++t) {
    Facet facet;
    for (int i = 0; i < 3; ++i) {
      const Index point = surface.triangles[t][i];
      if (point < 0 || static_cast<std::size_t>(point) >= surface.points.size()) {
        throw InvalidArgument(name_of(t) + " of the cut's surface has point " +
                              std::to_string(point) + "; points must be in [0, " +
                              std::to_string(surface.points.size()) + ")");
      }
      facet.corners[i] = surface.points[point].cast<double>();
      bounds_.extend(facet.corners[i]);
    }
    const Vector3d normal = unit_normal(surface, surface.triangles[t]);
    if (normal.isZero(0)) {
      throw InvalidArgument(name_of(t) + " of the cut's surface has no area");
    }
    facet.features[0b111].normal = normal;
    for (int i = 0; i < 3; ++i) {
      const Vector3d to_next = facet.corners[(i + 1) % 3] - facet.corners[i];
      const Vector3d to_last = facet.corners[(i + 2) % 3] - facet.corners[i];
      const double angle = std::atan2(to_next.cross(to_last).norm(), to_next.dot(to_last));
      corners[surface.triangles[t][i]].normal += angle * normal;
    }
    facets_.push_back(facet);
  }

  const std::vector<Side> sides = sorted_sides(surface.triangles);
  for (std::size_t i = 0, end = 0; i < sides.size(); i = end) {
    const Edge& edge = sides[i].edge;
    while (end < sides.size() && sides[end].edge == edge) {
      ++end;
    }
    if (end - i > 2) {
      throw InvalidArgument(name_of(edge) + " of the cut's surface has " + std::to_string(end - i) +
                            " triangles; at most two may meet there");
    }
    Feature feature{facets_[sides[i].triangle].features[0b111].normal, end - i == 1};
    if (!feature.is_rim) {
      const Vector3d& other = facets_[sides[i + 1].triangle].features[0b111].normal;
      if (sides[i].forward == sides[i + 1].forward) {
        throw InvalidArgument(name_of(sides[i].triangle) + " and " +
                              name_of(sides[i + 1].triangle) +
                              " of the cut's surface run the same way along " + name_of(edge) +
                              "; they must be wound alike");
      }
      if (feature.normal.dot(other) < kFlatFold) {
        throw InvalidArgument(name_of(sides[i].triangle) + " and " +
                              name_of(sides[i + 1].triangle) +
                              " of the cut's surface fold back on each other");
      }
      feature.normal = (feature.normal + other).normalized();
    }
    for (std::size_t k = i; k < end; ++k) {
      const unsigned both = 1U << sides[k].corner | 1U << (sides[k].corner + 1) % 3;
      facets_[sides[k].triangle].features[both] = feature;
    }
    for (const Index point : edge) {
      corners[point].is_rim |= feature.is_rim;
    }
  }
  for (std::size_t t = 0; t < facets_.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const Feature& corner = corners[surface.triangles[t][i]];
      facets_[t].features[1U << i] = {corner.normal.normalized(), corner.is_rim};
    }
  }
}

CutSides::Place CutSides::locate(const Vector3d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  const Feature* feature = &facets_[0].features[0b111];
  Vector3d offset = point - facets_[0].corners[0];
  for (const Facet& facet : facets_) {
    const TrianglePoint on =
        closest_on_triangle(facet.corners[0], facet.corners[1], facet.corners[2], point);
    const double squared = (point - on.point).squaredNorm();
    if (squared < nearest) {
      nearest = squared;
      feature = &facet.features[on.corners];
      offset = point - on.point;
    }
  }
  const double height = feature->normal.dot(offset);
  return {height, feature->is_rim ? (offset - height * feature->normal).norm() : 0};
}

}  // namespace pbdsurg
