// SPDX-License-Identifier: Apache-2.0
#include "lib/tissue/edit_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory_resource>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/tissue/scene_checks.h"
#include "lib/tissue/split_tets.h"

namespace pbdsurg {
namespace {

template <class T>
std::size_t count_of(const UndoArray<T>& array) {
  return static_cast<std::size_t>(array.size());
}

std::string name_of(const char* what, Index id) {
  return std::string(what) + " " + std::to_string(id);
}

// An id must be in range and alive.
template <class IsAlive>
void check_id(const char* what, Index id, std::size_t count, const IsAlive& is_alive) {
  if (id < 0 || static_cast<std::size_t>(id) >= count) {
    throw InvalidArgument(name_of(what, id) + " does not exist; ids must be in [0, " +
                          std::to_string(count) + ")");
  }
  if (!is_alive(id)) {
    throw InvalidArgument(name_of(what, id) + " was removed before");
  }
}

// Ids must be that and listed once. Sorts them.
template <class IsAlive>
void check_ids(const char* what, std::vector<Index>& ids, std::size_t count,
               const IsAlive& is_alive) {
  for (const Index id : ids) {
    check_id(what, id, count, is_alive);
  }
  std::sort(ids.begin(), ids.end());
  const auto twice = std::adjacent_find(ids.begin(), ids.end());
  if (twice != ids.end()) {
    throw InvalidArgument(name_of(what, *twice) + " is listed twice in one edit");
  }
}

void check_rest(const char* what, Index id, const char* quantity, float value) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(name_of(what, id) + ": the new " + quantity + " is " +
                          std::to_string(value) + "; it must be positive and finite");
  }
}

// Tissue that an edit names must not be of a body that it removes.
void check_stays(const TissueData& data, const TopologyEdit& edit, const char* what, Index id,
                 Index body) {
  if (std::ranges::count(edit.remove_bodies, body) > 0) {
    throw InvalidArgument(name_of(what, id) + " is of body '" + data.bodies[body].name +
                          "', which the same edit removes");
  }
}

void check_removals(TissueData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.buffer;
  ids = edit.remove_tets;
  check_ids("tet", ids, count_of(data.tets), [&](Index t) { return data.tet_alive[t] != 0; });
  ids = edit.remove_triangles;
  check_ids("triangle", ids, count_of(data.triangles),
            [&](Index t) { return data.triangle_alive[t] != 0; });
  ids = edit.remove_bodies;
  check_ids("body", ids, count_of(data.bodies), [&](Index b) { return data.tissue_counts[b] > 0; });
  if (!edit.remove_bodies.empty()) {
    for (const Index t : edit.remove_tets) {
      check_stays(data, edit, "tet", t, data.body_of_tet(t));
    }
    for (const Index t : edit.remove_triangles) {
      check_stays(data, edit, "triangle", t, data.body_of_triangle(t));
    }
  }
  ids = edit.remove_links;
  check_ids("link", ids, count_of(data.links), [&](Index l) { return data.link_alive[l] != 0; });
}

void check_rest_values(TissueData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.buffer;
  ids.clear();
  for (const RestLengthChange& change : edit.rest_lengths) {
    check_rest("edge", change.edge, "rest length", change.rest_length);
    ids.push_back(change.edge);
  }
  check_ids("edge", ids, count_of(data.edges), [&](Index e) { return data.edge_tets[e] > 0; });
  ids.clear();
  for (const RestVolumeChange& change : edit.rest_volumes) {
    check_rest("tet", change.tet, "rest volume", change.rest_volume);
    ids.push_back(change.tet);
  }
  check_ids("tet", ids, count_of(data.tets), [&](Index t) { return data.tet_alive[t] != 0; });
  ids.clear();
  for (const RestAreaChange& change : edit.rest_areas) {
    check_rest("triangle", change.triangle, "rest area", change.rest_area);
    ids.push_back(change.triangle);
  }
  check_ids("triangle", ids, count_of(data.triangles),
            [&](Index t) { return data.triangle_alive[t] != 0; });
}

// @param id        of a change's element
// @param is_alive  [element_count]
template <class Change>
void check_factors(TissueData& data, const char* what, const std::vector<Change>& changes,
                   Index Change::*id, const UndoArray<std::uint8_t>& is_alive) {
  std::vector<Index>& ids = data.buffer;
  ids.clear();
  for (const Change& change : changes) {
    ids.push_back(change.*id);
  }
  check_ids(what, ids, count_of(is_alive), [&](Index element) { return is_alive[element] != 0; });
  for (const Change& change : changes) {
    check_stiffness_factor(name_of(what, change.*id), change.factor);
  }
}

