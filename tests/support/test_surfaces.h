// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Triangle surfaces to try things on.

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg::testing {

/// A sphere of 20 * 4^levels triangles, wound outwards.
inline MeshData icosphere(const Eigen::Vector3d& center, double radius, int levels) {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  MeshData mesh;
  mesh.points = {{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                 {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                 {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<Edge, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                       static_cast<Index>(mesh.points.size()));
      if (is_new) {
        mesh.points.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
      }
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Eigen::Vector3d& point : mesh.points) {
    point = center + radius * point.normalized();
  }
  return mesh;
}

/// Both in one, without any common vertex.
inline MeshData joined(MeshData a, const MeshData& b) {
  const auto shift = static_cast<Index>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const auto& [i, j, k] : b.triangles) {
    a.triangles.push_back({i + shift, j + shift, k + shift});
  }
  return a;
}

/// The same surface inside out.
inline MeshData turned(MeshData mesh) {
  for (Triangle& triangle : mesh.triangles) {
    std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

}  // namespace pbdsurg::testing
