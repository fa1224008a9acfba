// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_blocks.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "pbdsurg/coloring/constraint_vertices.h"

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/vertex_kernel.h"

namespace pbdsurg {
namespace {

template <std::size_t kArity>
IndexLists lists_at(Index vertex_count, std::span<const std::array<Index, kArity>> elements) {
  return find_vertex_constraints({elements, vertex_count});
}

template <class Element>
auto vertices_of(std::span<const Element> elements) {
  std::vector<decltype(Element::vertices)> vertices;
  vertices.reserve(elements.size());
  for (const Element& element : elements) {
    vertices.push_back(element.vertices);
  }
  return vertices;
}

}  // namespace

VertexBlocks::VertexBlocks(const std::vector<bool>& moves, std::vector<VertexTet> tets,
                           std::vector<VertexSpring> springs, std::vector<VertexHinge> hinges,
                           const ColoringOptions& coloring, float unit, bool at_once)
    : tets_(std::move(tets)),
      given_(std::move(springs)),
      given_hinges_(std::move(hinges)),
      places_(moves.size()),
      needs_(moves.size()),
      is_touched_(moves.size(), false) {
  unit_ = unit;
  const auto vertex_count = static_cast<Index>(moves.size());
  tets_at_ = lists_at(vertex_count, std::span<const Tet>(vertices_of(tets_.values())));
  springs_at_ = lists_at(vertex_count, std::span<const Edge>(vertices_of(given_.values())));
  if (given_hinges_.size() > 0) {
    hinges_at_ = lists_at(
        vertex_count, std::span<const std::array<Index, 4>>(vertices_of(given_hinges_.values())));
  }
  const auto is_positive = [](float damping) { return damping > 0; };
  const auto is_damped = [](const auto& element) { return element.damping > 0; };
  has_damping_ = std::ranges::any_of(tets_.values(),
                                     [&](const VertexTet& tet) {
                                       return is_positive(tet.volume_damping) ||
                                              std::ranges::any_of(tet.edge_damping, is_positive);
                                     }) ||
                 std::ranges::any_of(given_.values(), is_damped) ||
                 std::ranges::any_of(given_hinges_.values(), is_damped);

  // Blocks last as long as their busiest vertex, so alike ones go together.
  std::vector<Index> color_of(moves.size(), 0);
  if (!at_once) {
    color_of = color_vertices(moves, coloring).color_of;
  }
  std::vector<Index> order;
  for (Index v = 0; v < vertex_count; ++v) {
    if (!moves[v]) {
      continue;
    }
    order.push_back(v);
    find_neighborhood(v);
  }
  const auto key = [&](Index v) {
    const Rows& needs = needs_[v];
    return std::tuple(color_of[v], needs.volumes, needs.springs, needs.pulls, needs.hinges, v);
  };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
  const std::span<const Index> all(order);
  for (std::size_t first = 0; first < all.size();) {
    const Index color = color_of[all[first]];
    std::size_t last = first;
    while (last < all.size() && last - first < kBlockLanes && color_of[all[last]] == color) {
      ++last;
    }
    // a colour may have lost all its vertices to those that are fixed
    first_block_.resize(static_cast<std::size_t>(color) + 1, block_count());
    append_block(all.subspan(first, last - first));
    first = last;
  }
  first_block_.push_back(block_count());
  touched_.reserve(moves.size());
}

Coloring VertexBlocks::color_vertices(const std::vector<bool>& moves,
                                      const ColoringOptions& options) const {
  IndexLists free;  // vertices of each tetrahedron and spring
  const auto append = [&](const auto& elements) {
    for (const auto& element : elements) {
      for (const Index v : element.vertices) {
        if (moves[v]) {
          free.entries.push_back(v);
        }
      }
      free.offsets.push_back(static_cast<Index>(free.entries.size()));
    }
  };
  append(tets_.values());
  append(given_.values());
  append(given_hinges_.values());
  const IndexLists blocks =
      find_vertex_constraints(ConstraintVertices(free, static_cast<Index>(moves.size())));
  return color_constraints(ConstraintVertices(blocks, free.list_count()), options);
}

void VertexBlocks::append_block(std::span<const Index> vertices) {
  VertexBlock block;
  block.lane_count = static_cast<Index>(vertices.size());
  block.is_damped = false;
  for (Index lane = 0; lane < kBlockLanes; ++lane) {
    block.corners[lane] = offset_of(vertices[std::min(lane, block.lane_count - 1)]);
  }
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    places_[vertices[lane]] = {block_count(), lane};
  }
  block.pulls.first = static_cast<Index>(pulls_.size());
  block.springs.first = static_cast<Index>(springs_.size());
  block.volumes.first = static_cast<Index>(volumes_.size());
  block.hinges.first = static_cast<Index>(hinges_.size());
  strip_rooms_.push_back({static_cast<Index>(strips_.size()), 0});
  for (const Index v : vertices) {
    strip_rooms_.back().count = std::max(strip_rooms_.back().count, needs_[v].strips);
  }
  count_rows(block);
  blocks_.push_back(block);

