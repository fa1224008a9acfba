// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/dynamic_coloring.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>

#include "pbdsurg/base/bits.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"

#include "lib/coloring/constraint_checks.h"
#include "lib/coloring/dynamic_tables.h"

namespace pbdsurg {
namespace {

constexpr Index kNoColor = kInvalidIndex;
constexpr std::size_t kLongestWalk = 64;

// What an edit may do besides what it is asked for.
constexpr std::int64_t kMovesPerChange = 8;
constexpr double kMostDeviation = 0.04;  // of sizes that are left as they are
constexpr std::int64_t kMisses = 256;    // after which sizes count as even as they get
constexpr std::int64_t kMissesPerMove = 4;

constexpr std::int64_t kMostEntries = std::numeric_limits<Index>::max();

// Of constraints, while an edit goes on.
enum class Role : std::uint8_t {
  none,
  gone,      // removed or merged into another
  kept,      // takes over the vertices of another
  inserted,  // was not there before
  moved,     // was there before and has left its colour
};

}  // namespace

struct DynamicColoring::Data {
  static constexpr const char* kWho = "a dynamic colouring";

  struct Move {
    Index id;
    Index from;
  };
  struct Blockers {
    Index color;
    Index ids[2];
  };

  Data(const ConstraintVertices& given, const Coloring& coloring) : constraints(given.arity) {
    check_valid(coloring, given);
    add_vertices(given.vertex_count);
    const Index count = given.constraint_count();
    constraints.resize(static_cast<std::size_t>(count));
    roles.resize(static_cast<std::size_t>(count), Role::none);
    ids_there = count;
    entries = static_cast<std::int64_t>(given.vertices.size());
    for (Index id = 0; id < count; ++id) {
      constraints.assign(id, given[id]);
      valences.add(given[id]);
    }
    color_of.resize(static_cast<std::size_t>(count), kNoColor);
    position_of.resize(static_cast<std::size_t>(count));
    std::vector<Index> ids(static_cast<std::size_t>(count));
    std::iota(ids.begin(), ids.end(), 0);
    take_over(ids, coloring);
  }

  static void check_valid(const Coloring& coloring, const ConstraintVertices& given) {
    if (const auto conflict = find_conflict(coloring, given)) {
      throw InvalidArgument("constraints " + std::to_string(conflict->first) + " and " +
                            std::to_string(conflict->second) + " of colour " +
                            std::to_string(conflict->color) + " share vertex " +
                            std::to_string(conflict->vertex));
    }
    const auto overflow =
        std::find(coloring.color_of.begin(), coloring.color_of.end(), kOverflowColor);
    if (overflow != coloring.color_of.end()) {
      throw InvalidArgument("constraint " + std::to_string(overflow - coloring.color_of.begin()) +
                            " has no colour; all must have one");
    }
  }

  // Colour by colour, so that each holder goes to the end of its lists.
  void take_over(std::span<const Index> ids, const Coloring& coloring) {
    at_vertex.clear();
    for (Index v = 0; v < at_vertex.vertex_count(); ++v) {
      at_vertex.reserve(v, valences[v]);
    }
    const std::vector<Index> counts = pbdsurg::color_sizes(coloring);
    std::vector<Index> next(counts.size() + 1, 0);
    std::partial_sum(counts.begin(), counts.end(), next.begin() + 1);
    std::vector<Index> order(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
      order[next[coloring.color_of[i]]++] = static_cast<Index>(i);
    }
    squares = 0;
    sizes.clear();
    for (std::vector<Index>& of_color : members) {
      of_color.clear();
    }
    while (sizes.size() < counts.size()) {
      open_color();
    }
    for (const Index i : order) {
      put(ids[i], coloring.color_of[i]);
    }
    drop_empty_colors();
    note_full_coloring();
  }

  void note_full_coloring() {
    full_clique = valences.most();
    full_excess = color_count() - full_clique;
    full_deviation = relative_deviation();
    stuck_colors = 0;
  }

  void add_vertices(Index count) {
    at_vertex.add_vertices(count);
    valences.add_vertices(count);
  }

  [[nodiscard]] Index color_count() const { return static_cast<Index>(sizes.size()); }
  [[nodiscard]] bool contains(Index id) const {
    return id >= 0 && static_cast<std::size_t>(id) < color_of.size() && color_of[id] != kNoColor;
  }
  void check_there(Index id) const {
    if (!contains(id)) {
      throw InvalidArgument("there is no constraint of id " + std::to_string(id));
    }
  }
  [[nodiscard]] double relative_deviation() const {
    if (ids_there == 0) {
      return 0;
    }
    const double n = ids_there;
    return std::sqrt(std::max(0.0, color_count() * static_cast<double>(squares) - n * n)) / n;
  }

