// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_blocks.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "pbdsurg/coloring/balance.h"
#include "pbdsurg/coloring/constraint_vertices.h"

#include "lib/coloring/fewer_colors.h"
#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/vertex_kernel.h"

namespace pbdsurg {
namespace {

template <std::size_t kArity>
ListPool lists_at(Index vertex_count, std::span<const std::array<Index, kArity>> elements) {
  const IndexLists found = find_vertex_constraints({elements, vertex_count});
  ListPool lists;
  lists.resize(static_cast<std::size_t>(vertex_count));
  for (Index v = 0; v < vertex_count; ++v) {
    lists.assign(v, found[v]);
  }
  return lists;
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

VertexBlocks::Rows VertexBlocks::Rows::most(const Rows& a, const Rows& b) noexcept {
  return {std::max(a.pulls, b.pulls),        std::max(a.springs, b.springs),
          std::max(a.volumes, b.volumes),    std::max(a.hinges, b.hinges),
          std::max(a.strips, b.strips),      std::max(a.triangles, b.triangles),
          std::max(a.fibres, b.fibres),      std::max(a.fans, b.fans),
          std::max(a.fan_steps, b.fan_steps)};
}

bool VertexBlocks::Rows::has_room_for(const Rows& needs) const noexcept {
  return needs.pulls <= pulls && needs.springs <= springs && needs.volumes <= volumes &&
         needs.hinges <= hinges && needs.triangles <= triangles && needs.fibres <= fibres;
}

VertexBlocks::VertexBlocks(const std::vector<bool>& moves, std::vector<VertexTet> tets,
                           std::vector<VertexSpring> springs, std::vector<VertexHinge> hinges,
                           const ColoringOptions& coloring, float unit, bool at_once,
                           std::vector<VertexTriangle> triangles)
    : tets_(std::move(tets)),
      given_(std::move(springs)),
      given_hinges_(std::move(hinges)),
      given_triangles_(std::move(triangles)),
      at_once_(at_once),
      unit_(unit),
      is_free_(moves),
      color_of_(moves.size(), kInvalidIndex),
      places_(moves.size()),
      needs_(moves.size()),
      is_touched_(moves.size(), false) {
  const auto vertex_count = static_cast<Index>(moves.size());
  tets_at_ = lists_at(vertex_count, std::span<const Tet>(vertices_of(tets_.values())));
  springs_at_ = lists_at(vertex_count, std::span<const Edge>(vertices_of(given_.values())));
  if (given_hinges_.size() > 0) {
    hinges_at_ = lists_at(
        vertex_count, std::span<const std::array<Index, 4>>(vertices_of(given_hinges_.values())));
  }
  if (given_triangles_.size() > 0) {
    triangles_at_ =
        lists_at(vertex_count, std::span<const Triangle>(vertices_of(given_triangles_.values())));
  }
  const auto is_positive = [](float damping) { return damping > 0; };
  const auto is_damped = [](const auto& element) { return element.damping > 0; };
  has_damping_ =
      std::ranges::any_of(tets_.values(),
                          [&](const VertexTet& tet) {
                            return is_positive(tet.volume_damping) ||
                                   std::ranges::any_of(tet.edge_damping, is_positive);
                          }) ||
      std::ranges::any_of(given_.values(), is_damped) ||
      std::ranges::any_of(given_hinges_.values(), is_damped) ||
      std::ranges::any_of(given_triangles_.values(), [&](const VertexTriangle& triangle) {
        return is_positive(triangle.edge_damping[0]);
      });

  // Blocks last as long as their busiest vertex, so alike ones go together.
  Coloring colors;
  if (!at_once) {
    colors = color_vertices(moves, coloring);
  }
  std::vector<Index> order;
  for (Index v = 0; v < vertex_count; ++v) {
    if (!moves[v]) {
      continue;
    }
    order.push_back(v);
    color_of_[v] = at_once ? 0 : colors.color_of[v];
    find_neighborhood(v);
  }
  const auto key = [&](Index v) {
    const Rows& needs = needs_[v];
    return std::tuple(color_of_[v], needs.volumes, needs.springs, needs.pulls, needs.hinges,
                      needs.triangles, needs.fibres, v);
  };
  std::sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
  const std::span<const Index> all(order);
  for (std::size_t first = 0; first < all.size();) {
    const Index color = color_of_[all[first]];
    std::size_t last = first;
    while (last < all.size() && last - first < kBlockLanes && color_of_[all[last]] == color) {
      ++last;
    }
    // a colour may have lost all its vertices to those that are fixed
    first_block_.resize(static_cast<std::size_t>(color) + 1, block_count());
    append_block(color, all.subspan(first, last - first));
    first = last;
  }
  first_block_.push_back(block_count());
  open_.resize(static_cast<std::size_t>(color_count()));
  color_sizes_.resize(static_cast<std::size_t>(color_count()));
  for (const Index v : order) {
    ++color_sizes_[color_of_[v]];
  }
  touched_.reserve(moves.size());
  refreshed_.reserve(moves.size());
  begin_edit();
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
  append(given_triangles_.values());
  const IndexLists blocks =
      find_vertex_constraints(ConstraintVertices(free, static_cast<Index>(moves.size())));
  const ConstraintVertices vertices(blocks, free.list_count());
  ColoringOptions first = options;
  first.balance = false;
  Coloring coloring = color_constraints(vertices, first);
  if (options.repair) {
    find_fewer_colors(coloring, vertices, options.seed);
  }
  if (options.balance) {
    balance_coloring(coloring, vertices, options.seed, options.executor);
  }
  return coloring;
}

void VertexBlocks::append_block(Index color, std::span<const Index> vertices) {
  VertexBlock block;
  block.lane_count = static_cast<Index>(vertices.size());
  block.is_damped = block.has_angles = false;
  Rows most;
  for (Index lane = 0; lane < kBlockLanes; ++lane) {
    const Index v = vertices[std::min(lane, block.lane_count - 1)];
    block.corners[lane] = offset_of(v);
    most = Rows::most(most, needs_[v]);
  }
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    places_[vertices[lane]] = {block_count(), lane};
  }
  if (block.lane_count < kBlockLanes) {
    open_.resize(std::max(open_.size(), static_cast<std::size_t>(color) + 1));
    open_[color].push_back(block_count());
  }
  rooms_.push_back(make_room(most));
  occupy(block, rooms_.back());
  blocks_.push_back(block);
  count_rows(blocks_.back());
  for (const Index v : vertices) {
    find_neighborhood(v);
    write_rows(v);
    note_flags(blocks_.back());
  }
}

bool VertexBlocks::is_neighborhood_damped() const noexcept {
  const auto is_damped = [](const auto& row) { return row.damping > 0; };
  return std::ranges::any_of(neighborhood_.springs, is_damped) ||
         std::ranges::any_of(neighborhood_.volumes, is_damped) ||
         std::ranges::any_of(neighborhood_.hinges, is_damped) ||
         std::ranges::any_of(neighborhood_.triangles, is_damped);
}

// @return  whether that changes the block
bool VertexBlocks::note_flags(VertexBlock& block) const noexcept {
  const VertexBlock before = block;
  block.is_damped |= is_neighborhood_damped();
  block.has_angles |= std::ranges::any_of(neighborhood_.hinges,
                                          [](const Bend& hinge) { return hinge.stiffness > 0; });
  return block.is_damped != before.is_damped || block.has_angles != before.has_angles;
}

VertexBlocks::Room VertexBlocks::make_room(const Rows& counts) {
  const auto add = [](auto& rows, Index count) {
    const auto first = static_cast<Index>(rows.size());
    rows.resize(rows.size() + static_cast<std::size_t>(count));
    return first;
  };
  Room room{{}, counts, room_count_++};
  room.firsts = {add(pulls_, counts.pulls),     add(springs_, counts.springs),
                 add(volumes_, counts.volumes), add(hinges_, counts.hinges),
                 add(strips_, counts.strips),   add(triangles_, counts.triangles),
                 add(fibres_, counts.fibres),   add(fans_, counts.fans)};
  if (has_damping_) {
    damped_springs_.resize(springs_.size());
    damped_volumes_.resize(volumes_.size());
    damped_strips_.resize(strips_.size());
    damped_triangles_.resize(triangles_.size());
  }
  return room;
}

VertexBlocks::BlockRoom VertexBlocks::room_of(Index block) const noexcept {
  const auto& [firsts, counts, number] = rooms_[block];
  return {number,
          {firsts.pulls, counts.pulls},
          {firsts.springs, counts.springs},
          {firsts.volumes, counts.volumes},
          {firsts.hinges, counts.hinges},
          {firsts.triangles, counts.triangles},
          {firsts.fibres, counts.fibres}};
}

void VertexBlocks::occupy(VertexBlock& block, const Room& room) noexcept {
  block.pulls.first = room.firsts.pulls;
  block.springs.first = room.firsts.springs;
  block.volumes.first = room.firsts.volumes;
  block.hinges.first = room.firsts.hinges;
  block.strips.first = room.firsts.strips;
  block.triangles.first = room.firsts.triangles;
  block.fibres.first = room.firsts.fibres;
  block.fans.first = room.firsts.fans;
}

void VertexBlocks::count_rows(VertexBlock& block) noexcept {
  Rows most;
  bool has_strips = true, has_fans = true;  // of all that they stand in for
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    const Rows& needs = needs_[place_at(block.corners[lane])];
    most = Rows::most(most, needs);
    has_strips = has_strips && (needs.strips > 0 || needs.pulls == 0);
    has_fans = has_fans && (needs.fans > 0 || needs.pulls + needs.triangles == 0);
  }
  block.pulls.count = most.pulls;
  block.springs.count = most.springs;
  block.volumes.count = most.volumes;
  block.hinges.count = most.hinges;
  block.triangles.count = most.triangles;
  block.fibres.count = most.fibres;
  // a face that goes may part a strip in two, which needs more rows than there were
  const Rows& room = rooms_[places_[place_at(block.corners[0])].block].counts;
  block.strips.count = has_strips && most.strips <= room.strips ? most.strips : 0;
  block.fans.count = has_fans && most.fans <= room.fans ? most.fans : 0;
  block.fan_steps = most.fan_steps;
}

// One for each neighbour, summed in the order in which they come, on which sums of floats depend.
void VertexBlocks::add_pull(const Pull& pull) {
  std::vector<Pull>& pulls = neighborhood_.pulls;
  const auto known = std::ranges::find(pulls, pull.neighbor, &Pull::neighbor);
  if (known == pulls.end()) {
    pulls.push_back(pull);
  } else {
    known->weight += pull.weight;
    known->damping += pull.damping;
  }
}

void VertexBlocks::find_neighborhood(Index vertex) {
  auto& [pulls, springs, volumes, hinges, triangles, fibres] = neighborhood_;
  pulls.clear();
  springs.clear();
  volumes.clear();
  hinges.clear();
  triangles.clear();
  fibres.clear();
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
        add_pull({tet.vertices[a + b - corner], tet.weights[e], tet.edge_damping[e]});
      }
    }
    if (tet.fibre_stiffness > 0) {
      const auto [s1, s2, s3] = tet.fibre_shares;
      const std::array<float, 4> shares{-(s1 + s2 + s3), s1, s2, s3};
      const auto& [i, j, k] = kTetTriangles[corner];
      fibres.push_back({{tet.vertices[i], tet.vertices[j], tet.vertices[k]},
                        {shares[i], shares[j], shares[k]},
                        tet.fibre_stiffness});
    }
  }
  std::ranges::sort(pulls, {}, &Pull::neighbor);

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
  find_triangles(vertex);
  find_hinges(vertex);
  find_strip();
  const Index steps = find_fan();
  needs_[vertex] = {static_cast<Index>(pulls.size()),
                    static_cast<Index>(springs.size()),
                    static_cast<Index>(volumes.size()),
                    static_cast<Index>(hinges.size()),
                    static_cast<Index>(strip_entries_.size()),
                    static_cast<Index>(triangles.size()),
                    static_cast<Index>(fibres.size()),
                    static_cast<Index>(fan_entries_.size()),
                    steps};
}

