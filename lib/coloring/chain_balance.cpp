// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/chain_balance.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "lib/coloring/color_gaps.h"
#include "lib/coloring/color_holders.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/color_tables.h"
#include "lib/coloring/constraint_access.h"

namespace pbdsurg {
namespace {

// The whole numbers around the mean of sizes.
struct MeanSize {
  Index floor;
  Index ceiling;

  explicit MeanSize(const std::vector<Index>& sizes) {
    const auto colors = static_cast<Index>(sizes.size());
    const Index colored = count_from(sizes, 0);
    floor = colored / colors;
    ceiling = floor + (colored % colors != 0 ? 1 : 0);
  }
};

// Sum of squared distances from them.
double unevenness(const std::vector<Index>& sizes) {
  const MeanSize mean(sizes);
  double squares = 0;
  for (const Index size : sizes) {
    const double off = std::max({size - mean.ceiling, mean.floor - size, Index{0}});
    squares += off * off;
  }
  return squares;
}

template <class Access>
class ChainBalance {
 public:
  ChainBalance(const Access& constraints, const ColorMasks& masks, const ColorHolders& holders,
               std::vector<Index>& color_of, std::vector<Index>& sizes)
      : constraints_(constraints),
        masks_(masks),
        holders_(holders),
        color_of_(color_of),
        sizes_(sizes),
        seen_(color_of.size(), 0) {}

  // Where a sweep is not enough, the next looks for longer chains.
  void run() {
    for (Index most = 2; most <= kMostReturning && !is_even(sizes_); most *= 2) {
      for (Index c = 0; c < constraints_.count; ++c) {
        if (color_of_[c] != kOverflowColor && sizes_[color_of_[c]] > mean_.ceiling) {
          move(c, most);
        }
      }
    }
  }

 private:
  static constexpr Index kMostReturning = 16;

  // To the first colour below the mean for which that brings the two sizes nearer to each other.
  void move(Index c, Index most_returning) {
    const Index from = color_of_[c];
    for (Index to = 0; to < static_cast<Index>(sizes_.size()); ++to) {
      if (sizes_[to] >= mean_.floor || !find_chain(c, to, most_returning)) {
        continue;
      }
      const Index moved = static_cast<Index>(chain_.size()) - 2 * returning_;
      if (moved > 0 && moved < sizes_[from] - sizes_[to]) {
        exchange(from, to);
        sizes_[from] -= moved;
        sizes_[to] += moved;
        return;
      }
    }
  }

  // Those of the constraint's colour and of another that hang together with it; false if too many
  // are of the other, as such chains gain little for what it costs to find them.
  bool find_chain(Index start, Index other, Index most_returning) {
    const Index both = color_of_[start] + other;
    ++search_;
    chain_.assign(1, start);
    seen_[start] = search_;
    returning_ = 0;
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      const Index color = both - color_of_[chain_[i]];
      for (const Index v : constraints_[chain_[i]]) {
        const Index holder = holders_.find(v, color, masks_.has(v, color), color_of_.data());
        if (holder == kInvalidIndex || seen_[holder] == search_) {
          continue;
        }
        if (color == other && ++returning_ > most_returning) {
          return false;
        }
        seen_[holder] = search_;
        chain_.push_back(holder);
      }
    }
    return true;
  }

  void exchange(Index one, Index other) {
    for (const Index c : chain_) {
      for (const Index v : constraints_[c]) {
        masks_.word(v, color_of_[c] >> 6) &= ~bit_of(color_of_[c]);
      }
    }
    for (const Index c : chain_) {
      color_of_[c] = one + other - color_of_[c];
      for (const Index v : constraints_[c]) {
        masks_.word(v, color_of_[c] >> 6) |= bit_of(color_of_[c]);
        if (holders_.table != nullptr) {
          holders_.at(v, color_of_[c]) = c;
        }
      }
    }
  }

  static std::uint64_t bit_of(Index color) { return std::uint64_t{1} << (color & 63); }

  const Access& constraints_;
  ColorMasks masks_;
  ColorHolders holders_;
  std::vector<Index>& color_of_;
  std::vector<Index>& sizes_;
  MeanSize mean_{sizes_};
  std::vector<Index> chain_;
  Index returning_ = 0;              // members of the chain that get the colour of its first
  std::vector<std::uint64_t> seen_;  // [constraint_count] the last search that came there
  std::uint64_t search_ = 0;
};

}  // namespace

bool is_even(const std::vector<Index>& sizes) {
  constexpr double kTolerance = 0.02;
  if (sizes.empty()) {
    return true;
  }
  const double mean = static_cast<double>(count_from(sizes, 0)) / static_cast<double>(sizes.size());
  const double most = kTolerance * mean;
  return unevenness(sizes) <= most * most * static_cast<double>(sizes.size());
}

void balance_by_chains(Coloring& coloring, const ConstraintVertices& constraints) {
  ColorTables tables = make_color_tables(coloring, constraints);
  HolderTable holders(coloring, constraints);
  with_arity(constraints, [&](const auto& access) {
    ChainBalance(access, {tables.masks.data(), tables.words}, holders.view(), coloring.color_of,
                 tables.sizes)
        .run();
  });
}

Coloring more_even_coloring(Coloring given, Coloring swept, const ConstraintVertices& constraints) {
  balance_by_chains(given, constraints);
  close_color_gaps(given);
  if (given.color_count <= swept.color_count &&
      unevenness(color_sizes(given)) < unevenness(color_sizes(swept))) {
    return given;
  }
  return swept;
}

}  // namespace pbdsurg