  // ---- what an edit may not be

  void check(const ConstraintEdit& edit) {
    try {
      for (const Index id : edit.removed) {
        name(id, Role::gone);
      }
      for (const auto& [kept, gone] : edit.merged) {
        name(kept, Role::kept);
        name(gone, Role::gone);
        check_merge(kept, gone);
      }
      check_inserted(edit.inserted);
    } catch (...) {
      forget_names(edit);
      throw;
    }
    forget_names(edit);
  }

  void name(Index id, Role role) {
    check_there(id);
    if (roles[id] == Role::gone || (roles[id] == Role::kept && role == Role::gone)) {
      throw InvalidArgument("the edit names constraint " + std::to_string(id) +
                            " again; what is removed or merged into another is named once");
    }
    roles[id] = role;
  }

  void forget_names(const ConstraintEdit& edit) {
    const auto forget = [&](Index id) {
      if (contains(id)) {
        roles[id] = Role::none;
      }
    };
    for (const Index id : edit.removed) {
      forget(id);
    }
    for (const auto& [kept, gone] : edit.merged) {
      forget(kept);
      forget(gone);
    }
  }

  void check_merge(Index kept, Index gone) const {
    const auto a = constraints[kept];
    const auto b = constraints[gone];
    if (constraints.arity() > 0 && !std::is_permutation(a.begin(), a.end(), b.begin(), b.end())) {
      throw InvalidArgument("constraints " + std::to_string(kept) + " and " + std::to_string(gone) +
                            " do not merge into one of " + std::to_string(constraints.arity()) +
                            " vertices");
    }
  }

  void check_inserted(const ConstraintVertices& inserted) {
    if (inserted.vertices.empty() && inserted.offsets.empty()) {
      return;  // nothing, of any arity
    }
    if (inserted.arity != constraints.arity()) {
      throw InvalidArgument("inserted constraints of arity " + std::to_string(inserted.arity) +
                            " do not fit a set of arity " + std::to_string(constraints.arity()) +
                            " (0: each its own)");
    }
    check_shape(inserted);
    if (entries + static_cast<std::int64_t>(inserted.vertices.size()) > kMostEntries) {
      throw InvalidArgument(std::to_string(inserted.vertices.size()) + " vertices named besides " +
                            std::to_string(entries) + "; there can be at most 2^31 - 1");
    }
    for (Index c = 0; c < inserted.constraint_count(); ++c) {
      for (const Index v : inserted[c]) {
        if (v < 0 || v >= at_vertex.vertex_count()) {
          throw InvalidArgument("inserted constraint " + std::to_string(c) + " refers to vertex " +
                                std::to_string(v) + "; ids must be in [0, " +
                                std::to_string(at_vertex.vertex_count()) + ")");
        }
      }
      scratch.assign(inserted[c].begin(), inserted[c].end());
      std::sort(scratch.begin(), scratch.end());
      const auto twice = std::adjacent_find(scratch.begin(), scratch.end());
      if (twice != scratch.end()) {
        throw InvalidArgument("inserted constraint " + std::to_string(c) + " lists vertex " +
                              std::to_string(*twice) + " twice; its vertices must differ");
      }
    }
  }

  // ---- the edit

  ColoringUpdate apply(const ConstraintEdit& edit) {
    check(edit);
    waiting.clear();
    moves.clear();
    for (std::size_t i = 0; i < edit.removed.size(); ++i) {
      fetch_ahead(edit.removed, i);
      remove(edit.removed[i]);
    }
    for (const auto& [kept, gone] : edit.merged) {
      merge(kept, gone);
    }
    for (const Move& move : moves) {
      put_back(move);
    }
    const bool all_new = ids_there == 0;
    ColoringUpdate update;
    if (!edit.inserted.vertices.empty() || !edit.inserted.offsets.empty()) {
      update.inserted.reserve(static_cast<std::size_t>(edit.inserted.constraint_count()));
      for (Index c = 0; c < edit.inserted.constraint_count(); ++c) {
        update.inserted.push_back(insert(edit.inserted[c]));
      }
    }
    most_colors = find_most_colors();
    color_waiting();
    follow_up(edit.removed.size() + edit.merged.size() + update.inserted.size());
    drop_empty_colors();
    if (all_new) {
      note_full_coloring();
    }
    for (const Index id : update.inserted) {
      roles[id] = Role::none;
    }
    for (const Move& move : moves) {
      roles[move.id] = Role::none;
      if (color_of[move.id] != move.from) {
        update.recolored.push_back(move.id);
      }
    }
    std::sort(update.recolored.begin(), update.recolored.end());
    return update;
  }

