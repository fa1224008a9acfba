// SPDX-License-Identifier: Apache-2.0
// How vertices that an edit brings, or joins to others, find colours and lanes.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg {
namespace {

// What a new block has room for beyond its first vertex, of kinds that there are: others of a cut,
// and later cuts.
constexpr Index kSparePulls = 4, kSpareSprings = 4, kSpareVolumes = 8, kSpareHinges = 2,
                kSpareStrips = 12, kSpareTriangles = 4, kSpareFibres = 8, kSpareFans = 6;

// Of a walk for those without a colour: neighbours that it may look at, for each vertex whose rows
// an edit changes, and in all. Most take some hundred; the most take as long as an edit.
constexpr std::int64_t kEffort = 4000, kMostEffort = 100'000;

// A colour of so few may be emptied, with a share of that.
constexpr Index kFewVertices = 2 * kBlockLanes;
constexpr std::int64_t kShareToEmpty = 20;

// How many places are looked at for one with room; behind these, one that is new is as well.
constexpr std::ptrdiff_t kMostTries = 16;

bool has_terms(const VertexTet& tet) {
  return tet.stiffness > 0 || tet.volume_damping > 0 ||
         std::ranges::any_of(tet.weights, [](float weight) { return weight != 0; });
}

bool has_terms(const VertexSpring& spring) {
  return spring.stiffness > 0 || spring.damping > 0 || spring.limit_stiffness > 0;
}

bool has_terms(const VertexTriangle& triangle) {
  return triangle.stiffness > 0;
}

bool has_terms(const VertexHinge& hinge) {
  return hinge.stiffness > 0 || hinge.damping > 0 ||
         std::ranges::any_of(hinge.weights, [](float weight) { return weight != 0; });
}

// Of rows from `first` on: each is a number of a lane after that of the lane before, kind by kind.
template <class Row>
void copy_lanes(std::vector<Row>& rows, Index first, Index count, Index from, Index to) noexcept {
  constexpr std::size_t kNumber = sizeof(float), kKind = kBlockLanes * kNumber;
  static_assert(sizeof(Row) % kKind == 0 && std::is_trivially_copyable_v<Row>);
  for (Index i = first; i < first + count; ++i) {
    auto* const bytes = reinterpret_cast<std::byte*>(&rows[i]);
    for (std::size_t kind = 0; kind < sizeof(Row); kind += kKind) {
      std::memcpy(bytes + kind + static_cast<std::size_t>(to) * kNumber,
                  bytes + kind + static_cast<std::size_t>(from) * kNumber, kNumber);
    }
  }
}

}  // namespace

void VertexBlocks::add_vertices(Index count) {
  const auto size = static_cast<std::size_t>(count);
  is_free_.resize(size, false);
  color_of_.resize(size, kInvalidIndex);
  places_.resize(size);
  needs_.resize(size);
  is_touched_.resize(size, false);
  tets_at_.resize(size);
  springs_at_.resize(size);
  if (given_hinges_.size() > 0) {
    hinges_at_.resize(size);
  }
  if (given_triangles_.size() > 0) {
    triangles_at_.resize(size);
  }
}

void VertexBlocks::set_free(Index vertex) {
  is_free_[vertex] = true;
  touch({&vertex, 1});
}

bool VertexBlocks::is_fresh(Index vertex) const noexcept {
  return is_free_[vertex] && color_of_[vertex] == kInvalidIndex;
}

void VertexBlocks::give_colors() {
  std::ranges::sort(conflicts_);
  for (const Index v : conflicts_) {
    find_neighbors(v);
    const auto has_its_color = [&](Index other) { return color_of_[other] == color_of_[v]; };
    if (is_free_[v] && color_of_[v] != kInvalidIndex && std::ranges::any_of(near_, has_its_color)) {
      set_color(v, kInvalidIndex);
    }
  }
  conflicts_.clear();
  uncolored_.clear();
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    const Index v = touched_[i];
    if (!is_fresh(v)) {
      continue;
    }
    if (const Index color = at_once_ ? 0 : free_color(v); color != kInvalidIndex) {
      set_color(v, color);
    } else {
      uncolored_.push_back(v);
    }
  }
  if (!at_once_) {
    rearrange_colors();
  }
}

