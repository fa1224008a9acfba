// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/cut_neighborhood.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

enum Mark : std::uint8_t { kFar, kReached, kBeside, kApart };

void check_front(Index v, std::size_t vertex_count) {
  if (v < 0 || static_cast<std::size_t>(v) >= vertex_count) {
    throw InvalidArgument("the cut's front has vertex " + std::to_string(v) +
                          "; vertices must be in [0, " + std::to_string(vertex_count) + ")");
  }
}

// A bit for each plane of a box on whose outer side a point lies, and one for a point that is not
// finite.
constexpr unsigned kNotFinite = 64;
std::uint8_t sides_outside(const Eigen::Vector3d& x, const Eigen::AlignedBox3d& box) {
  unsigned bits = x.allFinite() ? 0 : kNotFinite;
  for (int axis = 0; axis < 3; ++axis) {
    bits |= static_cast<unsigned>(x[axis] < box.min()[axis]) << axis;
    bits |= static_cast<unsigned>(x[axis] > box.max()[axis]) << (axis + 3);
  }
  return static_cast<std::uint8_t>(bits);
}

// Live tetrahedra whose box meets the other: a box lies beside it if all its corners are on the
// outer side of one of the planes.
std::vector<Index> find_tets_at(const CutTissue& tissue, const Eigen::AlignedBox3d& bounds) {
  std::vector<std::uint8_t> outside(tissue.positions.size());
  std::vector<Index> tets;
  for (std::size_t v = 0; v < outside.size(); ++v) {
    outside[v] = sides_outside(tissue.positions[v].cast<double>(), bounds);
  }
  const std::span<const Tet> all = tissue.live.tets();
  for (std::size_t t = 0; t < all.size(); ++t) {
    const auto& [a, b, c, d] = all[t];
    if ((outside[a] & outside[b] & outside[c] & outside[d]) == 0 &&
        (outside[a] | outside[b] | outside[c] | outside[d]) < kNotFinite &&
        tissue.live.is_tet_alive(static_cast<Index>(t))) {
      tets.push_back(static_cast<Index>(t));
    }
  }
  return tets;
}

}  // namespace

CutNeighborhood find_neighborhood(const CutTissue& tissue, const Eigen::AlignedBox3d& bounds,
                                  const CutFront& front) {
  const std::size_t vertex_count = tissue.positions.size();
  for (const Index v : front.vertices) {
    check_front(v, vertex_count);
  }
  for (const Triangle& face : front.closed_faces) {
    std::ranges::for_each(face, [&](Index v) { check_front(v, vertex_count); });
  }
  const std::span<const Tet> all = tissue.live.tets();
  CutNeighborhood near;
  std::vector<std::uint8_t> marks(vertex_count, kFar);
  const auto mark = [&](Index v, Mark as) {
    if (marks[v] == kFar) {
      marks[v] = as;
      near.vertex_ids.push_back(v);
    }
  };
  for (const Index t : find_tets_at(tissue, bounds)) {
    std::ranges::for_each(all[t], [&](Index v) { mark(v, kReached); });
  }
  for (const Triangle& face : front.closed_faces) {
    std::ranges::for_each(face, [&](Index v) { mark(v, kReached); });
  }
  for (const Index v : near.vertex_ids) {
    const std::span<const Index> tets = tissue.live.tets_at(v);
    near.tet_ids.insert(near.tet_ids.end(), tets.begin(), tets.end());
  }
  std::ranges::sort(near.tet_ids);
  near.tet_ids.erase(std::unique(near.tet_ids.begin(), near.tet_ids.end()), near.tet_ids.end());
  for (const Index t : near.tet_ids) {
    std::ranges::for_each(all[t], [&](Index v) { mark(v, kBeside); });
  }
  const std::span<const Link> links = tissue.live.links();
  const auto has_tet = [&](Index v) { return marks[v] == kReached || marks[v] == kBeside; };
  for (std::size_t l = 0; l < links.size(); ++l) {
    if ((has_tet(links[l].first) || has_tet(links[l].second)) &&
        tissue.live.is_link_alive(static_cast<Index>(l))) {
      near.link_ids.push_back(static_cast<Index>(l));
    }
  }
  for (const Index l : near.link_ids) {
    mark(links[l].first, kApart);
    mark(links[l].second, kApart);
  }
  std::ranges::for_each(front.vertices, [&](Index v) { mark(v, kApart); });

  std::ranges::sort(near.vertex_ids);
  for (const Index v : near.vertex_ids) {
    near.positions.push_back(tissue.positions[v]);
    near.is_reached.push_back(marks[v] == kReached);
  }
  const auto own = [&](Index v) {
    return static_cast<Index>(std::ranges::lower_bound(near.vertex_ids, v) -
                              near.vertex_ids.begin());
  };
  for (const Index t : near.tet_ids) {
    const auto& [a, b, c, d] = all[t];
    near.tets.push_back({own(a), own(b), own(c), own(d)});
  }
  for (const Index l : near.link_ids) {
    near.links.push_back(links[l]);
    near.links.back().first = own(links[l].first);
    near.links.back().second = own(links[l].second);
  }
  for (const Index v : front.vertices) {
    near.front.vertices.push_back(own(v));
  }
  for (const auto& [a, b, c] : front.closed_faces) {
    near.front.closed_faces.push_back({own(a), own(b), own(c)});
  }
  return near;
}

CutPlan with_solver_ids(CutPlan plan, const CutNeighborhood& near, Index vertex_count) {
  const auto own_count = static_cast<Index>(near.vertex_ids.size());
  const auto to_id = [&](Index& v) {
    v = v < own_count ? near.vertex_ids[v] : vertex_count + v - own_count;
  };
  for (NewVertex& vertex : plan.edit.new_vertices) {
    to_id(vertex.first);
    to_id(vertex.second);
  }
  for (CornerMove& move : plan.edit.corner_moves) {
    move.tet = near.tet_ids[move.tet];
    to_id(move.from);
    to_id(move.to);
  }
  for (LinkMove& move : plan.edit.link_moves) {
    move.link = near.link_ids[move.link];
    to_id(move.from);
    to_id(move.to);
  }
  for (NewTet& tet : plan.edit.new_tets) {
    tet.parent = near.tet_ids[tet.parent];
    std::ranges::for_each(tet.vertices, to_id);
  }
  std::ranges::for_each(plan.front.vertices, to_id);
  for (Triangle& face : plan.front.closed_faces) {
    std::ranges::for_each(face, to_id);
  }
  return plan;
}

}  // namespace pbdsurg