  // Has what is at the vertices of a later constraint fetched into the cache meanwhile.
  void fetch_ahead(std::span<const Index> ids, std::size_t i) {
    constexpr std::size_t kAhead = 4;
    if (i + kAhead < ids.size()) {
      for (const Index v : constraints[ids[i + kAhead]]) {
        at_vertex.fetch(v);
      }
    }
  }

  void remove(Index id) {
    take(id);
    valences.subtract(constraints[id]);
    entries -= static_cast<std::int64_t>(constraints[id].size());
    constraints.clear(id);
    free_ids.push_back(id);
    --ids_there;
  }

  void merge(Index kept, Index gone) {
    if (color_of[kept] != kNoColor) {
      note_move(kept);
      take(kept);
    }
    if (constraints.arity() > 0) {
      remove(gone);
      return;
    }
    const auto a = constraints[kept];
    const auto b = constraints[gone];
    scratch.assign(a.begin(), a.end());
    scratch.insert(scratch.end(), b.begin(), b.end());
    std::sort(scratch.begin(), scratch.end());
    scratch.erase(std::unique(scratch.begin(), scratch.end()), scratch.end());
    valences.subtract(a);
    entries += static_cast<std::int64_t>(scratch.size() - a.size());
    remove(gone);
    constraints.assign(kept, scratch);
    valences.add(scratch);
  }

  // Where a merged constraint can keep its colour, it does.
  void put_back(const Move& move) {
    const ColorMasks masks = at_vertex.masks();
    const auto ids = constraints[move.id];
    if (std::none_of(ids.begin(), ids.end(), [&](Index v) { return masks.has(v, move.from); })) {
      put(move.id, move.from);
    } else {
      waiting.push_back(move.id);
    }
  }

  Index insert(std::span<const Index> vertices) {
    Index id = static_cast<Index>(color_of.size());
    if (free_ids.empty()) {
      color_of.push_back(kNoColor);
      position_of.push_back(0);
      roles.push_back(Role::none);
      constraints.resize(color_of.size());
    } else {
      id = free_ids.back();
      free_ids.pop_back();
    }
    constraints.assign(id, vertices);
    valences.add(vertices);
    entries += static_cast<std::int64_t>(vertices.size());
    ++ids_there;
    roles[id] = Role::inserted;
    waiting.push_back(id);
    return id;
  }

  void color_waiting() {
    sort_waiting();
    while (color_count() < valences.most()) {
      open_color();
    }
    for (std::size_t i = 0; i < waiting.size(); ++i) {
      const Index id = waiting[i];
      fetch_ahead(waiting, i);
      trail.clear();
      if (!find_place(id)) {
        Index color = find_color(constraints[id], color_count());  // of those that are closing
        if (color == kNoColor) {
          color = color_count();
          open_color();
        }
        put(id, color);
      }
    }
  }

  // By falling valence; those of equal valence stay in order.
  void sort_waiting() {
    scratch.assign(static_cast<std::size_t>(valences.most()) + 2, 0);
    const auto place = [&](Index id) { return valences.most() - valences.most(constraints[id]); };
    for (const Index id : waiting) {
      ++scratch[place(id) + 1];
    }
    std::partial_sum(scratch.begin(), scratch.end(), scratch.begin());
    sorted.resize(waiting.size());
    for (const Index id : waiting) {
      sorted[scratch[place(id)]++] = id;
    }
    waiting.swap(sorted);
  }

  // The emptiest colour below a limit that none of the vertices has.
  [[nodiscard]] Index find_color(std::span<const Index> vertices, Index limit) {
    const ColorMasks masks = at_vertex.masks();
    Index best = kNoColor;
    Index best_size = std::numeric_limits<Index>::max();
    for (int i = 0; 64 * i < limit; ++i) {
      for (std::uint64_t word = masks.free_word(vertices, i, limit); word != 0; word &= word - 1) {
        const Index color = 64 * i + lowest_bit(word);
        if (sizes[color] < best_size) {
          best = color;
          best_size = sizes[color];
        }
      }
    }
    return best;
  }
  [[nodiscard]] Index find_color(Index id) { return find_color(constraints[id], open_count()); }

