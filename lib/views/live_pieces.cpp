// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/live_pieces.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/tissue/renumber.h"

namespace pbdsurg {
namespace {

constexpr char kWho[] = "live pieces";  // in errors

// Of what has merged, parts or groups.
template <class Node>
Index find_root(std::vector<Node>& nodes, Index i) {
  while (nodes[i].parent != i) {
    nodes[i].parent = nodes[nodes[i].parent].parent;  // path halving
    i = nodes[i].parent;
  }
  return i;
}

}  // namespace

LivePieces::LivePieces(const Tissue& tissue) {
  const std::span<const Tet> tets = tissue.tets();
  const auto tet_count = static_cast<Index>(tets.size());
  const Index vertex_count = tissue.vertex_count();
  tets_ =
      UndoArray(std::vector<PieceTet>(tets.size(), {kInvalidIndex, kInvalidIndex, kInvalidIndex}));
  part_of_.assign(static_cast<std::size_t>(vertex_count), kInvalidIndex);
  next_.resize(static_cast<std::size_t>(vertex_count));
  leaving_.assign(tets.size(), false);

  std::vector<Tet> live;
  for (Index t = 0; t < tet_count; ++t) {
    if (tissue.is_tet_alive(t)) {
      live.push_back(tets[t]);
    }
  }
  const Components components = find_components(vertex_count, live);
  add_pieces(tissue, components, 0);
  for (Index t = 0; t < tet_count; ++t) {
    if (tissue.is_tet_alive(t)) {
      add_tet(components.of_vertex[tets[t][0]], t);
    }
  }
  first_freed_ = first_freed_before_ = count();
  tissue.add_follower(*this, FollowerRank::view);
}

const LivePieces::Piece& LivePieces::checked(Index piece) const {
  check_id("piece", piece, static_cast<std::size_t>(count()));
  return pieces_[piece];
}

Index LivePieces::piece_of(Index tet) const {
  check_id("tet", tet, static_cast<std::size_t>(tets_.size()));
  return tets_[tet].piece;
}

std::vector<Index> LivePieces::tets(Index piece) const {
  std::vector<Index> result;
  for (Index t = checked(piece).first_tet; t != kInvalidIndex; t = tets_[t].next) {
    result.push_back(t);
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::size_t LivePieces::memory_bytes() const noexcept {
  const auto bytes = [](const auto&... lists) {
    return (... + (lists.capacity() * sizeof(lists[0])));
  };
  return pieces_.memory_bytes() + tets_.memory_bytes() + leaving_.capacity() / 8 +
         bytes(parts_, part_of_, next_, seen_, active_, groups_, rests_, freed_);
}

Crumbs LivePieces::add_crumbs(const Tissue& tissue, TopologyEdit& edit, Index smallest) {
  tissue.check_follower(*this, kWho);
  std::vector<Index> kept;  // ascending
  for (const CornerMove& move : edit.corner_moves) {
    kept.push_back(move.tet);
  }
  for (const NewTet& tet : edit.new_tets) {
    kept.push_back(tet.parent);
  }
  const auto keep = [&](Index v) {
    if (v >= 0 && v < tissue.vertex_count()) {
      for_each_tet_at(tissue, v, [&](Index t) { kept.push_back(t); });
    }
  };
  for (const Link& link : edit.new_links) {
    keep(link.first), keep(link.second);
  }
  std::ranges::for_each(edit.fix_vertices, keep);
  std::ranges::for_each(edit.unfix_vertices, keep);
  std::sort(kept.begin(), kept.end());

  const std::size_t asked = edit.remove_tets.size();
  rests_.resize(static_cast<std::size_t>(count()));
  for (const Index t : edit.remove_tets) {
    if (t >= 0 && t < tets_.size() && tets_[t].piece != kInvalidIndex && !leaving_[t]) {
      leaving_[t] = true;
      ++rests_[tets_[t].piece].leaving;
      start_searches(tissue.tets()[t], tets_[t].piece, add_group());
    }
  }
  find_freed_parts(tissue);
  Crumbs crumbs;
  for (const Index id : freed_) {
    const Part& part = parts_[id];
    if (part.tet_count >= smallest) {
      continue;
    }
    const std::size_t before = edit.remove_tets.size();
    bool stays = false;
    for (Index v = part.done.first; v != kInvalidIndex; v = next_[v]) {
      for_each_tet_at(tissue, v, [&](Index t) {
        if (tissue.tets()[t][0] == v) {
          edit.remove_tets.push_back(t);
          stays |= std::binary_search(kept.begin(), kept.end(), t);
        }
      });
    }
    if (stays) {
      edit.remove_tets.resize(before);
    } else {
      ++crumbs.parts;
      crumbs.tets += part.tet_count;
    }
  }
  for (std::size_t i = 0; i < asked; ++i) {
    if (const Index t = edit.remove_tets[i]; t >= 0 && t < tets_.size()) {
      leaving_[t] = false;
    }
  }
  clear_searches();
  return crumbs;
}

void LivePieces::renumber(const Tissue& tissue, const Renumbering& ids) noexcept {
  std::vector<Piece> pieces(pieces_.values().begin(), pieces_.values().end());
  for (Piece& piece : pieces) {
    piece.body = new_id(piece.body, ids.bodies);
    piece.first_tet = new_id(piece.first_tet, ids.tets);
  }
  pieces_ = UndoArray(std::move(pieces));
  tets_ = UndoArray(moved<PieceTet>(ids.tets, tissue.tets().size(), [&](Index t) {
    const auto [piece, next, previous] = tets_[t];
    return PieceTet{piece, new_id(next, ids.tets), new_id(previous, ids.tets)};
  }));
  const auto vertex_count = static_cast<std::size_t>(tissue.vertex_count());
  part_of_.assign(vertex_count, kInvalidIndex);
  next_.resize(vertex_count);
  leaving_.assign(tissue.tets().size(), false);
}

void LivePieces::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  const TopologyEdit& edit = change.edit;
  pieces_.begin_edit();
  tets_.begin_edit();
  rests_.resize(static_cast<std::size_t>(count()));

  const std::span<const Tet> tets = tissue.tets();
  part_of_.resize(static_cast<std::size_t>(tissue.vertex_count()), kInvalidIndex);
  next_.resize(part_of_.size(), kInvalidIndex);
  for (const NewTet& tet : edit.new_tets) {
    const Index id = tets_.size();
    const Index piece = tets_[tet.parent].piece;
    tets_.push_back({kInvalidIndex, kInvalidIndex, kInvalidIndex});
    leaving_.push_back(false);
    add_tet(piece, id);
    const Index group = add_group();
    start_searches(tets[tet.parent], piece, group);
    start_searches(tets[id], piece, group);
  }
  const auto count_anchors = [&](std::span<const Index> vertices, Index growth) {
    for (const Index v : vertices) {
      if (const std::span<const Index> at = tissue.tets_at(v); !at.empty()) {
        const Index id = tets_[at.front()].piece;  // which it may leave below
        Piece piece = pieces_[id];
        piece.anchor_count += growth;
        pieces_.set(id, piece);
      }
    }
  };
  count_anchors(edit.fix_vertices, 1);
  count_anchors(edit.unfix_vertices, -1);
  for (const CornerMove& move : edit.corner_moves) {
    const Index piece = tets_[move.tet].piece;
    const Index group = add_group();
    start_search(move.from, piece, group);
    start_searches(tets[move.tet], piece, group);
  }
  for (const Index t : change.removed_tets) {
    start_searches(tets[t], tets_[t].piece, add_group());
    remove_tet(t);
  }
  const auto count_anchor = [&](Index v, Index growth) {
    if (tissue.is_fixed(v) && part_of_[v] != kInvalidIndex) {
      const Index id = parts_[part_of_[v]].piece;
      Piece piece = pieces_[id];
      piece.anchor_count += growth;
      pieces_.set(id, piece);
    }
  };
  for (const Index v : change.emptied_vertices) {
    count_anchor(v, -1);
  }
  for (Index i = 0; i < static_cast<Index>(edit.new_vertices.size()); ++i) {
    count_anchor(change.first_new_vertex + i, 1);
  }

  find_freed_parts(tissue);
  first_freed_before_ = first_freed_;
  first_freed_ = count();
  for (const Index part : freed_) {
    free_part(tissue, parts_[part]);
  }
  clear_searches();
  add_bodies(tissue, edit.new_bodies);
}

// Pieces that there are none of yet.
// @param components  of vertices from the first on
void LivePieces::add_pieces(const Tissue& tissue, const Components& components,
                            Index first_vertex) {
  const Index first_piece = count();
  for (Index i = 0; i < components.count; ++i) {
    pieces_.push_back({kInvalidIndex, 0, 0, kInvalidIndex});
  }
  for (std::size_t i = 0; i < components.of_vertex.size(); ++i) {
    if (components.of_vertex[i] != kInvalidIndex) {
      const Index v = first_vertex + static_cast<Index>(i);
      const Index id = first_piece + components.of_vertex[i];
      Piece piece = pieces_[id];
      piece.body = tissue.body_of_vertex(v);
      piece.anchor_count += tissue.is_fixed(v) ? 1 : 0;
      pieces_.set(id, piece);
    }
  }
}

// Pieces of bodies that came in: their vertices and tetrahedra are the last.
void LivePieces::add_bodies(const Tissue& tissue, const Scene& bodies) {
  const Index first_vertex = tissue.vertex_count() - bodies.vertex_count();
  const Index first_piece = count();
  const Components components = find_components(bodies.vertex_count(), bodies.tets());
  add_pieces(tissue, components, first_vertex);
  for (const Tet& tet : bodies.tets()) {
    const Index id = tets_.size();
    tets_.push_back({kInvalidIndex, kInvalidIndex, kInvalidIndex});
    leaving_.push_back(false);
    add_tet(first_piece + components.of_vertex[tet[0]], id);
  }
}

void LivePieces::undo(const Tissue& tissue, const TissueChange&) noexcept {
  pieces_.undo();
  tets_.undo();
  part_of_.resize(static_cast<std::size_t>(tissue.vertex_count()));
  next_.resize(part_of_.size());
  leaving_.resize(static_cast<std::size_t>(tets_.size()));
  first_freed_ = first_freed_before_;
}

// Calls visit(tet) for the tetrahedra that are at a vertex now and stay.
template <class Visit>
void LivePieces::for_each_tet_at(const Tissue& tissue, Index vertex, Visit visit) const {
  for (const Index t : tissue.tets_at(vertex)) {
    if (!leaving_[t]) {
      visit(t);
    }
  }
}

void LivePieces::add_tet(Index piece, Index tet) {
  Piece changed = pieces_[piece];
  if (const Index next = changed.first_tet; next != kInvalidIndex) {
    tets_.set(next, {piece, tets_[next].next, tet});
  }
  tets_.set(tet, {piece, changed.first_tet, kInvalidIndex});
  ++changed.tet_count;
  changed.first_tet = tet;
  pieces_.set(piece, changed);
}

void LivePieces::remove_tet(Index tet) {
  const auto [piece, next, previous] = tets_[tet];
  Piece changed = pieces_[piece];
  if (next != kInvalidIndex) {
    tets_.set(next, {piece, tets_[next].next, previous});
  }
  if (previous != kInvalidIndex) {
    tets_.set(previous, {piece, next, tets_[previous].previous});
  } else {
    changed.first_tet = next;
  }
  tets_.set(tet, {kInvalidIndex, kInvalidIndex, kInvalidIndex});
  --changed.tet_count;
  pieces_.set(piece, changed);
}

// Makes a piece of its own of a part that is searched through.
void LivePieces::free_part(const Tissue& tissue, const Part& part) {
  const Index id = count();
  pieces_.push_back({pieces_[part.piece].body, 0, 0, kInvalidIndex});
  Index anchors = 0;
  for (Index v = part.done.first; v != kInvalidIndex; v = next_[v]) {
    anchors += tissue.is_fixed(v) ? 1 : 0;
    for_each_tet_at(tissue, v, [&](Index t) {
      if (tissue.tets()[t][0] == v) {
        remove_tet(t);
        add_tet(id, t);
      }
    });
  }
  for (const auto& [piece, change] : {std::pair(part.piece, -anchors), std::pair(id, anchors)}) {
    Piece changed = pieces_[piece];
    changed.anchor_count += change;
    pieces_.set(piece, changed);
  }
}

void LivePieces::append(VertexList& list, Index vertex) {
  next_[vertex] = kInvalidIndex;
  join(list, {vertex, vertex});
}

void LivePieces::join(VertexList& list, const VertexList& other) {
  if (list.first == kInvalidIndex) {
    list = other;
  } else if (other.first != kInvalidIndex) {
    next_[list.last] = other.first;
    list.last = other.last;
  }
}

Index LivePieces::add_group() {
  const auto id = static_cast<Index>(groups_.size());
  groups_.push_back({id});
  return id;
}

void LivePieces::start_search(Index vertex, Index piece, Index group) {
  group = find_root(groups_, group);
  if (part_of_[vertex] != kInvalidIndex) {
    merge_groups(group, find_root(groups_, parts_[part_of_[vertex]].group));
    return;
  }
  const auto id = static_cast<Index>(parts_.size());
  parts_.push_back({id, piece, group});
  active_.push_back(id);
  ++groups_[group].active;
  part_of_[vertex] = id;
  seen_.push_back(vertex);
  append(parts_[id].waiting, vertex);
}

void LivePieces::start_searches(const Tet& vertices, Index piece, Index group) {
  for (const Index v : vertices) {
    start_search(v, piece, group);
  }
}

// Both must be roots.
void LivePieces::merge_groups(Index a, Index b) {
  if (a != b) {
    groups_[b].parent = a;
    groups_[a].active += groups_[b].active;
  }
}

// Both must be roots.
void LivePieces::merge(Index into, Index part) {
  parts_[part].parent = into;
  join(parts_[into].done, parts_[part].done);
  join(parts_[into].waiting, parts_[part].waiting);
  const Index group = find_root(groups_, parts_[into].group);
  merge_groups(group, find_root(groups_, parts_[part].group));
  --groups_[group].active;
}

// Visits one waiting vertex.
void LivePieces::advance(const Tissue& tissue, Index part) {
  VertexList& waiting = parts_[part].waiting;
  const Index vertex = waiting.first;
  waiting.first = next_[vertex];
  append(parts_[part].done, vertex);
  for_each_tet_at(tissue, vertex, [&](Index t) {
    for (const Index v : tissue.tets()[t]) {
      if (part_of_[v] == kInvalidIndex) {
        part_of_[v] = part;
        seen_.push_back(v);
        append(waiting, v);
      } else if (const Index other = find_root(parts_, part_of_[v]); other != part) {
        merge(part, other);
      }
    }
  });
}

// Each tetrahedron counts at its first corner.
void LivePieces::count_tets(const Tissue& tissue, Part& part) const {
  for (Index v = part.done.first; v != kInvalidIndex; v = next_[v]) {
    for_each_tet_at(tissue, v, [&](Index t) {
      if (tissue.tets()[t][0] == v) {
        part.smallest_tet = part.tet_count == 0 ? t : std::min(part.smallest_tet, t);
        ++part.tet_count;
      }
    });
  }
}

// Runs the searches; then all parts in freed_ are searched through, in the order of their smallest
// tetrahedra.
void LivePieces::find_freed_parts(const Tissue& tissue) {
  freed_.clear();
  while (!active_.empty()) {
    std::size_t still_active = 0;
    for (const Index id : active_) {
      Part& part = parts_[id];
      if (part.parent != id) {
        continue;
      }
      Group& group = groups_[find_root(groups_, part.group)];
      if (group.active == 1) {
        rests_[part.piece].part = id;
      } else if (part.waiting.first == kInvalidIndex) {
        --group.active;
        count_tets(tissue, part);
        if (part.tet_count > 0) {
          freed_.push_back(id);
        }
      } else {
        advance(tissue, id);
        active_[still_active++] = id;
      }
    }
    active_.resize(still_active);
  }

  // so far without the parts that were left; the largest of each piece stays with it
  const auto is_before = [&](Index a, Index b) {
    return std::tuple(parts_[a].piece, -parts_[a].tet_count, parts_[a].smallest_tet) <
           std::tuple(parts_[b].piece, -parts_[b].tet_count, parts_[b].smallest_tet);
  };
  std::sort(freed_.begin(), freed_.end(), is_before);
  for (std::size_t i = 0; i < freed_.size();) {
    const std::size_t largest = i;
    const Index piece = parts_[freed_[i]].piece;
    Index rest_count = pieces_[piece].tet_count - rests_[piece].leaving;
    for (; i < freed_.size() && parts_[freed_[i]].piece == piece; ++i) {
      rest_count -= parts_[freed_[i]].tet_count;
    }
    if (rest_count > parts_[freed_[largest]].tet_count) {
      continue;
    }
    const Index rest = find_root(parts_, rests_[piece].part);
    while (parts_[rest].waiting.first != kInvalidIndex) {
      advance(tissue, rest);
    }
    count_tets(tissue, parts_[rest]);
    if (is_before(freed_[largest], rest)) {
      freed_[largest] = rest;
    }
  }
  std::erase_if(freed_, [&](Index part) { return parts_[part].tet_count == 0; });
  std::sort(freed_.begin(), freed_.end(),
            [&](Index a, Index b) { return parts_[a].smallest_tet < parts_[b].smallest_tet; });
}

void LivePieces::clear_searches() {
  for (const Index v : seen_) {
    part_of_[v] = kInvalidIndex;
  }
  for (const Part& part : parts_) {
    rests_[part.piece] = {};
  }
  visited_count_ = static_cast<Index>(seen_.size());
  seen_.clear();
  parts_.clear();
  groups_.clear();
}

}  // namespace pbdsurg
