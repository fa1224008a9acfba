// SPDX-License-Identifier: Apache-2.0
#include "edit/edit_checks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

#include "solver/scene_checks.h"
#include "solver/vertex_method.h"

namespace pbdsurg {
namespace {

std::string name_of(const char* what, Index id) {
  return std::string(what) + " " + std::to_string(id);
}

// Ids must be in range, alive and listed once. Sorts them.
template <class IsAlive>
void check_ids(const char* what, std::vector<Index>& ids, std::size_t count, IsAlive is_alive) {
  for (const Index id : ids) {
    if (id < 0 || static_cast<std::size_t>(id) >= count) {
      throw InvalidArgument(name_of(what, id) + " does not exist; ids must be in [0, " +
                            std::to_string(count) + ")");
    }
    if (!is_alive(id)) {
      throw InvalidArgument(name_of(what, id) + " was removed before");
    }
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

void check_removals(SolverData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.edit_buffer;
  ids = edit.remove_tets;
  check_ids("tet", ids, data.tets.size(), [&](Index t) { return data.tet_alive[t]; });
  ids = edit.remove_links;
  check_ids("link", ids, data.links.size(), [&](Index l) { return data.is_link_alive(l); });
}

void check_rest_values(SolverData& data, const TopologyEdit& edit) {
  std::vector<Index>& ids = data.edit_buffer;
  ids.clear();
  for (const RestLengthChange& change : edit.rest_lengths) {
    check_rest("edge", change.edge, "rest length", change.rest_length);
    ids.push_back(change.edge);
  }
  check_ids("edge", ids, data.edges.size(), [&](Index e) { return data.edge_tets[e] > 0; });
  for (const Index e : ids) {
    if (!data.distances.is_alive(data.distance_ids.of_edge(e))) {
      throw InvalidArgument(name_of("edge", e) +
                            " belongs to a Neo-Hookean body, whose edges have no rest length");
    }
  }
  ids.clear();
  for (const RestVolumeChange& change : edit.rest_volumes) {
    check_rest("tet", change.tet, "rest volume", change.rest_volume);
    ids.push_back(change.tet);
  }
  check_ids("tet", ids, data.tets.size(), [&](Index t) { return data.tet_alive[t]; });
  for (const Index t : ids) {
    if (!data.volumes.is_alive(t) && !data.neo_hookeans.is_alive(t)) {
      throw InvalidArgument(name_of("tet", t) + " belongs to a body without volume constraints");
    }
  }
}

// @param stopping  ascending
void check_new_links(const SolverData& data, const TopologyEdit& edit,
                     std::span<const Index> stopping) {
  for (std::size_t i = 0; i < edit.new_links.size(); ++i) {
    const Link& link = edit.new_links[i];
    const std::string what = name_of("link", static_cast<Index>(data.links.size() + i));
    check_link(what, link, static_cast<Index>(data.particles.size()));
    check_vertex_link(data.options, what, link);
    for (const Index v : {link.first, link.second}) {
      if (!(data.vertex_masses[v] > 0) || std::ranges::binary_search(stopping, v)) {
        throw InvalidArgument(what + " refers to vertex " + std::to_string(v) +
                              ", which has no tissue left to hold it");
      }
    }
  }
}

}  // namespace

void check_edit(SolverData& data, const TopologyEdit& edit) {
  if (!edit.new_vertices.empty() || !edit.corner_moves.empty() || !edit.link_moves.empty() ||
      !edit.new_tets.empty()) {
    throw InvalidArgument("under construction on this branch");
  }
  check_removals(data, edit);
  check_rest_values(data, edit);
  find_stopping(data, edit, data.edit_buffer);
  check_new_links(data, edit, data.edit_buffer);
}

void find_stopping(const SolverData& data, const TopologyEdit& edit, std::vector<Index>& vertices) {
  vertices.clear();
  for (const Index t : edit.remove_tets) {
    vertices.insert(vertices.end(), data.tets[t].begin(), data.tets[t].end());
  }
  std::ranges::sort(vertices);
  auto kept = vertices.begin();
  for (auto first = vertices.begin(); first != vertices.end();) {
    const auto last = std::upper_bound(first, vertices.end(), *first);
    const auto lost = static_cast<std::size_t>(last - first);
    if (lost == data.vertex_tets[*first].size()) {
      *kept++ = *first;
    }
    first = last;
  }
  vertices.erase(kept, vertices.end());
}

}  // namespace pbdsurg