  [[nodiscard]] Index find_color_or_make_room(Index id) {
    const Index color = find_color(id);
    return color != kNoColor ? color : make_room(id);
  }

  // Gives an open colour to a constraint that has none, whatever that takes.
  bool find_place(Index id) {
    if (const Index color = find_color_or_make_room(id); color != kNoColor) {
      put_on_trail(id, color);
      return true;
    }
    return pass_on(id);
  }

  // Which colours only one or two others keep from a constraint.
  void find_blockers(Index id) {
    const auto vertices = constraints[id];
    const ColorMasks masks = at_vertex.masks();
    passed.assign(vertices.size(), 0);
    singles.clear();
    pairs.clear();
    for (Index color = 0; color < open_count(); ++color) {
      Blockers blockers{color, {kInvalidIndex, kInvalidIndex}};
      int count = 0;
      for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (!masks.has(vertices[i], color)) {
          continue;
        }
        const Index holder = at_vertex.holders(vertices[i])[passed[i]++];
        if (holder != blockers.ids[0] && holder != blockers.ids[1]) {
          if (count < 2) {
            blockers.ids[count] = holder;
          }
          ++count;
        }
      }
      if (count == 1) {
        singles.push_back(blockers);
      } else if (count == 2) {
        pairs.push_back(blockers);
      }
    }
  }

  // Frees a colour for a constraint by moving the one or two others that hold it. Two of one colour
  // share no vertex, so each moves without regard to the other.
  [[nodiscard]] Index make_room(Index id) {
    find_blockers(id);
    for (const auto& [color, ids] : singles) {
      const Index other = find_color(ids[0]);
      if (other != kNoColor) {
        move(ids[0], other);
        return color;
      }
    }
    for (const auto& [color, ids] : pairs) {
      const Index other = find_color(ids[0]);
      if (other != kNoColor && find_color(ids[1]) != kNoColor) {
        move(ids[0], other);
        move(ids[1], find_color(ids[1]));
        return color;
      }
    }
    return kNoColor;
  }

  // Colours a constraint for which make_room() has failed: it takes the colour of one neighbour,
  // which then needs another, and so on until that can be had. All goes back if the walk gets stuck
  // or too long.
  bool pass_on(Index id) {
    const std::size_t start = trail.size();
    Index previous = kInvalidIndex;
    Index wanting = id;
    for (std::size_t steps = 0; steps < kLongestWalk; ++steps) {
      std::erase_if(singles, [&](const Blockers& b) { return b.ids[0] == previous; });
      if (singles.empty()) {
        break;
      }
      const auto [color, ids] = singles[random_bits(id, steps) % singles.size()];
      take_on_trail(ids[0]);
      put_on_trail(wanting, color);
      previous = std::exchange(wanting, ids[0]);
      if (const Index free = find_color_or_make_room(wanting); free != kNoColor) {
        put_on_trail(wanting, free);
        return true;
      }
    }
    roll_back(start);
    return false;
  }

  // ---- after the edit

  // Of the colours below this limit any may be taken; the others are closing.
  [[nodiscard]] Index open_count() const { return std::min(color_count(), most_colors); }

  // One more than the clique bound, or as many more as a full colouring has needed.
  [[nodiscard]] Index find_most_colors() {
    if (valences.most() < stuck_clique) {
      stuck_colors = 0;
    }
    const Index wanted = std::max(valences.most(), full_clique) + std::max(full_excess, Index{1});
    return std::max(wanted, stuck_colors);
  }

  void follow_up(std::size_t named) {
    work = 0;
    const std::int64_t budget = kMovesPerChange * static_cast<std::int64_t>(named);
    trail.clear();
    close_colors(budget);
    level(budget);
  }

  // Moves what the last colours hold to others. One is begun only where it can be ended, or to
  // begin with. If it cannot be emptied, what has left it in this edit comes back, and that is not
  // tried again until the clique bound falls.
  void close_colors(std::int64_t budget) {
    drop_empty_colors();
    while (color_count() > most_colors && work < budget) {
      if (trail.empty() && work > 0 && work + sizes.back() > budget) {
        break;  // better one colour too many than uneven ones
      }
      const Index id = members[color_count() - 1].back();
      take_on_trail(id);
      if (!find_place(id)) {
        roll_back(0);
        stuck_colors = most_colors = color_count();
        stuck_clique = valences.most();
      } else if (sizes.back() == 0) {
        drop_empty_colors();
        trail.clear();
      }
    }
  }