void VertexBlocks::find_strip() {
  strip_entries_.clear();
  if (neighborhood_.volumes.empty()) {
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
      entry.damping = neighborhood_.volumes[face].damping / 36;
    }
    entry.stiffness = turns ? -entry.stiffness : entry.stiffness;
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
  const Rows& room = rooms_[places_[vertex].block].counts;  // beyond what it needs, padding
  const auto entry = [](const auto& list, Index i, const auto& padding) {
    return i < static_cast<Index>(list.size()) ? list[i] : padding;
  };
  for (Index i = 0; i < room.pulls; ++i) {
    const Pull pull = entry(neighborhood_.pulls, i, Pull{vertex, 0, 0});
    PullRow& row = pulls_[block.pulls.first + i];
    row.neighbors[lane] = offset_of(pull.neighbor);
    row.weights[lane] = pull.weight;
  }
  for (Index i = 0; i < room.springs; ++i) {
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
  for (Index i = 0; i < room.volumes; ++i) {
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
  for (Index i = 0; i < room.strips; ++i) {
    const StripEntry entry_here = entry(strip_entries_, i, StripEntry{vertex, 0, 1, 0});
    StripRow& row = strips_[block.strips.first + i];
    row.corners[lane] = offset_of(entry_here.corner);
    row.stiffness[lane] = entry_here.stiffness;
    row.target[lane] = entry_here.target;
    row.weights[lane] = entry_here.weight;
    if (has_damping_) {
      DampedRow& damped = damped_strips_[block.strips.first + i];
      damped.stiffness[lane] = row.stiffness[lane];
      damped.target[lane] = row.target[lane];
      damped.damping[lane] = entry_here.damping;
    }
  }
  write_hinges(block, lane, room.hinges);
  write_triangles(block, lane, room.triangles);
  write_fan(block, lane, room.fans);
  for (Index i = 0; i < room.fibres; ++i) {
    const Fibres fibres =
        entry(neighborhood_.fibres, i, Fibres{{vertex, vertex, vertex}, {0, 0, 0}, 0});
    FibreRow& row = fibres_[block.fibres.first + i];
    for (int k = 0; k < 3; ++k) {
      row.neighbors[k][lane] = offset_of(fibres.neighbors[k]);
      row.shares[k][lane] = fibres.shares[k];
    }
    row.stiffness[lane] = fibres.stiffness;
  }
}

void VertexBlocks::touch(std::span<const Index> vertices) {
  for (const Index v : vertices) {
    if (is_free_[v] && !is_touched_[v]) {
      is_touched_[v] = true;
      touched_.push_back(v);
    }
  }
}

ListPool& VertexBlocks::list(List which) noexcept {
  switch (which) {
    case List::tets:
      return tets_at_;
    case List::springs:
      return springs_at_;
    case List::triangles:
      return triangles_at_;
    case List::hinges:
      break;
  }
  return hinges_at_;
}

void VertexBlocks::change_list(List which, Index vertex, Index element, bool is_added) {
  ListPool& lists = list(which);
  const std::span<const Index> elements = lists[vertex];
  const auto place =
      static_cast<Index>(std::ranges::lower_bound(elements, element) - elements.begin());
  if (is_added) {
    lists.insert(vertex, place, element);
  } else {
    lists.erase(vertex, place);
  }
}

template <class Element>
void VertexBlocks::set(UndoArray<Element>& elements, List which, Index id, const Element& terms) {
  const auto before = elements[id].vertices;
  elements.set(id, terms);
  touch(before);
  touch(terms.vertices);
  const auto is_in = [](const auto& vertices, Index v) {
    return std::ranges::find(vertices, v) != vertices.end();
  };
  const auto change = [&](const auto& vertices, const auto& others, bool is_added) {
    for (const Index v : vertices) {
      if (!is_in(others, v)) {
        change_list(which, v, id, is_added);
        list_changes_.push_back({which, is_added, v, id});
      }
    }
  };
  if (before != terms.vertices) {
    change(before, terms.vertices, false);
    change(terms.vertices, before, true);
  }
  note_conflicts(terms.vertices);
}

template <class Element>
void VertexBlocks::add(UndoArray<Element>& elements, List which, const Element& terms) {
  const Index id = elements.size();
  elements.push_back(terms);
  touch(terms.vertices);
  for (const Index v : terms.vertices) {
    change_list(which, v, id, true);
    list_changes_.push_back({which, true, v, id});
  }
  note_conflicts(terms.vertices);
}

// Only with what is new to a vertex.
void VertexBlocks::note_conflicts(std::span<const Index> vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Index a = vertices[i], b = vertices[j];
      if (!at_once_ && a != b && color_of_[a] != kInvalidIndex && color_of_[a] == color_of_[b]) {
        conflicts_.push_back(std::max(a, b));
      }
    }
  }
}