void check_stiffnesses(TissueData& data, const TopologyEdit& edit) {
  check_factors(data, "tet", edit.stiffnesses, &StiffnessChange::tet, data.tet_alive);
  for (const StiffnessChange& change : edit.stiffnesses) {
    check_has_moduli(name_of("tet", change.tet), data.bodies[data.body_of_tet(change.tet)]);
  }
  check_factors(data, "triangle", edit.triangle_stiffnesses, &TriangleStiffnessChange::triangle,
                data.triangle_alive);
}

void check_fibres(TissueData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.buffer;
  ids.clear();
  for (const FibreChange& change : edit.fibres) {
    ids.push_back(change.tet);
  }
  check_ids("tet", ids, count_of(data.tets), [&](Index t) { return data.tet_alive[t] != 0; });
  for (const FibreChange& change : edit.fibres) {
    const std::string what = name_of("tet", change.tet);
    check_fibre(what, change.fibre);
    check_takes_fibres(what, data.bodies[data.body_of_tet(change.tet)]);
  }
}

void check_link_lengths(TissueData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.buffer;
  ids.clear();
  for (const LinkLengthChange& change : edit.link_lengths) {
    if (!(change.rest_length >= 0) || !std::isfinite(change.rest_length)) {
      throw InvalidArgument(name_of("link", change.link) + ": the new rest length is " +
                            std::to_string(change.rest_length) +
                            "; it must be finite and not negative");
    }
    if (std::ranges::count(edit.remove_links, change.link) > 0) {
      throw InvalidArgument(name_of("link", change.link) +
                            " has a new rest length and is removed by one edit");
    }
    ids.push_back(change.link);
  }
  check_ids("link", ids, count_of(data.links), [&](Index l) { return data.link_alive[l] != 0; });
}

void check_new_vertices(const TissueData& data, const TopologyEdit& edit) {
  const std::size_t count = count_of(data.rest_positions);
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    const NewVertex& vertex = edit.new_vertices[i];
    const auto what = [&] { return name_of("new vertex", static_cast<Index>(count + i)); };
    for (const Index v : {vertex.first, vertex.second}) {
      if (v < 0 || static_cast<std::size_t>(v) >= count) {
        throw InvalidArgument(what() + " refers to vertex " + std::to_string(v) +
                              "; ids must be in [0, " + std::to_string(count) + ")");
      }
      if (!data.is_corner(v)) {
        throw InvalidArgument(what() + " refers to vertex " + std::to_string(v) +
                              ", which no tetrahedron or triangle has");
      }
      check_stays(data, edit, "new vertex", static_cast<Index>(count + i), data.body_of_vertex(v));
    }
    if (data.body_of_vertex(vertex.first) != data.body_of_vertex(vertex.second)) {
      throw InvalidArgument(what() + " lies between vertices " + std::to_string(vertex.first) +
                            " and " + std::to_string(vertex.second) + " of different bodies");
    }
    if (!(vertex.share >= 0) || !(vertex.share <= 1)) {
      throw InvalidArgument(what() + ": the share is " + std::to_string(vertex.share) +
                            "; it must be in [0, 1]");
    }
  }
}

// @param to  must be a copy of `from`, made by the edit
void check_copy(const TissueData& data, const TopologyEdit& edit, const std::string& what,
                Index from, Index to) {
  const std::size_t first = count_of(data.rest_positions);
  const bool is_new = to >= 0 && static_cast<std::size_t>(to) >= first &&
                      static_cast<std::size_t>(to) < first + edit.new_vertices.size();
  const NewVertex vertex = is_new ? edit.new_vertices[to - static_cast<Index>(first)] : NewVertex{};
  if (!is_new || vertex.first != from || vertex.second != from) {
    throw InvalidArgument(what + " cannot move from vertex " + std::to_string(from) + " to " +
                          std::to_string(to) + ", which is no new copy of it");
  }
}

std::pmr::vector<Index> sorted(std::span<const Index> ids, const TissueData& data) {
  std::pmr::vector<Index> copy(ids.begin(), ids.end(), data.scratch.get());
  std::ranges::sort(copy);
  return copy;
}

