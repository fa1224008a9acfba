// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/greedy.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/bits.h"
#include "pbdsurg/base/error.h"

#include "lib/coloring/constraint_access.h"
#include "lib/coloring/constraint_order.h"
#include "lib/coloring/first_fit.h"
#include "lib/coloring/valences.h"

namespace pbdsurg {
namespace {

std::vector<Index> order_by_valence(const ConstraintVertices& constraints) {
  const std::vector<Index> valence = count_valences(constraints);
  std::vector<std::pair<std::uint64_t, Index>> keys;
  keys.reserve(static_cast<std::size_t>(constraints.constraint_count()));
  with_arity(constraints, [&](const auto& access) {
    for (Index c = 0; c < access.count; ++c) {
      keys.emplace_back(~valence_key(access[c], valence.data()), c);
    }
  });
  std::sort(keys.begin(), keys.end());
  std::vector<Index> order;
  order.reserve(keys.size());
  for (const auto& key : keys) {
    order.push_back(key.second);
  }
  return order;
}

// Items in lists by an integer key, with constant-time moves between lists: what smallest-last and
// saturation take their next constraint from.
class Buckets {
 public:
  Buckets(std::vector<Index> keys, Index key_count)
      : key_(std::move(keys)),
        next_(key_.size()),
        previous_(key_.size()),
        head_(static_cast<std::size_t>(key_count), kInvalidIndex) {
    for (auto item = static_cast<Index>(key_.size()); item-- > 0;) {
      link(item);
    }
  }

  [[nodiscard]] Index key(Index item) const { return key_[item]; }
  [[nodiscard]] Index first(Index key) const { return head_[key]; }
  [[nodiscard]] Index next(Index item) const { return next_[item]; }
  [[nodiscard]] bool contains(Index item) const { return key_[item] != kInvalidIndex; }

  void remove(Index item) {
    unlink(item);
    key_[item] = kInvalidIndex;
  }
  void move(Index item, Index key) {
    unlink(item);
    key_[item] = key;
    link(item);
  }

 private:
  void link(Index item) {
    Index& head = head_[key_[item]];
    previous_[item] = kInvalidIndex;
    next_[item] = head;
    if (head != kInvalidIndex) {
      previous_[head] = item;
    }
    head = item;
  }
  void unlink(Index item) {
    if (previous_[item] == kInvalidIndex) {
      head_[key_[item]] = next_[item];
    } else {
      next_[previous_[item]] = next_[item];
    }
    if (next_[item] != kInvalidIndex) {
      previous_[next_[item]] = previous_[item];
    }
  }

