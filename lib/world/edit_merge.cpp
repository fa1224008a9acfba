// SPDX-License-Identifier: Apache-2.0
#include "lib/world/edit_merge.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

namespace pbdsurg {
namespace {

template <class Entry>
void append(std::vector<Entry>& to, const std::vector<Entry>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

// In the order of the request.
void append_new(std::vector<Index>& to, const std::vector<Index>& from) {
  std::vector<Index> known = to;
  std::ranges::sort(known);
  std::ranges::copy_if(from, std::back_inserter(to),
                       [&](Index id) { return !std::ranges::binary_search(known, id); });
}

// They ascend afterwards.
void add_sorted(std::vector<Index>& to, const std::vector<Index>& ids) {
  append(to, ids);
  std::ranges::sort(to);
}

void drop(std::vector<Index>& ids, const std::vector<Index>& gone) {
  std::erase_if(ids, [&](Index id) { return std::ranges::binary_search(gone, id); });
}

// Calls visit(id) for each vertex that an edit names.
template <class Edit, class Visit>
void for_each_vertex(Edit& edit, Visit visit) {
  for (auto& vertex : edit.new_vertices) {
    visit(vertex.first), visit(vertex.second);
  }
  for (auto& move : edit.corner_moves) {
    visit(move.from), visit(move.to);
  }
  for (auto& move : edit.triangle_moves) {
    visit(move.from), visit(move.to);
  }
  for (auto& move : edit.link_moves) {
    visit(move.from), visit(move.to);
  }
  for (auto& tet : edit.new_tets) {
    std::ranges::for_each(tet.vertices, visit);
  }
  for (auto& link : edit.new_links) {
    visit(link.first), visit(link.second);
  }
  std::ranges::for_each(edit.fix_vertices, visit);
  std::ranges::for_each(edit.unfix_vertices, visit);
}

// Adds to an id from `first` on; the largest of all stands for what is beyond.
void shift(Index& id, Index first, Index by) {
  constexpr auto kLargest = std::int64_t{std::numeric_limits<Index>::max()};
  if (id >= first) {
    id = static_cast<Index>(std::min(std::int64_t{id} + by, kLargest));
  }
}

void shift_vertices(TopologyEdit& edit, Index first, Index by) {
  for_each_vertex(edit, [&](Index& v) { shift(v, first, by); });
}

Index count_new_vertices(const TopologyEdit& edit) {
  return static_cast<Index>(edit.new_vertices.size());
}

bool names_no_vertex_beyond(const TopologyEdit& edit, Index vertex_count) {
  const Index end = vertex_count + count_new_vertices(edit) + edit.new_bodies.vertex_count();
  bool is_within = true;
  for_each_vertex(edit, [&](Index v) { is_within = is_within && v < end; });
  return is_within;
}

bool has_body(const Scene& scene, const std::string& name) {
  return std::ranges::count(scene.bodies(), name, &Body::name) > 0;
}

}  // namespace

bool is_empty(const TopologyEdit& edit) noexcept {
  return edit.remove_tets.empty() && edit.remove_triangles.empty() && edit.remove_links.empty() &&
         edit.remove_bodies.empty() && edit.rest_lengths.empty() && edit.rest_volumes.empty() &&
         edit.rest_areas.empty() && edit.stiffnesses.empty() && edit.triangle_stiffnesses.empty() &&
         edit.fibres.empty() && edit.link_lengths.empty() && edit.fix_vertices.empty() &&
         edit.unfix_vertices.empty() && edit.new_vertices.empty() && edit.corner_moves.empty() &&
         edit.triangle_moves.empty() && edit.link_moves.empty() && edit.new_tets.empty() &&
         edit.new_links.empty() && edit.new_bodies.bodies().empty();
}

bool merge(TopologyEdit& edit, TopologyEdit request, Index vertex_count) {
  if (!names_no_vertex_beyond(edit, vertex_count) ||
      !names_no_vertex_beyond(request, vertex_count) ||
      std::ranges::any_of(request.new_bodies.bodies(),
                          [&](const Body& body) { return has_body(edit.new_bodies, body.name); })) {
    return false;
  }
  // new vertices come first, those of bodies behind them
  const Index edit_end = vertex_count + count_new_vertices(edit);
  const Index request_end = vertex_count + count_new_vertices(request);
  shift_vertices(request, request_end, edit.new_bodies.vertex_count());
  shift_vertices(request, vertex_count, count_new_vertices(edit));
  shift_vertices(edit, edit_end, count_new_vertices(request));

  append_new(edit.remove_tets, request.remove_tets);
  append_new(edit.remove_triangles, request.remove_triangles);
  append_new(edit.remove_links, request.remove_links);
  append_new(edit.remove_bodies, request.remove_bodies);
  append(edit.rest_lengths, request.rest_lengths);
  append(edit.rest_volumes, request.rest_volumes);
  append(edit.rest_areas, request.rest_areas);
  append(edit.stiffnesses, request.stiffnesses);
  append(edit.triangle_stiffnesses, request.triangle_stiffnesses);
  append(edit.fibres, request.fibres);
  append(edit.link_lengths, request.link_lengths);
  append_new(edit.fix_vertices, request.fix_vertices);
  append_new(edit.unfix_vertices, request.unfix_vertices);
  append(edit.new_vertices, request.new_vertices);
  append(edit.corner_moves, request.corner_moves);
  append(edit.triangle_moves, request.triangle_moves);
  append(edit.link_moves, request.link_moves);
  append(edit.new_tets, request.new_tets);
  append(edit.new_links, request.new_links);
  edit.new_bodies.append(request.new_bodies);
  return true;
}

IdCounts count_ids(const Tissue& tissue) {
  return {tissue.vertex_count(),
          static_cast<Index>(tissue.tets().size()),
          static_cast<Index>(tissue.triangles().size()),
          static_cast<Index>(tissue.edges().size()),
          static_cast<Index>(tissue.links().size()),
          static_cast<Index>(tissue.bodies().size())};
}

void EarlierEdits::note(const TissueChange& change) {
  add_sorted(tets_, change.removed_tets);
  add_sorted(triangles_, change.removed_triangles);
  add_sorted(links_, change.removed_links);
  add_sorted(bodies_, change.edit.remove_bodies);
}

void EarlierEdits::adapt(TopologyEdit& edit, const Tissue& tissue) const {
  drop(edit.remove_tets, tets_);
  drop(edit.remove_triangles, triangles_);
  drop(edit.remove_links, links_);
  drop(edit.remove_bodies, bodies_);
  const IdCounts now = count_ids(tissue);
  const auto shift_tet = [&](Index& id) { shift(id, before_.tets, now.tets - before_.tets); };
  const auto shift_triangle = [&](Index& id) {
    shift(id, before_.triangles, now.triangles - before_.triangles);
  };
  const auto shift_link = [&](Index& id) { shift(id, before_.links, now.links - before_.links); };
  shift_vertices(edit, before_.vertices, now.vertices - before_.vertices);
  std::ranges::for_each(edit.remove_tets, shift_tet);
  std::ranges::for_each(edit.rest_volumes, shift_tet, &RestVolumeChange::tet);
  std::ranges::for_each(edit.stiffnesses, shift_tet, &StiffnessChange::tet);
  std::ranges::for_each(edit.fibres, shift_tet, &FibreChange::tet);
  std::ranges::for_each(edit.corner_moves, shift_tet, &CornerMove::tet);
  std::ranges::for_each(edit.new_tets, shift_tet, &NewTet::parent);
  std::ranges::for_each(edit.remove_triangles, shift_triangle);
  std::ranges::for_each(edit.rest_areas, shift_triangle, &RestAreaChange::triangle);
  std::ranges::for_each(edit.triangle_stiffnesses, shift_triangle,
                        &TriangleStiffnessChange::triangle);
  std::ranges::for_each(edit.triangle_moves, shift_triangle, &TriangleMove::triangle);
  std::ranges::for_each(edit.remove_links, shift_link);
  std::ranges::for_each(edit.link_moves, shift_link, &LinkMove::link);
  std::ranges::for_each(edit.link_lengths, shift_link, &LinkLengthChange::link);
  for (Index& body : edit.remove_bodies) {
    shift(body, before_.bodies, now.bodies - before_.bodies);
  }
  for (RestLengthChange& change : edit.rest_lengths) {
    shift(change.edge, before_.edges, now.edges - before_.edges);
  }
}

}  // namespace pbdsurg