// Those that must have another colour.
void VertexBlocks::find_neighbors(Index vertex) {
  near_.clear();
  is_near_.resize(places_.size());
  is_near_[vertex] = true;
  const auto visit = [&](const auto& elements, std::span<const Index> ids) {
    for (const Index id : ids) {
      const auto& element = elements[id];
      if (!has_terms(element)) {
        continue;
      }
      for (const Index v : element.vertices) {
        if (!is_near_[v] && is_free_[v]) {
          is_near_[v] = true;
          near_.push_back(v);
        }
      }
    }
  };
  visit(tets_, tets_at(vertex));
  visit(given_, springs_at(vertex));
  visit(given_hinges_, hinges_at(vertex));
  visit(given_triangles_, triangles_at(vertex));
  is_near_[vertex] = false;
  for (const Index v : near_) {
    is_near_[v] = false;
  }
}

// The first that no neighbour has, if any.
Index VertexBlocks::free_color(Index vertex) {
  find_neighbors(vertex);
  is_color_free_.assign(color_sizes_.begin(), color_sizes_.end());  // one of no vertex is closed
  for (const Index v : near_) {
    if (color_of_[v] != kInvalidIndex) {
      is_color_free_[color_of_[v]] = false;
    }
  }
  const auto found = std::ranges::find(is_color_free_, true);
  return found == is_color_free_.end() ? kInvalidIndex
                                       : static_cast<Index>(found - is_color_free_.begin());
}

// Of those without one; and of a colour that few have, if all of these can do without.
void VertexBlocks::rearrange_colors() {
  std::vector<Index> colors;
  for (Index color = 0; color < color_count(); ++color) {
    if (color_sizes_[color] > 0) {
      colors.push_back(color);
    }
  }
  const std::int64_t effort =
      std::min(kEffort * static_cast<std::int64_t>(touched_.size()), kMostEffort);
  const bool is_grown = vertex_count() > counts_before_.vertices;
  if (colors.size() > 1 && (is_grown || !uncolored_.empty())) {
    const auto size_of = [&](Index color) { return color_sizes_[color]; };
    const auto rarest = std::ranges::min_element(colors, {}, size_of);
    if (const Index color = *rarest; size_of(color) <= kFewVertices) {
      const std::size_t count = uncolored_.size();
      append_vertices(color, uncolored_);
      std::ranges::sort(uncolored_.begin() + static_cast<std::ptrdiff_t>(count), uncolored_.end());
      colors.erase(rarest);
      if (walk(colors, effort / kShareToEmpty)) {
        uncolored_.clear();
      } else {
        uncolored_.resize(count);
        colors.push_back(color);
        std::ranges::sort(colors);
      }
    }
  }
  Index closed = 0;  // the next
  while (!uncolored_.empty() && !walk(colors, effort)) {
    while (closed < color_count() && color_sizes_[closed] > 0) {
      ++closed;
    }
    open_color(closed);
    colors.push_back(closed++);
  }
  local_walk_.forget_conflicts();
}

// Of one that there is.
void VertexBlocks::append_vertices(Index color, std::vector<Index>& vertices) const {
  const auto [first, count] = blocks(color);
  for (const VertexBlock& block : std::span(blocks_).subspan(first, count)) {
    for (Index lane = 0; lane < block.lane_count; ++lane) {
      vertices.push_back(place_at(block.corners[lane]));
    }
  }
  for (const Index v : touched_) {  // who has no lane yet
    if (color_of_[v] == color && places_[v].block == kInvalidIndex) {
      vertices.push_back(v);
    }
  }
}

bool VertexBlocks::walk(std::span<const Index> colors, std::int64_t effort) {
  const auto neighbors_of = [&](Index v) {
    find_neighbors(v);
    return std::span<const Index>(near_);
  };
  if (!local_walk_.run(uncolored_, colors, color_of_, neighbors_of, effort)) {
    return false;
  }
  for (const auto& [vertex, color] : local_walk_.changes()) {
    set_color(vertex, color);
  }
  return true;
}

void VertexBlocks::set_color(Index vertex, Index color) {
  color_changes_.push_back({vertex, color_of_[vertex]});
  if (places_[vertex].block != kInvalidIndex) {
    leave_lane(vertex);
  }
  if (color != kInvalidIndex) {
    open_color(color);
  }
  change_color(vertex, color);
  touch({&vertex, 1});
}

