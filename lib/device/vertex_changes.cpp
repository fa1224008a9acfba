// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_changes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

namespace pbdsurg::cuda {
namespace {

// The word of a member of an array's element; lanes follow it.
template <class Element>
std::uint32_t word_of(Index element, std::size_t member) {
  static_assert(sizeof(Element) % sizeof(std::uint32_t) == 0);
  return static_cast<std::uint32_t>((static_cast<std::size_t>(element) * sizeof(Element) + member) /
                                    sizeof(std::uint32_t));
}

// One lane of rows.
class LaneWriter {
 public:
  LaneWriter(Index lane, std::vector<WordChange>& words)
      : lane_(static_cast<std::uint32_t>(lane)), words_(words) {}

  template <class Row, class Number>
  void write(DeviceArray array, Index row, std::size_t member, const Number* lanes) {
    words_.push_back(
        {array, word_of<Row>(row, member) + lane_, std::bit_cast<std::uint32_t>(lanes[lane_])});
  }

  void write(DeviceArray array, RowRange range, std::span<const DampedRow> rows) {
    for (Index i = range.first; !rows.empty() && i < range.first + range.count; ++i) {
      write<DampedRow>(array, i, offsetof(DampedRow, stiffness), rows[i].stiffness);
      write<DampedRow>(array, i, offsetof(DampedRow, target), rows[i].target);
      write<DampedRow>(array, i, offsetof(DampedRow, damping), rows[i].damping);
    }
  }

 private:
  std::uint32_t lane_;
  std::vector<WordChange>& words_;
};

void write_range(Index block, std::size_t member, RowRange range, std::vector<WordChange>& words) {
  words.push_back({DeviceArray::vertex_blocks,
                   word_of<VertexBlock>(block, member + offsetof(RowRange, count)),
                   static_cast<std::uint32_t>(range.count)});
}

// Calls visit(index) with each that is listed.
template <class Visit>
void for_each_once(std::vector<Index> list, const Visit& visit) {
  std::ranges::sort(list);
  std::for_each(list.begin(), std::unique(list.begin(), list.end()), visit);
}

}  // namespace

void follow_vertex(const VertexBlocks& blocks, Index place, std::vector<WordChange>& words) {
  if (place >= blocks.vertex_count()) {
    return;
  }
  const auto [index, lane] = blocks.place_of(place);
  words.push_back({DeviceArray::lane_of_place, static_cast<std::uint32_t>(place),
                   static_cast<std::uint32_t>(lane_of(blocks, place))});
  if (index == kInvalidIndex) {
    return;
  }
  const VertexBlocks::Arrays arrays = blocks.arrays();
  const VertexBlock& block = arrays.blocks[index];
  const VertexBlocks::BlockRoom room = blocks.room_of(index);
  write_range(index, offsetof(VertexBlock, pulls), block.pulls, words);
  write_range(index, offsetof(VertexBlock, springs), block.springs, words);
  write_range(index, offsetof(VertexBlock, volumes), block.volumes, words);
  write_range(index, offsetof(VertexBlock, hinges), block.hinges, words);
  write_range(index, offsetof(VertexBlock, triangles), block.triangles, words);
  write_range(index, offsetof(VertexBlock, fibres), block.fibres, words);

  LaneWriter writer(lane, words);
  for (Index i = room.pulls.first; i < room.pulls.first + room.pulls.count; ++i) {
    const PullRow& row = arrays.pulls[i];
    constexpr auto kArray = DeviceArray::pull_rows;
    writer.write<PullRow>(kArray, i, offsetof(PullRow, neighbors), row.neighbors);
    writer.write<PullRow>(kArray, i, offsetof(PullRow, weights), row.weights);
  }
  for (Index i = room.springs.first; i < room.springs.first + room.springs.count; ++i) {
    const SpringRow& row = arrays.springs[i];
    constexpr auto kArray = DeviceArray::spring_rows;
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, neighbors), row.neighbors);
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, stiffness), row.stiffness);
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, rest), row.rest);
  }
  for (Index i = room.volumes.first; i < room.volumes.first + room.volumes.count; ++i) {
    const VolumeRow& row = arrays.volumes[i];
    constexpr auto kArray = DeviceArray::volume_rows;
    for (std::size_t k = 0; k < 3; ++k) {
      writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, face) + k * sizeof(row.face[k]),
                              row.face[k]);
    }
    writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, stiffness), row.stiffness);
    writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, target), row.target);
  }
  for (Index i = room.hinges.first; i < room.hinges.first + room.hinges.count; ++i) {
    const HingeRow& row = arrays.hinges[i];
    constexpr auto kArray = DeviceArray::hinge_rows;
    for (std::size_t k = 0; k < 3; ++k) {
      writer.write<HingeRow>(kArray, i,
                             offsetof(HingeRow, neighbors) + k * sizeof(row.neighbors[k]),
                             row.neighbors[k]);
    }
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, moment), row.moment);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, stiffness), row.stiffness);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, rest), row.rest);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, is_opposite), row.is_opposite);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, damping), row.damping);
  }
  for (Index i = room.triangles.first; i < room.triangles.first + room.triangles.count; ++i) {
    const TriangleRow& row = arrays.triangles[i];
    constexpr auto kArray = DeviceArray::triangle_rows;
    for (std::size_t k = 0; k < 2; ++k) {
      writer.write<TriangleRow>(kArray, i,
                                offsetof(TriangleRow, neighbors) + k * sizeof(row.neighbors[k]),
                                row.neighbors[k]);
      writer.write<TriangleRow>(
          kArray, i, offsetof(TriangleRow, weights) + k * sizeof(row.weights[k]), row.weights[k]);
    }
    writer.write<TriangleRow>(kArray, i, offsetof(TriangleRow, stiffness), row.stiffness);
    writer.write<TriangleRow>(kArray, i, offsetof(TriangleRow, target), row.target);
  }
  for (Index i = room.fibres.first; i < room.fibres.first + room.fibres.count; ++i) {
    const FibreRow& row = arrays.fibres[i];
    constexpr auto kArray = DeviceArray::fibre_rows;
    for (std::size_t k = 0; k < 3; ++k) {
      writer.write<FibreRow>(kArray, i,
                             offsetof(FibreRow, neighbors) + k * sizeof(row.neighbors[k]),
                             row.neighbors[k]);
      writer.write<FibreRow>(kArray, i, offsetof(FibreRow, shares) + k * sizeof(row.shares[k]),
                             row.shares[k]);
    }
    writer.write<FibreRow>(kArray, i, offsetof(FibreRow, stiffness), row.stiffness);
  }
  writer.write(DeviceArray::damped_spring_rows, room.springs, arrays.damped_springs);
  writer.write(DeviceArray::damped_volume_rows, room.volumes, arrays.damped_volumes);
  writer.write(DeviceArray::damped_triangle_rows, room.triangles, arrays.damped_triangles);
}

