// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_counts.h"

#include <algorithm>
#include <array>

namespace pbdsurg::cuda {
namespace {

constexpr std::array kArrays{
    &VertexCounts::blocks, &VertexCounts::pulls,     &VertexCounts::springs, &VertexCounts::volumes,
    &VertexCounts::hinges, &VertexCounts::triangles, &VertexCounts::fibres,  &VertexCounts::places};

}  // namespace

std::size_t part_to_grow(std::size_t count) noexcept {
  constexpr std::size_t kFew = 256;
  return std::max(count / 8, std::min(count, kFew));
}

VertexCounts::VertexCounts(const SolverData& data) {
  const VertexBlocks::Arrays arrays = data.vertex_blocks.arrays();
  blocks = arrays.blocks.size();
  pulls = arrays.pulls.size();
  springs = arrays.springs.size();
  volumes = arrays.volumes.size();
  hinges = arrays.hinges.size();
  triangles = arrays.triangles.size();
  fibres = arrays.fibres.size();
  places = static_cast<std::size_t>(data.vertex_blocks.vertex_count());
}

void VertexCounts::include(const VertexCounts& others) noexcept {
  for (const auto array : kArrays) {
    this->*array = std::max(this->*array, others.*array);
  }
}

bool VertexCounts::has_room_for(const VertexCounts& others) const noexcept {
  return std::ranges::all_of(kArrays, [&](auto array) { return others.*array <= this->*array; });
}

VertexCounts with_room(const VertexCounts& counts, const SolverData& data, bool has_grown) {
  const VertexBlocks::Growth growth = data.vertex_blocks.expected_growth(data.options.spare);
  VertexCounts room = counts;
  room.blocks += growth.blocks;
  room.pulls += growth.pulls;
  room.springs += growth.springs;
  room.volumes += growth.volumes;
  room.hinges += growth.hinges;
  room.triangles += growth.triangles;
  room.fibres += growth.fibres;
  room.places += counts.places > 0 ? static_cast<std::size_t>(data.options.spare.vertices) : 0;
  if (has_grown) {
    VertexCounts grown = counts;
    for (const auto array : kArrays) {
      grown.*array += part_to_grow(counts.*array);
    }
    room.include(grown);
  }
  return room;
}

}  // namespace pbdsurg::cuda