void VertexBlocks::open_color(Index color) {
  if (color == color_count()) {
    first_block_.push_back(block_count());
    open_.emplace_back();
    color_sizes_.push_back(0);
  }
}

void VertexBlocks::change_color(Index vertex, Index color) {
  if (const Index before = color_of_[vertex]; before != kInvalidIndex) {
    --color_sizes_[before];
  }
  if (color != kInvalidIndex) {
    ++color_sizes_[color];
  }
  color_of_[vertex] = color;
}

void VertexBlocks::take_lane(Index vertex) {
  const Index color = color_of_[vertex];
  Index index = open_block(color, needs_[vertex]);
  if (index == kInvalidIndex) {
    index = add_block(color, needs_[vertex]);
  }
  VertexBlock& block = blocks_[index];
  changed_blocks_.push_back(index);
  places_[vertex] = {index, block.lane_count};
  std::fill(block.corners + block.lane_count, block.corners + kBlockLanes, offset_of(vertex));
  if (++block.lane_count == kBlockLanes) {
    std::erase(open_[color], index);
  }
  note_flags(block);
  write_rows(vertex);
  count_rows(block);
}

// The last in use takes its lane.
void VertexBlocks::leave_lane(Index vertex) noexcept {
  const auto [index, lane] = places_[vertex];
  places_[vertex] = {};
  VertexBlock& block = blocks_[index];
  changed_blocks_.push_back(index);
  const Index color = color_of_[vertex];
  if (block.lane_count == kBlockLanes) {
    open_[color].push_back(index);
  }
  const Index last = --block.lane_count;
  if (last == 0) {
    remove_block(index);
    return;
  }
  if (lane != last) {
    const Index moved = place_at(block.corners[last]);
    block.corners[lane] = block.corners[last];
    places_[moved].lane = lane;
    copy_lane(block, last, lane);
    refreshed_.push_back(moved);
  }
  for (Index idle = last; idle < kBlockLanes; ++idle) {
    block.corners[idle] = block.corners[last - 1];
    copy_lane(block, last - 1, idle);
  }
  count_rows(block);
}

void VertexBlocks::copy_lane(const VertexBlock& block, Index from, Index to) noexcept {
  const auto& [firsts, counts, number] = rooms_[places_[place_at(block.corners[0])].block];
  copy_lanes(pulls_, firsts.pulls, counts.pulls, from, to);
  copy_lanes(springs_, firsts.springs, counts.springs, from, to);
  copy_lanes(volumes_, firsts.volumes, counts.volumes, from, to);
  copy_lanes(hinges_, firsts.hinges, counts.hinges, from, to);
  copy_lanes(strips_, firsts.strips, counts.strips, from, to);
  copy_lanes(triangles_, firsts.triangles, counts.triangles, from, to);
  copy_lanes(fibres_, firsts.fibres, counts.fibres, from, to);
  copy_lanes(fans_, firsts.fans, counts.fans, from, to);
  if (has_damping_) {
    copy_lanes(damped_springs_, firsts.springs, counts.springs, from, to);
    copy_lanes(damped_volumes_, firsts.volumes, counts.volumes, from, to);
    copy_lanes(damped_strips_, firsts.strips, counts.strips, from, to);
    copy_lanes(damped_triangles_, firsts.triangles, counts.triangles, from, to);
  }
}

// The latest with room, or kInvalidIndex.
Index VertexBlocks::open_block(Index color, const Rows& needs) {
  const std::vector<Index>& open = open_[color];
  const auto end = open.rbegin() + std::min(std::ssize(open), kMostTries);
  const auto found = std::find_if(
      open.rbegin(), end, [&](Index block) { return rooms_[block].counts.has_room_for(needs); });
  return found == end ? kInvalidIndex : *found;
}