void follow_block(const VertexBlocks& blocks, Index block, std::vector<WordChange>& words) {
  if (block >= blocks.block_count()) {
    return;
  }
  const VertexBlock& from = blocks.arrays().blocks[block];
  // without its strips, which no kernel of a device reads
  constexpr std::size_t kWords = offsetof(VertexBlock, strips) / sizeof(std::uint32_t);
  std::array<std::uint32_t, kWords> values{};
  std::memcpy(values.data(), &from, sizeof values);
  constexpr std::size_t kIsDamped = offsetof(VertexBlock, is_damped) / sizeof(std::uint32_t);
  static_assert(offsetof(VertexBlock, has_angles) == offsetof(VertexBlock, is_damped) + 1);
  values[kIsDamped] = (from.is_damped ? 1U : 0U) |  // the word's other bytes are any
                      (from.has_angles ? 0x100U : 0U);
  const std::uint32_t first = word_of<VertexBlock>(block, 0);
  for (std::uint32_t w = 0; w < kWords; ++w) {
    words.push_back({DeviceArray::vertex_blocks, first + w, values[w]});
  }
  for (Index lane = 0; lane < from.lane_count; ++lane) {
    const Index place = place_at(from.corners[lane]);
    words.push_back({DeviceArray::lane_of_place, static_cast<std::uint32_t>(place),
                     static_cast<std::uint32_t>(block * kBlockLanes + lane)});
  }
}

void follow_rows(const SolverData& data, const Changes& changes, std::vector<WordChange>& words) {
  const VertexBlocks& blocks = data.vertex_blocks;
  std::vector<Index> places;
  for (const auto& [kind, id] : changes.constraints) {
    if (kind == PhaseKind::vertex) {
      places.push_back(id);
    }
  }
  for_each_once(std::move(places), [&](Index place) { follow_vertex(blocks, place, words); });
  const std::span<const float> shares = data.stable_substep.shares();
  const auto follow_share = [&](Index lane) {
    words.push_back({DeviceArray::stiffness_shares, static_cast<std::uint32_t>(lane),
                     std::bit_cast<std::uint32_t>(shares[lane])});
  };
  for_each_once(changes.blocks, [&](Index block) {
    follow_block(blocks, block, words);
    const bool has_shares = !shares.empty() && block < blocks.block_count();
    for (Index lane = 0; has_shares && lane < kBlockLanes; ++lane) {
      follow_share(block * kBlockLanes + lane);
    }
  });
  for_each_once(changes.shares, [&](Index place) {
    if (place < blocks.vertex_count() && blocks.place_of(place).block != kInvalidIndex) {
      follow_share(lane_of(blocks, place));
    }
  });
}

Index lane_of(const VertexBlocks& blocks, Index place) noexcept {
  const auto [block, lane] = blocks.place_of(place);
  return block == kInvalidIndex ? kInvalidIndex : block * kBlockLanes + lane;
}

}  // namespace pbdsurg::cuda