  // Moves members of the largest colours to the smallest that are free for them.
  void level(std::int64_t budget) {
    std::int64_t misses_left = kMisses;
    while (is_uneven() && work < budget && misses_left > 0) {
      const auto end = sizes.begin() + open_count();
      const auto largest = static_cast<Index>(std::max_element(sizes.begin(), end) - sizes.begin());
      const std::vector<Index>& ids = members[largest];
      const std::uint64_t draw = random_bits(ids.size(), static_cast<std::uint64_t>(misses_left));
      const Index id = ids[draw % ids.size()];
      const Index color = find_color(id);
      if (color != kNoColor && sizes[color] + 1 < (1 - kMostDeviation) * sizes[largest]) {
        move(id, color);
        misses_left += kMissesPerMove;
      } else {
        --misses_left;
      }
    }
  }

  // Whether the sizes of the open colours deviate from the most even ones possible by too much and
  // by more than one constraint.
  [[nodiscard]] bool is_uneven() const {
    std::int64_t count = ids_there;
    std::int64_t sum = squares;
    for (Index color = open_count(); color < color_count(); ++color) {
      count -= sizes[color];
      sum -= std::int64_t{sizes[color]} * sizes[color];
    }
    if (count == 0) {
      return false;
    }
    const std::int64_t colors = open_count();
    const std::int64_t each = count / colors;
    const std::int64_t larger = count % colors;
    const std::int64_t even = colors * each * each + larger * (2 * each + 1);
    const double most =
        std::max(kMostDeviation * static_cast<double>(count), static_cast<double>(colors));
    return static_cast<double>(colors) * static_cast<double>(sum - even) > most * most;
  }

  void open_color() {
    sizes.push_back(0);
    if (members.size() < sizes.size()) {
      members.emplace_back();
    }
    at_vertex.widen(color_count());
  }
  void drop_empty_colors() {
    while (!sizes.empty() && sizes.back() == 0) {
      sizes.pop_back();
    }
  }

  // ---- one constraint

  void put(Index id, Index color) {
    for (const Index v : constraints[id]) {
      at_vertex.put(v, color, id);
    }
    color_of[id] = color;
    position_of[id] = sizes[color];
    members[color].push_back(id);
    squares += 2 * std::int64_t{sizes[color]++} + 1;
  }
  void take(Index id) {
    const Index color = color_of[id];
    for (const Index v : constraints[id]) {
      at_vertex.take(v, color);
    }
    color_of[id] = kNoColor;
    const Index last = members[color].back();
    members[color][position_of[id]] = last;
    position_of[last] = position_of[id];
    members[color].pop_back();
    squares -= 2 * std::int64_t{--sizes[color]} + 1;
  }

  // These can be rolled back.
  void put_on_trail(Index id, Index color) {
    trail.push_back({id, kNoColor});
    put(id, color);
    ++work;
  }
  void take_on_trail(Index id) {
    note_move(id);
    trail.push_back({id, color_of[id]});
    take(id);
  }
  void move(Index id, Index color) {
    take_on_trail(id);
    put_on_trail(id, color);
  }
  void roll_back(std::size_t start) {
    for (; trail.size() > start; trail.pop_back()) {
      const auto [id, from] = trail.back();
      if (from == kNoColor) {
        take(id);
      } else {
        put(id, from);
      }
    }
  }

  void note_move(Index id) {
    if (roles[id] == Role::none) {
      roles[id] = Role::moved;
      moves.push_back({id, color_of[id]});
    }
  }

  ConstraintStore constraints;
  std::vector<Index> color_of;     // [id_count] kNoColor where there is none
  std::vector<Index> position_of;  // [id_count] among the members of its colour
  std::vector<Index> free_ids;
  Index ids_there = 0;
  std::int64_t entries = 0;  // vertices named by constraints

  VertexColors at_vertex;
  Valences valences;                        // an edit's constraints count before they have a colour
  std::vector<Index> sizes;                 // [color_count]
  std::vector<std::vector<Index>> members;  // [colours there have been] ids
  std::int64_t squares = 0;                 // sum of the squares of the sizes

  // at the last full colouring
  Index full_clique = 0;
  Index full_excess = 0;  // colours above the clique bound
  double full_deviation = 0;

  // when a colour last could not be closed
  Index stuck_colors = 0;
  Index stuck_clique = 0;