// Nothing moves twice.
void check_moved_once(const char* what, std::pmr::vector<std::array<Index, 2>>& moved) {
  std::ranges::sort(moved);
  const auto twice = std::adjacent_find(moved.begin(), moved.end());
  if (twice != moved.end()) {
    throw InvalidArgument(name_of(what, (*twice)[0]) + " is moved twice from vertex " +
                          std::to_string((*twice)[1]) + " in one edit");
  }
}

void check_triangle_moves(const TissueData& data, const TopologyEdit& edit) {
  std::pmr::vector<std::array<Index, 2>> moved(data.scratch.get());
  const std::pmr::vector<Index> removed = sorted(edit.remove_triangles, data);
  for (const TriangleMove& move : edit.triangle_moves) {
    check_id("triangle", move.triangle, count_of(data.triangles),
             [&](Index t) { return data.triangle_alive[t] != 0; });
    const std::string what = name_of("triangle", move.triangle);
    check_stays(data, edit, "triangle", move.triangle, data.body_of_triangle(move.triangle));
    if (std::ranges::binary_search(removed, move.triangle)) {
      throw InvalidArgument(what + " is moved and removed by one edit");
    }
    if (std::ranges::count(data.triangles[move.triangle], move.from) == 0) {
      throw InvalidArgument(what + " has no corner at vertex " + std::to_string(move.from));
    }
    check_copy(data, edit, what, move.from, move.to);
    moved.push_back({move.triangle, move.from});
  }
  check_moved_once("triangle", moved);
}

void check_moves(const TissueData& data, const TopologyEdit& edit) {
  std::pmr::vector<std::array<Index, 2>> moved(data.scratch.get());
  const std::pmr::vector<Index> removed_tets = sorted(edit.remove_tets, data);
  for (const CornerMove& move : edit.corner_moves) {
    check_id("tet", move.tet, count_of(data.tets), [&](Index t) { return data.tet_alive[t] != 0; });
    const std::string what = name_of("tet", move.tet);
    check_stays(data, edit, "tet", move.tet, data.body_of_tet(move.tet));
    if (std::ranges::binary_search(removed_tets, move.tet)) {
      throw InvalidArgument(what + " is moved and removed by one edit");
    }
    if (std::ranges::count(data.tets[move.tet], move.from) == 0) {
      throw InvalidArgument(what + " has no corner at vertex " + std::to_string(move.from));
    }
    check_copy(data, edit, what, move.from, move.to);
    moved.push_back({move.tet, move.from});
  }
  check_moved_once("tet", moved);
  moved.clear();
  const std::pmr::vector<Index> removed_links = sorted(edit.remove_links, data);
  for (const LinkMove& move : edit.link_moves) {
    check_id("link", move.link, count_of(data.links),
             [&](Index l) { return data.link_alive[l] != 0; });
    const std::string what = name_of("link", move.link);
    if (std::ranges::binary_search(removed_links, move.link)) {
      throw InvalidArgument(what + " is moved and removed by one edit");
    }
    const Link& link = data.links[move.link];
    if (link.first != move.from && link.second != move.from) {
      throw InvalidArgument(what + " has no end at vertex " + std::to_string(move.from));
    }
    check_copy(data, edit, what, move.from, move.to);
    moved.push_back({move.link, move.from});
  }
  check_moved_once("link", moved);
}

