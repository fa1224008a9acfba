// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/jones_plassmann.h"

#include <vector>

#include "pbdsurg/base/random.h"

#include "lib/coloring/claims.h"
#include "lib/coloring/constraint_order.h"
#include "lib/coloring/first_fit.h"

namespace pbdsurg {

Coloring color_jones_plassmann(const ConstraintVertices& constraints, std::uint64_t seed) {
  check_constraints(constraints);
  // ranks are unique in [0, 2^bits): put each constraint at its rank, then close the gaps
  const Index count = constraints.constraint_count();
  const int bits = rank_bits_for(count);
  const std::uint64_t salt = random_bits(seed, 0);
  std::vector<Index> at_rank(std::size_t{1} << bits, kInvalidIndex);
  for (Index c = 0; c < count; ++c) {
    at_rank[shuffled_rank(static_cast<std::uint32_t>(c), bits, salt)] = c;
  }
  std::erase(at_rank, kInvalidIndex);
  return first_fit(constraints, at_rank);
}

}  // namespace pbdsurg
