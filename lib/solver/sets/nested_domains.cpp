// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/nested_domains.h"

#include <algorithm>
#include <numeric>

#include "pbdsurg/mesh/partition.h"

namespace pbdsurg {
namespace {

constexpr Index kLeastLeaf = 3000;
constexpr Index kPartSize = 32;  // vertices in no order of their own: a few cache lines

Index leaf_count(Index vertex_count) {
  return static_cast<Index>(
      std::bit_floor(static_cast<unsigned>(std::max<Index>(1, vertex_count / kLeastLeaf))));
}

}  // namespace

std::vector<Index> order_vertices(std::span<const Eigen::Vector3d> positions) {
  std::vector<Index> order(positions.size());
  std::iota(order.begin(), order.end(), 0);
  // Parts are numbered as they are halved. Their sizes differ by one at most, so those of small
  // parts would not add up to leaves of equal size.
  const auto sort_by_part = [&](Index part_count) {
    if (part_count > 1) {
      const Partition partition =
          partition_vertices({}, positions, part_count, PartitionMethod::recursive_bisection);
      std::ranges::stable_sort(order, {}, [&](Index v) { return partition.part_of_vertex[v]; });
    }
  };
  const auto count = static_cast<Index>(positions.size());
  sort_by_part(std::bit_floor(static_cast<unsigned>(std::max<Index>(1, count / kPartSize))));
  sort_by_part(leaf_count(count));
  std::vector<Index> places(positions.size());
  for (std::size_t place = 0; place < order.size(); ++place) {
    places[order[place]] = static_cast<Index>(place);
  }
  return places;
}

NestedDomains::NestedDomains(Index place_count) noexcept {
  const Index leaves = leaf_count(place_count);
  if (leaves > 1) {
    level_count_ = static_cast<Index>(std::bit_width(static_cast<unsigned>(leaves)));
    leaf_size_ = place_count / leaves;
    larger_leaves_ = place_count % leaves;
  }
}

}  // namespace pbdsurg