  std::vector<Index> key_;
  std::vector<Index> next_, previous_;
  std::vector<Index> head_;
};

// Conflicts of each constraint, once per shared vertex.
template <class Access>
std::vector<Index> count_conflicts(const Access& constraints, const std::vector<Index>& valence) {
  std::vector<Index> conflicts(static_cast<std::size_t>(constraints.count), 0);
  for (Index c = 0; c < constraints.count; ++c) {
    for (const Index v : constraints[c]) {
      conflicts[c] += valence[v] - 1;
    }
  }
  return conflicts;
}

template <class Access>
std::vector<Index> order_smallest_last(const Access& constraints, const std::vector<Index>& valence,
                                       const IndexLists& vertex_constraints) {
  std::vector<Index> conflicts = count_conflicts(constraints, valence);
  const auto highest = std::max_element(conflicts.begin(), conflicts.end());
  const Index key_count = highest == conflicts.end() ? 1 : *highest + 1;
  Buckets left(std::move(conflicts), key_count);
  std::vector<Index> order(static_cast<std::size_t>(constraints.count));
  Index key = 0;
  for (Index place = constraints.count; place-- > 0;) {
    while (left.first(key) == kInvalidIndex) {
      ++key;
    }
    const Index c = left.first(key);
    left.remove(c);
    order[place] = c;
    for (const Index v : constraints[c]) {
      for (const Index other : vertex_constraints[v]) {
        if (left.contains(other)) {
          left.move(other, left.key(other) - 1);
          key = std::min(key, left.key(other));
        }
      }
    }
  }
  return order;
}

template <class Access>
Coloring color_by_saturation(const Access& constraints, const std::vector<Index>& valence,
                             const IndexLists& vertex_constraints) {
  const std::vector<Index> conflicts = count_conflicts(constraints, valence);
  // Colours seen at each vertex. A colour cannot exceed the number of conflicts.
  const auto highest = std::max_element(conflicts.begin(), conflicts.end());
  const Index color_limit = highest == conflicts.end() ? 1 : *highest + 1;
  std::size_t words = 1;
  std::vector<std::uint64_t> masks(vertex_constraints.offsets.size() - 1, 0);
  const auto used = [&](Index c, std::size_t word) {
    std::uint64_t bits = 0;
    for (const Index v : constraints[c]) {
      bits |= masks[v * words + word];
    }
    return bits;
  };
  const auto widen = [&] {
    std::vector<std::uint64_t> wider((vertex_constraints.offsets.size() - 1) * (words + 1), 0);
    for (std::size_t v = 0; v + 1 < vertex_constraints.offsets.size(); ++v) {
      std::copy_n(masks.begin() + v * words, words, wider.begin() + v * (words + 1));
    }
    masks = std::move(wider);
    ++words;
  };

  Coloring coloring;
  coloring.color_of.assign(static_cast<std::size_t>(constraints.count), kInvalidIndex);
  Buckets left(std::vector<Index>(static_cast<std::size_t>(constraints.count), 0), color_limit + 1);
  Index saturation = 0;
  for (Index done = 0; done < constraints.count; ++done) {
    while (left.first(saturation) == kInvalidIndex) {
      --saturation;
    }
    // most conflicts among the most saturated; looking at all of them would make it quadratic
    constexpr int kLook = 64;
    Index c = left.first(saturation);
    int looked = 1;
    for (Index other = left.next(c); other != kInvalidIndex && looked < kLook;
         other = left.next(other), ++looked) {
      if (conflicts[other] > conflicts[c] || (conflicts[other] == conflicts[c] && other < c)) {
        c = other;
      }
    }
    left.remove(c);
    std::size_t word = 0;
    std::uint64_t bits = used(c, 0);
    while (bits == ~std::uint64_t{0}) {
      if (++word == words) {
        widen();
      }
      bits = used(c, word);
    }
    const std::uint64_t bit = ~bits & (bits + 1);
    coloring.color_of[c] = static_cast<Index>(64 * word) + lowest_bit(bit);
    coloring.color_count = std::max(coloring.color_count, coloring.color_of[c] + 1);
    // an uncoloured neighbour is one colour more saturated unless it had seen this one
    for (const Index v : constraints[c]) {
      for (const Index other : vertex_constraints[v]) {
        if (left.contains(other) && (used(other, word) & bit) == 0) {
          left.move(other, left.key(other) + 1);
          saturation = std::max(saturation, left.key(other));
        }
      }
      masks[v * words + word] |= bit;
    }
  }
  return coloring;
}

}  // namespace

Coloring color_greedy(const ConstraintVertices& constraints, GreedyOrder order) {
  switch (order) {
    case GreedyOrder::natural:
      check_constraints(constraints);
      return first_fit(constraints);
    case GreedyOrder::largest_valence:
      check_constraints(constraints);
      return first_fit(constraints, order_by_valence(constraints));
    case GreedyOrder::smallest_last: {
      const IndexLists lists = find_vertex_constraints(constraints);
      std::vector<Index> sequence;
      with_arity(constraints, [&](const auto& access) {
        sequence = order_smallest_last(access, count_valences(constraints), lists);
      });
      return first_fit(constraints, sequence);
    }
    case GreedyOrder::saturation: {
      const IndexLists lists = find_vertex_constraints(constraints);
      Coloring coloring;
      with_arity(constraints, [&](const auto& access) {
        coloring = color_by_saturation(access, count_valences(constraints), lists);
      });
      return coloring;
    }
  }
  throw InvalidArgument("unknown greedy order " + std::to_string(static_cast<int>(order)));
}

}  // namespace pbdsurg
