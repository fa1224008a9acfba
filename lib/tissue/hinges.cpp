// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/hinges.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {
namespace {

using Corners = std::array<Index, 4>;

bool has(const Tet& tet, Index vertex) {
  return std::ranges::find(tet, vertex) != tet.end();
}

Triangle triangle_of(const Corners& hinge, std::size_t side) {
  return {hinge[0], hinge[1], hinge[2 + side]};
}

bool has_all(const Tet& tet, const Triangle& triangle) {
  return std::ranges::all_of(triangle, [&](Index v) { return has(tet, v); });
}

// Calls visit(hinge) for each that has a triangle of a tetrahedron; some twice.
template <class Visit>
void for_each_hinge_of(const TissueData& data, Index tet, Visit visit) {
  const Tet& corners = data.tets[tet];
  for (std::size_t i = 0; i < 2; ++i) {  // a triangle has one of any two corners
    for (const Index hinge : data.hinges_at(corners[i])) {
      const Corners& v = data.hinges[hinge].vertices;
      if (has_all(corners, triangle_of(v, 0)) || has_all(corners, triangle_of(v, 1))) {
        visit(hinge);
      }
    }
  }
}

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

// The tetrahedron of the surface that has a triangle.
Index find_tet(const TissueData& data, const Triangle& triangle) {
  const auto at = data.vertex_tets[triangle[0]];
  return *std::ranges::find_if(at, [&](Index t) { return has_all(data.tets[t], triangle); });
}

// What a triangle has become in a tetrahedron: vertices that are the same, or copies.
std::optional<Triangle> find_in(const Tet& tet, const Triangle& triangle, const TopologyEdit& edit,
                                Index first_new_vertex) {
  const auto original = [&](Index v) {
    if (v < first_new_vertex) {
      return v;
    }
    const NewVertex& vertex = edit.new_vertices[static_cast<std::size_t>(v - first_new_vertex)];
    return vertex.first == vertex.second ? vertex.first : kInvalidIndex;
  };
  Triangle found{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto corner = std::ranges::find(tet, triangle[i], original);
    if (corner == tet.end()) {
      return std::nullopt;
    }
    found[i] = *corner;
  }
  return found;
}

}  // namespace

void remove_hinges(TissueData& data, Index tet) {
  if (data.hinges.size() == 0) {
    return;
  }
  std::pmr::vector<Index> hinges(data.scratch.get());
  for_each_hinge_of(data, tet, [&](Index hinge) {
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
  const auto collect = [&](Index tet) {
    for_each_hinge_of(data, tet, [&](Index hinge) { hinges_.push_back({hinge, {}}); });
  };
  for (const CornerMove& move : edit.corner_moves) {
    collect(move.tet);
  }
  for (const NewTet& tet : edit.new_tets) {
    collect(tet.parent);
  }
  std::ranges::sort(hinges_, {}, &Parted::hinge);
  hinges_.erase(std::unique(hinges_.begin(), hinges_.end()), hinges_.end());
  for (Parted& parted : hinges_) {
    for (std::size_t side = 0; side < 2; ++side) {
      parted.tets[side] = find_tet(data, triangle_of(data.hinges[parted.hinge].vertices, side));
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
  const auto find_triangle = [&](Index tet, const Triangle& triangle) -> std::optional<Triangle> {
    const auto find_at = [&](Index at) {
      return find_in(data.tets[at], triangle, edit, data.change.first_new_vertex);
    };
    if (data.tet_alive[tet] != 0) {
      return find_at(tet);
    }
    for (auto child = std::ranges::lower_bound(children, tet, {}, &Child::first);
         child != children.end() && child->first == tet; ++child) {
      if (const std::optional<Triangle> found = find_at(child->second)) {
        return found;
      }
    }
    return std::nullopt;
  };
  for (const auto& [hinge, tets] : hinges_) {
    const Corners before = data.hinges[hinge].vertices;
    const auto left = find_triangle(tets[0], triangle_of(before, 0));
    const auto right = find_triangle(tets[1], triangle_of(before, 1));
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