void VertexBlocks::set_tet(Index tet, const VertexTet& terms) {
  set(tets_, List::tets, tet, terms);
}

void VertexBlocks::remove_tet(Index tet) {
  set_tet(tet, {.vertices = tets_[tet].vertices});
}

void VertexBlocks::set_spring(Index spring, const VertexSpring& terms) {
  set(given_, List::springs, spring, terms);
}

void VertexBlocks::set_spring_rest(Index spring, float rest) {
  VertexSpring changed = given_[spring];
  changed.rest = rest;
  set_spring(spring, changed);
}

void VertexBlocks::set_limit(Index spring, float stiffness, float limit) {
  VertexSpring changed = given_[spring];
  changed.limit_stiffness = stiffness;
  changed.limit = limit;
  set_spring(spring, changed);
}

void VertexBlocks::remove_spring(Index spring) {
  set_spring(spring, {.vertices = given_[spring].vertices});
}

void VertexBlocks::set_triangle(Index triangle, const VertexTriangle& terms) {
  set(given_triangles_, List::triangles, triangle, terms);
}

void VertexBlocks::remove_triangle(Index triangle) {
  set_triangle(triangle, {.vertices = given_triangles_[triangle].vertices});
}

void VertexBlocks::set_hinge(Index hinge, const VertexHinge& terms) {
  set(given_hinges_, List::hinges, hinge, terms);
}

