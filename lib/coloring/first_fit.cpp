// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/first_fit.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/bits.h"

#include "lib/coloring/constraint_access.h"

namespace pbdsurg {
namespace {

constexpr Index kWindow = 64;  // colours that a vertex mask holds

// Colours what can take one of the 64 colours from `window` on, in the given order; returns the
// rest in the same order. What finds all 64 taken when its turn comes does not touch the masks, so
// window by window gives what one wide mask would.
template <class Access, class Order>
std::vector<Index> fill_window(const Access& constraints, const Order& order, Index count,
                               Index window, std::vector<std::uint64_t>& masks,
                               std::vector<Index>& color_of) {
  std::vector<Index> rest;
  for (Index i = 0; i < count; ++i) {
    const Index c = order(i);
    const auto ids = constraints[c];
    std::uint64_t used = 0;
    for (const Index v : ids) {
      used |= masks[v];
    }
    if (used == ~std::uint64_t{0}) {
      rest.push_back(c);
      continue;
    }
    const std::uint64_t bit = ~used & (used + 1);
    for (const Index v : ids) {
      masks[v] |= bit;
    }
    color_of[c] = window + lowest_bit(bit);
  }
  return rest;
}

}  // namespace

Coloring first_fit(const ConstraintVertices& constraints, std::span<const Index> order) {
  Coloring coloring;
  coloring.color_of.resize(static_cast<std::size_t>(constraints.constraint_count()));
  std::vector<std::uint64_t> masks(static_cast<std::size_t>(constraints.vertex_count), 0);
  with_arity(constraints, [&](const auto& access) {
    std::vector<Index> rest = order.empty() ? fill_window(
                                                  access, [](Index i) { return i; }, access.count,
                                                  0, masks, coloring.color_of)
                                            : fill_window(
                                                  access, [&](Index i) { return order[i]; },
                                                  access.count, 0, masks, coloring.color_of);
    for (Index window = kWindow; !rest.empty(); window += kWindow) {
      std::fill(masks.begin(), masks.end(), 0);
      rest = fill_window(
          access, [&](Index i) { return rest[i]; }, static_cast<Index>(rest.size()), window, masks,
          coloring.color_of);
    }
  });
  const auto highest = std::max_element(coloring.color_of.begin(), coloring.color_of.end());
  coloring.color_count = highest == coloring.color_of.end() ? 0 : *highest + 1;
  return coloring;
}

}  // namespace pbdsurg