Index VertexBlocks::add_block(Index color, const Rows& needs) {
  const auto end = left_rooms_.rbegin() + std::min(std::ssize(left_rooms_), kMostTries);
  const auto left = std::find_if(left_rooms_.rbegin(), end,
                                 [&](const Room& room) { return room.counts.has_room_for(needs); });
  Room room;
  if (left != end) {
    room = *left;
    left_rooms_.erase(std::next(left.base(), -1));
  } else {
    const auto with = [](Index count, const auto& rows, Index spare) {
      return count + (rows.empty() ? 0 : spare);
    };
    room = make_room(
        {with(needs.pulls, pulls_, kSparePulls), with(needs.springs, springs_, kSpareSprings),
         with(needs.volumes, volumes_, kSpareVolumes), with(needs.hinges, hinges_, kSpareHinges),
         with(needs.strips, strips_, kSpareStrips),
         with(needs.triangles, triangles_, kSpareTriangles),
         with(needs.fibres, fibres_, kSpareFibres), with(needs.fans, fans_, kSpareFans)});
  }
  Index gap = block_count();
  blocks_.emplace_back();
  rooms_.emplace_back();
  for (Index later = color_count() - 1; later > color; --later) {
    const Index first = first_block_[later];
    if (first != gap) {
      move_block(later, first, gap);
    }
    ++first_block_[later + 1];
    gap = first;
  }
  ++first_block_[color + 1];
  rooms_[gap] = room;
  blocks_[gap] = {};
  changed_blocks_.push_back(gap);
  occupy(blocks_[gap], room);
  open_[color].push_back(gap);
  return gap;
}

// Without a vertex.
void VertexBlocks::remove_block(Index block) {
  const auto next = std::ranges::upper_bound(first_block_, block);
  const auto color = static_cast<Index>(next - first_block_.begin()) - 1;
  std::erase(open_[color], block);
  left_rooms_.push_back(rooms_[block]);
  Index gap = block;
  for (Index each = color; each < color_count(); ++each) {
    const Index last = first_block_[each + 1] - 1;
    if (last > gap) {
      move_block(each, last, gap);
      gap = last;
    }
  }
  for (Index each = color; each < color_count(); ++each) {
    --first_block_[each + 1];
  }
  blocks_.pop_back();
  rooms_.pop_back();
}

void VertexBlocks::move_block(Index color, Index from, Index to) noexcept {
  blocks_[to] = blocks_[from];
  rooms_[to] = rooms_[from];
  changed_blocks_.push_back(from);
  changed_blocks_.push_back(to);
  std::ranges::replace(open_[color], from, to);
  for (Index lane = 0; lane < blocks_[to].lane_count; ++lane) {
    const Index v = place_at(blocks_[to].corners[lane]);
    places_[v].block = to;
    if (at_once_) {
      refreshed_.push_back(v);
    }
  }
}

void VertexBlocks::undo() {
  const bool had_hinges = counts_before_.hinges > 0, has_hinges = given_hinges_.size() > 0;
  const bool had_triangles = counts_before_.triangles > 0;
  const bool has_triangles = given_triangles_.size() > 0;
  unit_ = unit_before_;
  refreshed_.clear();
  changed_blocks_.clear();
  for (auto change = color_changes_.rbegin(); change != color_changes_.rend(); ++change) {
    const auto& [vertex, before] = *change;
    if (places_[vertex].block != kInvalidIndex) {
      leave_lane(vertex);
    }
    change_color(vertex, before);
    is_free_[vertex] = before != kInvalidIndex;
    touch({&vertex, 1});
    refreshed_.push_back(vertex);  // which may have no rows any more
  }
  color_changes_.clear();
  first_block_.resize(static_cast<std::size_t>(counts_before_.colors) + 1);
  open_.resize(static_cast<std::size_t>(counts_before_.colors));
  color_sizes_.resize(static_cast<std::size_t>(counts_before_.colors));

  const auto touch_new = [&](const auto& elements, Index before) {
    for (Index id = before; id < elements.size(); ++id) {
      touch(elements[id].vertices);
    }
  };
  touch_new(tets_, counts_before_.tets);
  touch_new(given_, counts_before_.springs);
  touch_new(given_hinges_, counts_before_.hinges);
  touch_new(given_triangles_, counts_before_.triangles);
  const auto undo_set = [&](auto& elements) {
    elements.undo([&](Index id) { touch(elements[id].vertices); });
  };
  for (auto change = list_changes_.rbegin(); change != list_changes_.rend(); ++change) {
    const auto& [which, is_added, vertex, element] = *change;
    touch({&vertex, 1});
    change_list(which, vertex, element, !is_added);
  }
  list_changes_.clear();
  undo_set(tets_);
  undo_set(given_);
  undo_set(given_hinges_);
  undo_set(given_triangles_);

  const auto count = static_cast<std::size_t>(counts_before_.vertices);
  for (auto v = counts_before_.vertices; v < static_cast<Index>(places_.size()); ++v) {
    tets_at_.clear(v);
    springs_at_.clear(v);
    if (has_hinges) {
      hinges_at_.clear(v);
    }
    if (has_triangles) {
      triangles_at_.clear(v);
    }
  }
  const auto is_gone = [&](Index v) { return v >= counts_before_.vertices; };
  std::erase_if(touched_, is_gone);
  std::erase_if(refreshed_, is_gone);
  is_free_.resize(count);
  color_of_.resize(count);
  places_.resize(count);
  needs_.resize(count);
  is_touched_.resize(count);
  tets_at_.resize(count);
  springs_at_.resize(count);
  if (had_hinges) {
    hinges_at_.resize(count);
  } else {
    hinges_at_ = {};
  }
  if (had_triangles) {
    triangles_at_.resize(count);
  } else {
    triangles_at_ = {};
  }
}