  pulls_.resize(static_cast<std::size_t>(block.pulls.first + block.pulls.count));
  springs_.resize(static_cast<std::size_t>(block.springs.first + block.springs.count));
  volumes_.resize(static_cast<std::size_t>(block.volumes.first + block.volumes.count));
  hinges_.resize(static_cast<std::size_t>(block.hinges.first + block.hinges.count));
  strips_.resize(strips_.size() + static_cast<std::size_t>(strip_rooms_.back().count));
  if (has_damping_) {
    damped_springs_.resize(springs_.size());
    damped_volumes_.resize(volumes_.size());
    damped_hinges_.resize(hinges_.size());
  }
  const auto is_damped = [](const auto& row) { return row.damping > 0; };
  for (const Index v : vertices) {
    find_neighborhood(v);
    write_rows(v);
    const auto& [pulls, springs, volumes, hinges] = neighborhood_;
    blocks_.back().is_damped |= std::any_of(springs.begin(), springs.end(), is_damped) ||
                                std::any_of(volumes.begin(), volumes.end(), is_damped) ||
                                std::any_of(hinges.begin(), hinges.end(), is_damped);
  }
}

void VertexBlocks::count_rows(VertexBlock& block) noexcept {
  Index strips = 0;
  block.pulls.count = block.springs.count = block.volumes.count = block.hinges.count = 0;
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    const Rows& needs = needs_[place_at(block.corners[lane])];
    block.pulls.count = std::max(block.pulls.count, needs.pulls);
    block.springs.count = std::max(block.springs.count, needs.springs);
    block.volumes.count = std::max(block.volumes.count, needs.volumes);
    block.hinges.count = std::max(block.hinges.count, needs.hinges);
    strips = std::max(strips, needs.strips);
  }
  // a face that goes may part a strip in two, which needs more rows than there were
  const RowRange room = strip_rooms_[places_[place_at(block.corners[0])].block];
  block.strips = {room.first, strips <= room.count ? room.count : 0};
}

void VertexBlocks::find_neighborhood(Index vertex) {
  auto& [pulls, springs, volumes, hinges] = neighborhood_;
  pulls.clear();
  springs.clear();
  volumes.clear();
  hinges.clear();
  const auto is_damped = [&](const Pull& pull) { return pull.damping > 0; };
  for (const Index t : tets_at_[vertex]) {
    const VertexTet& tet = tets_[t];
    const auto here = std::find(tet.vertices.begin(), tet.vertices.end(), vertex);
    const auto corner = static_cast<int>(here - tet.vertices.begin());
    if (tet.stiffness > 0 || tet.volume_damping > 0) {
      const auto& face = kTetTriangles[corner];
      volumes.push_back({{tet.vertices[face[0]], tet.vertices[face[1]], tet.vertices[face[2]]},
                         tet.stiffness,
                         tet.target,
                         tet.volume_damping});
    }
    const bool pulls_edges = std::any_of(tet.weights.begin(), tet.weights.end(),
                                         [](float weight) { return weight != 0; });
    for (std::size_t e = 0; pulls_edges && e < kTetEdges.size(); ++e) {
      const auto [a, b] = kTetEdges[e];
      if (a == corner || b == corner) {
        pulls.push_back({tet.vertices[a + b - corner], tet.weights[e], tet.edge_damping[e]});
      }
    }
  }
  // one for each neighbour; a stable order, because sums of floats depend on it
  std::stable_sort(pulls.begin(), pulls.end(),
                   [](const Pull& a, const Pull& b) { return a.neighbor < b.neighbor; });
  std::size_t count = 0;
  for (const Pull& pull : pulls) {
    if (count > 0 && pulls[count - 1].neighbor == pull.neighbor) {
      pulls[count - 1].weight += pull.weight;
      pulls[count - 1].damping += pull.damping;
    } else {
      pulls[count++] = pull;
    }
  }
  pulls.resize(count);

  for (const Index s : springs_at_[vertex]) {
    const VertexSpring& spring = given_[s];
    const Index other = spring.vertices[spring.vertices[0] == vertex ? 1 : 0];
    if (spring.stiffness > 0 || spring.damping > 0) {
      springs.push_back({other, spring.stiffness, spring.rest, spring.damping});
    }
    if (spring.limit_stiffness > 0) {
      springs.push_back({other, spring.limit_stiffness, -spring.limit, 0});
    }
  }
  if (std::any_of(pulls.begin(), pulls.end(), is_damped)) {
    for (const Pull& pull : pulls) {
      springs.push_back({pull.neighbor, 0.0F, 0.0F, pull.damping});
    }
  }
  for (const Index h : hinges_at(vertex)) {
    const VertexHinge& hinge = given_hinges_[h];
    if (!(hinge.stiffness > 0)) {
      continue;
    }
    std::array<Index, 4> v = hinge.vertices;
    if (vertex == v[1] || vertex == v[3]) {  // by half a turn
      v = {v[1], v[0], v[3], v[2]};
    }
    const bool is_opposite = vertex == v[2];
    hinges.push_back({{v[1], is_opposite ? v[0] : v[2], v[3]},
                      is_opposite,
                      hinge.stiffness,
                      hinge.rest,
                      hinge.damping});
  }
  find_strip();
  needs_[vertex] = {static_cast<Index>(pulls.size()), static_cast<Index>(springs.size()),
                    static_cast<Index>(volumes.size()), static_cast<Index>(hinges.size()),
                    static_cast<Index>(strip_entries_.size())};
}

