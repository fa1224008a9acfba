// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/triangle_orientation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace pbdsurg {
namespace {

struct HalfEdge {
  Edge edge;  // smaller id first
  Index triangle;
  int side;      // of the triangle
  bool forward;  // runs from the smaller id to the larger

  bool operator<(const HalfEdge& other) const {
    return edge != other.edge ? edge < other.edge : triangle < other.triangle;
  }
};

struct Neighbor {
  Index triangle = kInvalidIndex;
  bool is_opposed = false;  // wound the other way round
};

std::vector<std::array<Neighbor, 3>> find_neighbors(std::span<const Triangle> triangles) {
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const Index a = triangles[t][i], b = triangles[t][(i + 1) % 3];
      half_edges.push_back({{std::min(a, b), std::max(a, b)}, static_cast<Index>(t), i, a < b});
    }
  }
  std::sort(half_edges.begin(), half_edges.end());
  std::vector<std::array<Neighbor, 3>> neighbors(triangles.size());
  for (std::size_t i = 0; i < half_edges.size();) {
    std::size_t end = i + 1;
    while (end < half_edges.size() && half_edges[end].edge == half_edges[i].edge) {
      ++end;
    }
    if (end - i == 2) {
      const HalfEdge& first = half_edges[i];
      const HalfEdge& second = half_edges[i + 1];
      const bool is_opposed = first.forward == second.forward;
      neighbors[first.triangle][first.side] = {second.triangle, is_opposed};
      neighbors[second.triangle][second.side] = {first.triangle, is_opposed};
    }
    i = end;
  }
  return neighbors;
}

}  // namespace

Index orient_triangles(std::span<const Eigen::Vector3d> points, std::span<Triangle> triangles) {
  const auto neighbors = find_neighbors(triangles);
  enum class Turn : char { unknown, keep, turn };
  std::vector<Turn> turns(triangles.size(), Turn::unknown);
  std::vector<Index> part;
  Index turned = 0;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    if (turns[seed] != Turn::unknown) {
      continue;
    }
    turns[seed] = Turn::keep;
    part.assign(1, static_cast<Index>(seed));
    double kept_area = 0, turned_area = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Index t = part[i];
      const Eigen::Vector3d& origin = points[triangles[t][0]];
      const double area =
          (points[triangles[t][1]] - origin).cross(points[triangles[t][2]] - origin).norm();
      (turns[t] == Turn::keep ? kept_area : turned_area) += area;
      for (const Neighbor& neighbor : neighbors[t]) {
        if (neighbor.triangle != kInvalidIndex && turns[neighbor.triangle] == Turn::unknown) {
          const bool turn = (turns[t] == Turn::turn) != neighbor.is_opposed;
          turns[neighbor.triangle] = turn ? Turn::turn : Turn::keep;
          part.push_back(neighbor.triangle);
        }
      }
    }
    const Turn minority = turned_area <= kept_area ? Turn::turn : Turn::keep;
    for (const Index t : part) {
      if (turns[t] == minority) {
        std::swap(triangles[t][1], triangles[t][2]);
        ++turned;
      }
    }
  }
  return turned;
}

}  // namespace pbdsurg