  // while an edit goes on
  std::vector<Role> roles;  // [id_count]
  std::vector<Index> waiting;
  std::vector<Index> sorted;
  std::vector<Index> scratch;
  std::vector<Index> passed;  // holders at each vertex with lower colours
  std::vector<Blockers> singles;
  std::vector<Blockers> pairs;
  std::vector<Move> moves;  // first colour of what has moved
  std::vector<Move> trail;  // what each has left since there was something to go back to
  Index most_colors = 0;    // colours from there on are closing
  std::int64_t work = 0;    // constraints moved
};

ConstraintVertices ColoringExtract::constraints() const {
  ConstraintVertices result;
  result.vertices = vertices;
  result.offsets = offsets;
  result.arity = arity;
  result.vertex_count = vertex_count;
  return result;
}

DynamicColoring::DynamicColoring(const ConstraintVertices& constraints, const Coloring& coloring)
    : data_(std::make_unique<Data>(constraints, coloring)) {}
DynamicColoring::~DynamicColoring() = default;
DynamicColoring::DynamicColoring(DynamicColoring&&) noexcept = default;
DynamicColoring& DynamicColoring::operator=(DynamicColoring&&) noexcept = default;

void DynamicColoring::add_vertices(Index count) {
  if (count < 0 || count > std::numeric_limits<Index>::max() - vertex_count()) {
    throw InvalidArgument(std::to_string(count) + " vertices cannot be added to " +
                          std::to_string(vertex_count()) +
                          "; there can be from as many to 2^31 - 1");
  }
  data_->add_vertices(count);
}

ColoringUpdate DynamicColoring::apply(const ConstraintEdit& edit) {
  return data_->apply(edit);
}

int DynamicColoring::arity() const {
  return data_->constraints.arity();
}

Index DynamicColoring::vertex_count() const {
  return data_->at_vertex.vertex_count();
}

Index DynamicColoring::constraint_count() const {
  return data_->ids_there;
}

Index DynamicColoring::id_count() const {
  return static_cast<Index>(data_->color_of.size());
}

bool DynamicColoring::contains(Index id) const {
  return data_->contains(id);
}

std::span<const Index> DynamicColoring::vertices(Index id) const {
  data_->check_there(id);
  return data_->constraints[id];
}

Index DynamicColoring::color(Index id) const {
  data_->check_there(id);
  return data_->color_of[id];
}

Index DynamicColoring::color_count() const {
  return data_->color_count();
}

std::span<const Index> DynamicColoring::color_sizes() const {
  return data_->sizes;
}

Index DynamicColoring::clique_bound() const {
  return data_->valences.most();
}

double DynamicColoring::relative_deviation() const {
  return data_->relative_deviation();
}

bool DynamicColoring::recoloring_pays() const {
  const double deviation = relative_deviation() - data_->full_deviation;
  return color_count() - clique_bound() > data_->full_excess + 2 ||
         (deviation > 0.1 && deviation * constraint_count() > color_count());
}

ColoringExtract DynamicColoring::extract() const {
  const Data& data = *data_;
  ColoringExtract result;
  result.arity = arity();
  result.vertex_count = vertex_count();
  result.ids.reserve(static_cast<std::size_t>(constraint_count()));
  result.vertices.reserve(static_cast<std::size_t>(data.entries));
  result.coloring.color_count = color_count();
  result.coloring.color_of.reserve(static_cast<std::size_t>(constraint_count()));
  if (arity() == 0) {
    result.offsets.push_back(0);
  }
  for (Index id = 0; id < id_count(); ++id) {
    if (!data.contains(id)) {
      continue;
    }
    const auto of_id = data.constraints[id];
    result.ids.push_back(id);
    result.vertices.insert(result.vertices.end(), of_id.begin(), of_id.end());
    if (arity() == 0) {
      result.offsets.push_back(static_cast<Index>(result.vertices.size()));
    }
    result.coloring.color_of.push_back(data.color_of[id]);
  }
  return result;
}

void DynamicColoring::adopt(const ColoringExtract& extract) {
  const ColoringExtract there = this->extract();
  if (extract.ids != there.ids || extract.vertices != there.vertices ||
      extract.offsets != there.offsets) {
    throw InvalidArgument(
        "the " + std::to_string(extract.ids.size()) + " constraints recoloured are not the " +
        std::to_string(there.ids.size()) + " that are there; an edit has come in between");
  }
  Data::check_valid(extract.coloring, there.constraints());
  data_->take_over(there.ids, extract.coloring);
}

}  // namespace pbdsurg