void VertexBlocks::remove_hinge(Index hinge) {
  set_hinge(hinge, {.vertices = given_hinges_[hinge].vertices});
}

void VertexBlocks::add_tet(const VertexTet& terms) {
  add(tets_, List::tets, terms);
}

void VertexBlocks::add_spring(const VertexSpring& terms) {
  add(given_, List::springs, terms);
}

void VertexBlocks::add_triangle(const VertexTriangle& terms) {
  if (given_triangles_.size() == 0) {
    triangles_at_.resize(places_.size());
  }
  add(given_triangles_, List::triangles, terms);
}

void VertexBlocks::add_hinge(const VertexHinge& terms) {
  if (given_hinges_.size() == 0) {
    hinges_at_.resize(places_.size());
  }
  add(given_hinges_, List::hinges, terms);
}

void VertexBlocks::refresh() {
  give_colors();
  for (const Index v : touched_) {
    is_touched_[v] = false;
    if (!is_free_[v]) {
      continue;  // gone again
    }
    find_neighborhood(v);
    const bool has_place = places_[v].block != kInvalidIndex;
    if (has_place && rooms_[places_[v].block].counts.has_room_for(needs_[v])) {
      VertexBlock& block = blocks_[places_[v].block];
      if (note_flags(block)) {
        changed_blocks_.push_back(places_[v].block);
      }
      write_rows(v);
      count_rows(block);
    } else {
      if (has_place) {
        leave_lane(v);
      }
      take_lane(v);
    }
    refreshed_.push_back(v);
  }
  touched_.clear();
}

