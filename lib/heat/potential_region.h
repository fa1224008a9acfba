// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The part of a mesh in which a potential is solved.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/heat/thermal_mesh.h"

namespace pbdsurg {

/// What conducting elements join to some vertices without crossing ground. Vertices become rows
/// in compact groups of about equal size, so that neighbours are near in memory.
struct PotentialRegion {
  std::vector<Index> vertices;      // [row_count] ids
  std::vector<char> is_ground;      // [row_count]
  std::vector<Index> group_starts;  // [group_count + 1]
  std::vector<Index> elements;      // [element_count] ids
  std::vector<Tet> corners;         // [element_count] rows, as LocalSystem has them
  std::vector<Index> insulators;    // ids of elements met that do not conduct
  Index piece_count = 0;            // that nothing joins but the electrode
  bool has_ground = false;
  bool has_triangles = false;

  /// Keeps its memory.
  void clear();
};

/// Finds regions; keeps its lists from one to the next.
class RegionSearch {
 public:
  /// @param seeds           vertices to start from
  /// @param is_ground       whether a vertex is ground: not for seeds
  /// @param conductivities  S/m
  /// @throws InvalidArgument  naming the element met whose conductivity is not >= 0 and finite
  /// Cost: O(region log(groups)).
  template <class IsGround>
  void find(const ThermalMesh& mesh, std::span<const PatchVertex> seeds, const IsGround& is_ground,
            const ElementSpan& conductivities, PotentialRegion& region) {
    start(mesh, region);
    for (const PatchVertex& seed : seeds) {
      std::size_t next = region.vertices.size();
      region.piece_count += meet(seed.vertex, region) ? 1 : 0;
      for (; next < region.vertices.size(); ++next) {
        const Index v = region.vertices[next];
        const bool ends = is_ground(v);
        region.is_ground.push_back(ends ? 1 : 0);
        region.has_ground |= ends;
        if (!ends) {
          mesh.for_each_element(v, [&](Index e) { visit(mesh, e, conductivities[e], region); });
        }
      }
    }
    finish(mesh, region);
  }

  /// Row of a vertex of the last region, kInvalidIndex for others.
  [[nodiscard]] Index row_of(Index vertex) const {
    return seen_vertices_[vertex] == round_ ? rows_[vertex] : kInvalidIndex;
  }

 private:
  void start(const ThermalMesh& mesh, PotentialRegion& region);
  bool meet(Index vertex, PotentialRegion& region);
  void visit(const ThermalMesh& mesh, Index element, double conductivity, PotentialRegion& region);
  void finish(const ThermalMesh& mesh, PotentialRegion& region);

  std::uint32_t round_ = 0;
  std::vector<std::uint32_t> seen_vertices_;    // [vertex_count] round in which it was met
  ElementValues<std::uint32_t> seen_elements_;  // likewise
  std::vector<Index> rows_;                     // [vertex_count]
  std::vector<Index> order_;                    // [row_count] scratch
  std::vector<char> ground_;                    // [row_count] scratch
  std::vector<Index> found_;                    // [row_count] scratch
};

/// @throws InvalidArgument  if a vertex is not in [0, count), naming it and what has it
void check_vertex(const char* what, Index vertex, Index count);

inline bool is_conductivity(double value) {
  return value >= 0 && value <= std::numeric_limits<double>::max();
}
[[noreturn]] void refuse_conductivity(Index element, double conductivity);

/// @throws InvalidArgument  naming a conductivity that is not >= 0 and finite
inline void check_conductivity(Index element, double conductivity) {
  if (!is_conductivity(conductivity)) {
    refuse_conductivity(element, conductivity);
  }
}

}  // namespace pbdsurg
