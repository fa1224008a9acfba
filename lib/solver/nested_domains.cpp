// SPDX-License-Identifier: Apache-2.0
#include "solver/nested_domains.h"

#include <algorithm>

#include "pbdsurg/mesh/partition.h"

namespace pbdsurg {
namespace {

constexpr std::size_t kLeastLeaf = 3000;  // vertices

}  // namespace

NestedDomains::NestedDomains(std::span<const Eigen::Vector3d> positions) {
  const auto leaves =
      static_cast<Index>(std::bit_floor(std::max<std::size_t>(1, positions.size() / kLeastLeaf)));
  if (leaves == 1) {
    return;
  }
  level_count_ = static_cast<Index>(std::bit_width(static_cast<unsigned>(leaves)));
  // its parts are numbered as they are halved, so a domain's number is that of its leaves, shifted
  leaf_of_vertex_ = partition_vertices({}, positions, leaves, PartitionMethod::recursive_bisection)
                        .part_of_vertex;
}

}  // namespace pbdsurg