void VertexBlocks::begin_edit() noexcept {
  tets_.begin_edit();
  given_.begin_edit();
  given_hinges_.begin_edit();
  given_triangles_.begin_edit();
  counts_before_ = {static_cast<Index>(places_.size()),
                    tets_.size(),
                    given_.size(),
                    given_hinges_.size(),
                    given_triangles_.size(),
                    color_count()};
  unit_before_ = unit_;
  refreshed_.clear();
  changed_blocks_.clear();
  list_changes_.clear();
  color_changes_.clear();
}

std::size_t VertexBlocks::memory_bytes() const noexcept {
  const auto bytes = [](const auto&... arrays) {
    return (... + (arrays.size() * sizeof(arrays[0])));
  };
  return tets_.memory_bytes() + given_.memory_bytes() + given_hinges_.memory_bytes() +
         given_triangles_.memory_bytes() + tets_at_.memory_bytes() + springs_at_.memory_bytes() +
         hinges_at_.memory_bytes() + triangles_at_.memory_bytes() + local_walk_.memory_bytes() +
         bytes(color_of_, blocks_, pulls_, springs_, volumes_, hinges_, damped_springs_,
               damped_volumes_, strips_, damped_strips_, triangles_, damped_triangles_, fibres_,
               fans_, rooms_, left_rooms_, places_, needs_, touched_, refreshed_, changed_blocks_,
               list_changes_, color_changes_);
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
