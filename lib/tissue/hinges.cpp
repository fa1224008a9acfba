// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/hinges.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/sheet.h"
#include "lib/tissue/tissue_data.h"

namespace pbdsurg {
namespace {

using Corners = std::array<Index, 4>;

void remove_hinge(TissueData& data, Index hinge) {
  data.hinge_alive.set(hinge, 0);
  for (const Index v : data.hinges[hinge].vertices) {
    data.vertex_hinges.erase(v, hinge);
  }
  data.change.removed_hinges.push_back(hinge);
}

void move_hinge(TissueData& data, Index id, const Corners& vertices) {
  Hinge hinge = data.hinges[id];
  for (std::size_t i = 0; i < 4; ++i) {
    if (hinge.vertices[i] != vertices[i]) {
      data.vertex_hinges.erase(hinge.vertices[i], id);
      data.vertex_hinges.insert(vertices[i], id);
    }
  }
  hinge.vertices = vertices;
  data.hinges.set(id, hinge);
  data.change.moved_hinges.push_back(id);
}

// The tetrahedron of the surface, or the triangle of a sheet, that has a triangle.
// @param at  those at a vertex of the triangle, which has one of them
template <class Corners>
Index find_owner(std::span<const Index> at, const UndoArray<Corners>& all,
                 const Triangle& triangle) {
  return *std::ranges::find_if(at, [&](Index id) { return has_all(all[id], triangle); });
}

// What a triangle has become in its owner: vertices that are the same, or copies.
std::optional<Triangle> find_in(std::span<const Index> corners, const Triangle& triangle,
                                const TopologyEdit& edit, Index first_new_vertex) {
  const auto original = [&](Index v) {
    if (v < first_new_vertex) {
      return v;
    }
    const NewVertex& vertex = edit.new_vertices[static_cast<std::size_t>(v - first_new_vertex)];
    return vertex.first == vertex.second ? vertex.first : kInvalidIndex;
  };
  Triangle found{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto corner = std::ranges::find(corners, triangle[i], original);
    if (corner == corners.end()) {
      return std::nullopt;
    }
    found[i] = *corner;
  }
  return found;
}

}  // namespace

std::optional<std::array<Index, 2>> sheet_triangles(const Tissue& tissue, Index hinge) {
  const TissueData& data = tissue_data(tissue);
  const Corners& v = data.hinges[hinge].vertices;
  if (!is_sheet(data.bodies[data.body_of_vertex(v[0])])) {
    return std::nullopt;
  }
  const auto owner = [&](std::size_t side) {
    return find_owner(data.triangles_at(v[0]), data.triangles, triangle_of_hinge(v, side));
  };
  return std::array{owner(0), owner(1)};
}

double hinge_stiffness(const Tissue& tissue, Index hinge) {
  const auto triangles = sheet_triangles(tissue, hinge);
  return triangles ? (double{tissue.triangle_stiffness((*triangles)[0])} +
                      tissue.triangle_stiffness((*triangles)[1])) /
                         2
                   : 1;
}

std::vector<double> hinge_stiffnesses(const Scene& scene) {
  std::vector<double> factors(scene.hinges().size(), 1);
  if (std::ranges::all_of(scene.triangle_stiffnesses(), [](float each) { return each == 1; })) {
    return factors;
  }
  using Known = std::pair<Triangle, float>;  // corners, ascending; factor
  std::vector<Known> known;
  known.reserve(scene.triangles().size());
  for (std::size_t t = 0; t < scene.triangles().size(); ++t) {
    known.emplace_back(scene.triangles()[t], scene.triangle_stiffnesses()[t]);
    std::ranges::sort(known.back().first);
  }
  std::ranges::sort(known);
  for (std::size_t h = 0; h < factors.size(); ++h) {
    double sum = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      Triangle triangle = triangle_of_hinge(scene.hinges()[h].vertices, side);
      std::ranges::sort(triangle);
      const auto found = std::ranges::lower_bound(known, triangle, {}, &Known::first);
      sum += found != known.end() && found->first == triangle ? found->second : 1;
    }
    factors[h] = sum / 2;
  }
  return factors;
}