// Of each vertex that comes, some neighbours go to blocks with more room, too.
VertexBlocks::Growth VertexBlocks::expected_growth(const SpareRoom& spare) const noexcept {
  if (spare.vertices == 0) {
    return {};
  }
  const auto blocks = 3 * static_cast<std::size_t>(spare.vertices) / kBlockLanes +
                      static_cast<std::size_t>(color_count());
  // rows of a block, at a cut or a rip
  constexpr std::size_t kPulls = 24, kVolumes = 40, kTriangles = 12, kStrips = 50, kFans = 24;
  return {blocks,
          pulls_.empty() ? 0 : kPulls * blocks,
          springs_.empty() ? 0 : kPulls * blocks,
          volumes_.empty() ? 0 : kVolumes * blocks,
          hinges_.empty() ? 0 : kSpareHinges * blocks,
          triangles_.empty() ? 0 : kTriangles * blocks,
          fibres_.empty() ? 0 : kVolumes * blocks,
          strips_.empty() ? 0 : kStrips * blocks,
          fans_.empty() ? 0 : kFans * blocks};
}

void VertexBlocks::reserve(const SpareRoom& spare) {
  if (spare.vertices == 0) {
    return;
  }
  const Growth growth = expected_growth(spare);
  const auto vertices = static_cast<std::size_t>(spare.vertices);
  blocks_.reserve(blocks_.size() + growth.blocks);
  rooms_.reserve(rooms_.size() + growth.blocks);
  pulls_.reserve(pulls_.size() + growth.pulls);
  volumes_.reserve(volumes_.size() + growth.volumes);
  springs_.reserve(springs_.size() + growth.springs);
  triangles_.reserve(triangles_.size() + growth.triangles);
  fibres_.reserve(fibres_.size() + growth.fibres);
  strips_.reserve(strips_.size() + growth.strips);
  fans_.reserve(fans_.size() + growth.fans);
  if (has_damping_) {
    damped_springs_.reserve(springs_.capacity());
    damped_volumes_.reserve(volumes_.capacity());
    damped_triangles_.reserve(triangles_.capacity());
    damped_strips_.reserve(strips_.capacity());
  }
  tets_at_.reserve_room(vertices, 16 * static_cast<std::size_t>(spare.tets));
  springs_at_.reserve_room(vertices, 8 * static_cast<std::size_t>(spare.edges));
  color_of_.reserve(color_of_.size() + vertices);
  touched_.reserve(places_.size() + vertices);
  refreshed_.reserve(places_.size() + vertices);
  local_walk_.reserve(places_.size() + vertices);
  is_near_.reserve(places_.size() + vertices);
  places_.reserve(places_.size() + vertices);
  needs_.reserve(needs_.size() + vertices);
  is_free_.reserve(is_free_.size() + vertices);
  is_touched_.reserve(is_touched_.size() + vertices);
  tets_.reserve(static_cast<std::size_t>(spare.tets), static_cast<std::size_t>(spare.tets));
  given_.reserve(static_cast<std::size_t>(spare.edges) + static_cast<std::size_t>(spare.links),
                 static_cast<std::size_t>(spare.edges));
}

}  // namespace pbdsurg