void check_new_tets(const TissueData& data, const TopologyEdit& edit) {
  constexpr double kTolerance = 1e-4;  // of the parent's volume
  // parent, part of its volume
  std::pmr::vector<std::pair<Index, double>> filled(data.scratch.get());
  std::pmr::vector<Index> taken(edit.remove_tets.begin(), edit.remove_tets.end(),
                                data.scratch.get());
  for (const CornerMove& move : edit.corner_moves) {
    taken.push_back(move.tet);
  }
  std::ranges::sort(taken);
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    const NewTet& tet = edit.new_tets[i];
    const std::string what = name_of("new tet", static_cast<Index>(count_of(data.tets) + i));
    check_id("tet", tet.parent, count_of(data.tets),
             [&](Index t) { return data.tet_alive[t] != 0; });
    check_stays(data, edit, "new tet", static_cast<Index>(count_of(data.tets) + i),
                data.body_of_tet(tet.parent));
    if (std::ranges::binary_search(taken, tet.parent)) {
      throw InvalidArgument(what + ": its parent, tet " + std::to_string(tet.parent) +
                            ", is moved or removed by the same edit");
    }
    const auto end = static_cast<Index>(count_of(data.rest_positions) + edit.new_vertices.size());
    if (std::ranges::any_of(tet.vertices, [&](Index v) { return v < 0 || v >= end; })) {
      throw InvalidArgument(what + " refers to a vertex that does not exist; ids must be in [0, " +
                            std::to_string(end) + ")");
    }
    const auto shares = find_shares(data.tets[tet.parent], edit, tet, data.vertex_count());
    if (!shares) {
      throw InvalidArgument(what + " has a vertex that is neither a corner of tet " +
                            std::to_string(tet.parent) + " nor on an edge of it");
    }
    const double share = volume_share(*shares);
    if (!(share > kTolerance * kTolerance)) {
      throw InvalidArgument(what + " has " + std::to_string(share) + " of the volume of tet " +
                            std::to_string(tet.parent) + "; it must be positive");
    }
    filled.emplace_back(tet.parent, share);
  }
  std::ranges::sort(filled);
  for (auto first = filled.begin(); first != filled.end();) {
    double sum = 0;
    const Index parent = first->first;
    for (; first != filled.end() && first->first == parent; ++first) {
      sum += first->second;
    }
    if (!(std::abs(sum - 1) <= kTolerance)) {
      throw InvalidArgument("new tets fill " + std::to_string(sum) + " of tet " +
                            std::to_string(parent) + "; they must fill it");
    }
  }
}

// What a scene and a solver of it have checked already is not checked again.
void check_new_bodies(const TissueData& data, const TopologyEdit& edit) {
  const Scene& scene = edit.new_bodies;
  for (const Body& body : scene.bodies()) {
    if (std::ranges::count(data.bodies.values(), body.name, &Body::name) > 0) {
      throw InvalidArgument("there is a body named '" + body.name +
                            "' already; names must differ, also from those of removed bodies");
    }
  }
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  const auto vertex_count = static_cast<std::size_t>(scene.vertex_count());
  if (count_of(data.rest_positions) + edit.new_vertices.size() + vertex_count > kMost ||
      count_of(data.tets) + edit.new_tets.size() + scene.tets().size() > kMost ||
      count_of(data.triangles) + scene.triangles().size() > kMost) {
    throw InvalidArgument("with " + std::to_string(vertex_count) + " vertices, " +
                          std::to_string(scene.tets().size()) + " tets and " +
                          std::to_string(scene.triangles().size()) +
                          " triangles of new bodies there would be more than 2147483647");
  }
}

// Each new vertex must have tissue.
void check_use_of_new_vertices(const TissueData& data, const TopologyEdit& edit) {
  const auto first = static_cast<Index>(count_of(data.rest_positions));
  std::pmr::vector<bool> is_used(edit.new_vertices.size(), false, data.scratch.get());
  const auto use = [&](Index v) {
    if (v >= first) {
      is_used[v - first] = true;
    }
  };
  for (const CornerMove& move : edit.corner_moves) {
    use(move.to);
  }
  for (const TriangleMove& move : edit.triangle_moves) {
    use(move.to);
  }
  for (const NewTet& tet : edit.new_tets) {
    std::ranges::for_each(tet.vertices, use);
  }
  const auto unused = std::ranges::find(is_used, false);
  if (unused != is_used.end()) {
    throw InvalidArgument(
        name_of("new vertex", first + static_cast<Index>(unused - is_used.begin())) +
        " would have no tetrahedron or triangle");
  }
}

// @param stopping  ascending
void check_new_links(const TissueData& data, const TopologyEdit& edit,
                     std::span<const Index> stopping) {
  const auto vertex_count = static_cast<Index>(count_of(data.rest_positions));
  const auto first_of_bodies = vertex_count + static_cast<Index>(edit.new_vertices.size());
  const auto has_tissue = [&](Index v) {
    if (v >= first_of_bodies) {
      return edit.new_bodies.masses()[v - first_of_bodies] > 0;
    }
    return v >= vertex_count || (data.masses[v] > 0 && !std::ranges::binary_search(stopping, v));
  };
  for (std::size_t i = 0; i < edit.new_links.size(); ++i) {
    const Link& link = edit.new_links[i];
    const std::string what = name_of("link", static_cast<Index>(count_of(data.links) + i));
    check_link(what, link, first_of_bodies + edit.new_bodies.vertex_count());
    for (const Index v : {link.first, link.second}) {
      if (!has_tissue(v)) {
        throw InvalidArgument(what + " refers to vertex " + std::to_string(v) +
                              ", which has no tissue left to hold it");
      }
    }
  }
}