void remove_hinges(TissueData& data, std::span<const Index> corners) {
  if (data.hinges.size() == 0) {
    return;
  }
  std::pmr::vector<Index> hinges(data.scratch.get());
  for_each_hinge_of(data, corners, [&](Index hinge) {
    if (std::ranges::find(hinges, hinge) == hinges.end()) {
      hinges.push_back(hinge);
    }
  });
  for (const Index hinge : hinges) {
    remove_hinge(data, hinge);
  }
}

PartedHinges::PartedHinges(const TissueData& data, const TopologyEdit& edit)
    : hinges_(data.scratch.get()) {
  if (data.hinges.size() == 0) {
    return;
  }
  const auto collect = [&](std::span<const Index> corners, bool is_of_sheet) {
    for_each_hinge_of(data, corners, [&](Index hinge) {
      hinges_.push_back({hinge, {}, is_of_sheet});
    });
  };
  for (const CornerMove& move : edit.corner_moves) {
    collect(data.tets[move.tet], false);
  }
  for (const NewTet& tet : edit.new_tets) {
    collect(data.tets[tet.parent], false);
  }
  for (const TriangleMove& move : edit.triangle_moves) {
    collect(data.triangles[move.triangle], true);
  }
  std::ranges::sort(hinges_, {}, &Parted::hinge);
  hinges_.erase(std::unique(hinges_.begin(), hinges_.end()), hinges_.end());
  for (Parted& parted : hinges_) {
    for (std::size_t side = 0; side < 2; ++side) {
      const Triangle triangle = triangle_of_hinge(data.hinges[parted.hinge].vertices, side);
      parted.owners[side] =
          parted.is_of_sheet ? find_owner(data.triangles_at(triangle[0]), data.triangles, triangle)
                             : find_owner(data.vertex_tets[triangle[0]], data.tets, triangle);
    }
  }
}

void PartedHinges::settle(TissueData& data, const TopologyEdit& edit) const {
  if (hinges_.empty()) {
    return;
  }
  using Child = std::pair<Index, Index>;  // parent, tetrahedron
  std::pmr::vector<Child> children(data.scratch.get());
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    children.emplace_back(edit.new_tets[i].parent,
                          data.change.first_new_tet + static_cast<Index>(i));
  }
  std::ranges::sort(children);
  const auto find_now = [&](std::span<const Index> corners, const Triangle& triangle) {
    return find_in(corners, triangle, edit, data.change.first_new_vertex);
  };
  const auto find_triangle = [&](Index tet, const Triangle& triangle) -> std::optional<Triangle> {
    if (data.tet_alive[tet] != 0) {
      return find_now(data.tets[tet], triangle);
    }
    for (auto child = std::ranges::lower_bound(children, tet, {}, &Child::first);
         child != children.end() && child->first == tet; ++child) {
      if (const std::optional<Triangle> found = find_now(data.tets[child->second], triangle)) {
        return found;
      }
    }
    return std::nullopt;
  };
  for (const auto& [hinge, owners, is_of_sheet] : hinges_) {
    const Corners before = data.hinges[hinge].vertices;
    std::optional<Triangle> sides[2];
    for (std::size_t side = 0; side < 2; ++side) {
      const Triangle triangle = triangle_of_hinge(before, side);
      sides[side] = is_of_sheet ? find_now(data.triangles[owners[side]], triangle)
                                : find_triangle(owners[side], triangle);
    }
    const auto& [left, right] = sides;
    if (!left || !right || (*left)[0] != (*right)[0] || (*left)[1] != (*right)[1]) {
      remove_hinge(data, hinge);
      continue;
    }
    const Corners now{(*left)[0], (*left)[1], (*left)[2], (*right)[2]};
    if (now != before) {
      move_hinge(data, hinge, now);
    }
  }
}

}  // namespace pbdsurg