void VertexBlocks::find_strip() {
  strip_entries_.clear();
  if (has_damping_) {
    return;
  }
  faces_.clear();
  for (const Volume& volume : neighborhood_.volumes) {
    faces_.push_back(volume.face);
  }
  for (const auto& [corner, face, turns] : strip_.find(faces_)) {
    StripEntry entry{corner, 0, 1, 0};
    if (face != kInvalidIndex) {
      entry.stiffness = neighborhood_.volumes[face].stiffness / 36;
      entry.target = 6 * neighborhood_.volumes[face].target;
    }
    entry.target = turns ? -entry.target : entry.target;
    strip_entries_.push_back(entry);
  }
  for (const Pull& pull : neighborhood_.pulls) {
    auto entry = std::ranges::find(strip_entries_, pull.neighbor, &StripEntry::corner);
    if (entry == strip_entries_.end()) {
      entry = strip_entries_.insert(entry, {pull.neighbor, 0, 1, 0});
    }
    entry->weight = pull.weight;
  }
}

void VertexBlocks::write_rows(Index vertex) noexcept {
  const auto [block, lane] = places_[vertex];
  write_lane(blocks_[block], lane);
  const Index idle = blocks_[block].lane_count;
  for (Index i = idle; lane == idle - 1 && i < kBlockLanes; ++i) {
    write_lane(blocks_[block], i);
  }
}

void VertexBlocks::write_lane(const VertexBlock& block, Index lane) noexcept {
  const Index vertex = place_at(block.corners[lane]);
  const auto entry = [](const auto& list, Index i, const auto& padding) {
    return i < static_cast<Index>(list.size()) ? list[i] : padding;
  };
  for (Index i = 0; i < block.pulls.count; ++i) {
    const Pull pull = entry(neighborhood_.pulls, i, Pull{vertex, 0, 0});
    PullRow& row = pulls_[block.pulls.first + i];
    row.neighbors[lane] = offset_of(pull.neighbor);
    row.weights[lane] = pull.weight;
  }
  for (Index i = 0; i < block.springs.count; ++i) {
    const Spring spring = entry(neighborhood_.springs, i, Spring{vertex, 0, 0, 0});
    SpringRow& row = springs_[block.springs.first + i];
    row.neighbors[lane] = offset_of(spring.neighbor);
    row.stiffness[lane] = spring.stiffness;
    row.rest[lane] = spring.rest;
    if (has_damping_) {
      DampedRow& damped = damped_springs_[block.springs.first + i];
      damped.stiffness[lane] = spring.stiffness;
      damped.target[lane] = spring.rest;
      damped.damping[lane] = spring.damping;
    }
  }
  for (Index i = 0; i < block.volumes.count; ++i) {
    const Volume volume =
        entry(neighborhood_.volumes, i, Volume{{vertex, vertex, vertex}, 0, 0, 0});
    VolumeRow& row = volumes_[block.volumes.first + i];
    for (int k = 0; k < 3; ++k) {
      row.face[k][lane] = offset_of(volume.face[k]);
    }
    row.stiffness[lane] = volume.stiffness / 36;
    row.target[lane] = 6 * volume.target;
    if (has_damping_) {
      DampedRow& damped = damped_volumes_[block.volumes.first + i];
      damped.stiffness[lane] = row.stiffness[lane];
      damped.target[lane] = row.target[lane];
      damped.damping[lane] = volume.damping / 36;
    }
  }
  const RowRange room = strip_rooms_[places_[vertex].block];
  for (Index i = 0; i < room.count; ++i) {
    const StripEntry entry_here = entry(strip_entries_, i, StripEntry{vertex, 0, 1, 0});
    StripRow& row = strips_[room.first + i];
    row.corners[lane] = offset_of(entry_here.corner);
    row.stiffness[lane] = entry_here.stiffness;
    row.target[lane] = entry_here.target;
    row.weights[lane] = entry_here.weight;
  }
  for (Index i = 0; i < block.hinges.count; ++i) {
    const Bend hinge =
        entry(neighborhood_.hinges, i, Bend{{vertex, vertex, vertex}, false, 0, 0, 0});
    HingeRow& row = hinges_[block.hinges.first + i];
    for (int k = 0; k < 3; ++k) {
      row.neighbors[k][lane] = offset_of(hinge.neighbors[k]);
    }
    row.stiffness[lane] = hinge.stiffness;
    row.rest[lane] = hinge.rest;
    row.is_opposite[lane] = hinge.is_opposite ? 1.0F : 0.0F;
    if (has_damping_) {
      DampedRow& damped = damped_hinges_[block.hinges.first + i];
      damped.stiffness[lane] = hinge.stiffness;
      damped.target[lane] = hinge.rest;
      damped.damping[lane] = hinge.damping;
    }
  }
}