// Vertices that an edit leaves without tissue, ascending.
// @param vertices  replaced
void find_stopping(const TissueData& data, const TopologyEdit& edit, std::vector<Index>& vertices) {
  vertices.clear();
  const auto add_corners = [&](Index tet) {
    vertices.insert(vertices.end(), data.tets[tet].begin(), data.tets[tet].end());
  };
  std::ranges::for_each(edit.remove_tets, add_corners);
  for (const CornerMove& move : edit.corner_moves) {
    vertices.push_back(move.from);
  }
  for (const Index triangle : edit.remove_triangles) {
    vertices.insert(vertices.end(), data.triangles[triangle].begin(),
                    data.triangles[triangle].end());
  }
  for (const TriangleMove& move : edit.triangle_moves) {
    vertices.push_back(move.from);
  }
  std::pmr::vector<Index> parents(data.scratch.get()), kept(data.scratch.get());
  for (const NewTet& tet : edit.new_tets) {
    parents.push_back(tet.parent);
    kept.insert(kept.end(), tet.vertices.begin(), tet.vertices.end());
  }
  std::ranges::sort(parents);
  parents.erase(std::unique(parents.begin(), parents.end()), parents.end());
  std::ranges::for_each(parents, add_corners);
  std::ranges::sort(kept);
  std::ranges::sort(vertices);
  auto stopping = vertices.begin();
  for (auto first = vertices.begin(); first != vertices.end();) {
    const auto last = std::upper_bound(first, vertices.end(), *first);
    const auto lost = static_cast<std::size_t>(last - first);
    const std::size_t had = data.vertex_tets[*first].size() + data.triangles_at(*first).size();
    if (lost == had && !std::ranges::binary_search(kept, *first)) {
      *stopping++ = *first;
    }
    first = last;
  }
  vertices.erase(stopping, vertices.end());
  for (const Index body : edit.remove_bodies) {
    for_each_vertex_of(data, body, [&](Index v) {
      if (data.masses[v] > 0) {
        vertices.push_back(v);
      }
    });
  }
  std::ranges::sort(vertices);
}

// Which vertices are fixed and which no longer.
// @param stopping  ascending
void check_fixing(const TissueData& data, const TopologyEdit& edit,
                  std::span<const Index> stopping) {
  std::pmr::vector<Index> named(data.scratch.get());
  const auto check = [&](Index v, bool is_to_be_fixed) {
    const std::size_t count = count_of(data.rest_positions);
    if (v < 0 || static_cast<std::size_t>(v) >= count) {
      throw InvalidArgument(name_of("vertex", v) + " does not exist; ids must be in [0, " +
                            std::to_string(count) + ")");
    }
    if (!(data.masses[v] > 0) || std::ranges::binary_search(stopping, v)) {
      throw InvalidArgument(name_of("vertex", v) + " has no tissue left to be " +
                            (is_to_be_fixed ? "fixed" : "let go"));
    }
    if ((data.fixed[v] != 0) == is_to_be_fixed) {
      throw InvalidArgument(name_of("vertex", v) +
                            (is_to_be_fixed ? " is fixed already" : " is not fixed"));
    }
    named.push_back(v);
  };
  std::ranges::for_each(edit.fix_vertices, [&](Index v) { check(v, true); });
  std::ranges::for_each(edit.unfix_vertices, [&](Index v) { check(v, false); });
  std::ranges::sort(named);
  const auto twice = std::adjacent_find(named.begin(), named.end());
  if (twice != named.end()) {
    throw InvalidArgument(name_of("vertex", *twice) + " is listed twice in one edit");
  }
}

}  // namespace

void check_edit(TissueData& data, const TopologyEdit& edit) {
  check_removals(data, edit);
  check_rest_values(data, edit);
  check_stiffnesses(data, edit);
  check_fibres(data, edit);
  check_link_lengths(data, edit);
  check_new_vertices(data, edit);
  if (!edit.corner_moves.empty() || !edit.link_moves.empty()) {
    check_moves(data, edit);
  }
  if (!edit.triangle_moves.empty()) {
    check_triangle_moves(data, edit);
  }
  if (!edit.new_tets.empty()) {
    check_new_tets(data, edit);
  }
  check_use_of_new_vertices(data, edit);
  check_new_bodies(data, edit);
  find_stopping(data, edit, data.buffer);
  check_new_links(data, edit, data.buffer);
  check_fixing(data, edit, data.buffer);
}

}  // namespace pbdsurg
