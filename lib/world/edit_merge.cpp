// SPDX-License-Identifier: Apache-2.0
#include "world/edit_merge.h"

#include <algorithm>
#include <vector>

namespace pbdsurg {
namespace {

bool adds(const TopologyEdit& edit) noexcept {
  return !edit.new_vertices.empty() || !edit.new_tets.empty() || !edit.new_links.empty() ||
         !edit.new_bodies.bodies().empty();
}

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

}  // namespace

bool is_empty(const TopologyEdit& edit) noexcept {
  return !adds(edit) && edit.remove_tets.empty() && edit.remove_links.empty() &&
         edit.remove_bodies.empty() && edit.rest_lengths.empty() && edit.rest_volumes.empty() &&
         edit.corner_moves.empty() && edit.link_moves.empty();
}

bool merge(TopologyEdit& edit, const TopologyEdit& request) {
  if (adds(edit) && adds(request)) {
    return false;
  }
  append_new(edit.remove_tets, request.remove_tets);
  append_new(edit.remove_links, request.remove_links);
  append_new(edit.remove_bodies, request.remove_bodies);
  append(edit.rest_lengths, request.rest_lengths);
  append(edit.rest_volumes, request.rest_volumes);
  append(edit.corner_moves, request.corner_moves);
  append(edit.link_moves, request.link_moves);
  if (adds(request)) {
    edit.new_vertices = request.new_vertices;
    edit.new_tets = request.new_tets;
    edit.new_links = request.new_links;
    edit.new_bodies = request.new_bodies;
  }
  return true;
}

}  // namespace pbdsurg