void VertexBlocks::touch(std::span<const Index> vertices) {
  for (const Index v : vertices) {
    if (places_[v].block != kInvalidIndex && !is_touched_[v]) {
      is_touched_[v] = true;
      touched_.push_back(v);
    }
  }
}

template <class Element>
void VertexBlocks::set(UndoArray<Element>& elements, Index id, const Element& terms) {
  elements.set(id, terms);
  touch(terms.vertices);
}

void VertexBlocks::set_tet(Index tet, const VertexTet& terms) {
  set(tets_, tet, terms);
}

void VertexBlocks::remove_tet(Index tet) {
  set_tet(tet, {.vertices = tets_[tet].vertices});
}

void VertexBlocks::set_spring_rest(Index spring, float rest) {
  VertexSpring changed = given_[spring];
  changed.rest = rest;
  set(given_, spring, changed);
}

void VertexBlocks::set_limit(Index spring, float stiffness, float limit) {
  VertexSpring changed = given_[spring];
  changed.limit_stiffness = stiffness;
  changed.limit = limit;
  set(given_, spring, changed);
}

void VertexBlocks::remove_spring(Index spring) {
  set(given_, spring, {.vertices = given_[spring].vertices});
}

void VertexBlocks::remove_hinge(Index hinge) {
  set(given_hinges_, hinge, {.vertices = given_hinges_[hinge].vertices});
}

void VertexBlocks::refresh() {
  for (const Index v : touched_) {
    is_touched_[v] = false;
    VertexBlock& block = blocks_[places_[v].block];
    find_neighborhood(v);
    // Rows that none needs any more are padded before they are left out: those of a block beyond
    // what a lane needs hold nothing of it.
    const VertexBlock before = block;
    count_rows(block);
    block.pulls.count = std::max(block.pulls.count, before.pulls.count);
    block.springs.count = std::max(block.springs.count, before.springs.count);
    block.volumes.count = std::max(block.volumes.count, before.volumes.count);
    block.hinges.count = std::max(block.hinges.count, before.hinges.count);
    write_rows(v);
    count_rows(block);
  }
  touched_.clear();
}

void VertexBlocks::begin_edit() noexcept {
  tets_.begin_edit();
  given_.begin_edit();
  given_hinges_.begin_edit();
}

void VertexBlocks::undo() {
  const auto undo = [&](auto& elements) {
    elements.undo([&](Index id) { touch(elements[id].vertices); });
  };
  undo(tets_);
  undo(given_);
  undo(given_hinges_);
}

std::size_t VertexBlocks::memory_bytes() const noexcept {
  const auto bytes = [](const auto&... arrays) {
    return (... + (arrays.size() * sizeof(arrays[0])));
  };
  return tets_.memory_bytes() + given_.memory_bytes() + given_hinges_.memory_bytes() +
         (hinges_at_.entries.empty() ? 0 : bytes(hinges_at_.offsets)) +
         bytes(tets_at_.offsets, tets_at_.entries, springs_at_.offsets, springs_at_.entries,
               hinges_at_.entries, blocks_, pulls_, springs_, volumes_, hinges_, damped_springs_,
               damped_volumes_, damped_hinges_, strips_, strip_rooms_, places_, needs_, touched_);
}

void add_damping(const DampedRows& rows, Index block_count, std::span<const Particle> bases,
                 std::span<const Carry> carries, float inverse_dt) noexcept {
  for (Index b = 0; b < block_count; ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index lane = 0; block.is_damped && lane < kBlockLanes; ++lane) {
      const StartAccess access{bases.data(), carries.data(),
                               load(at(bases.data(), block.corners[lane])), lane};
      add_damping(rows, block, access, inverse_dt);
    }
  }
}

}  // namespace pbdsurg
