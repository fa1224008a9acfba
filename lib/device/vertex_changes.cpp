// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_changes.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

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

}  // namespace

void follow_vertex(const VertexBlocks& blocks, Index place, std::vector<WordChange>& words) {
  const auto [index, lane] = blocks.place_of(place);
  if (index == kInvalidIndex) {
    return;
  }
  const VertexBlocks::Arrays arrays = blocks.arrays();
  const VertexBlock& block = arrays.blocks[index];
  write_range(index, offsetof(VertexBlock, pulls), block.pulls, words);
  write_range(index, offsetof(VertexBlock, springs), block.springs, words);
  write_range(index, offsetof(VertexBlock, volumes), block.volumes, words);
  write_range(index, offsetof(VertexBlock, hinges), block.hinges, words);

  LaneWriter writer(lane, words);
  for (Index i = block.pulls.first; i < block.pulls.first + block.pulls.count; ++i) {
    const PullRow& row = arrays.pulls[i];
    constexpr auto kArray = DeviceArray::pull_rows;
    writer.write<PullRow>(kArray, i, offsetof(PullRow, neighbors), row.neighbors);
    writer.write<PullRow>(kArray, i, offsetof(PullRow, weights), row.weights);
  }
  for (Index i = block.springs.first; i < block.springs.first + block.springs.count; ++i) {
    const SpringRow& row = arrays.springs[i];
    constexpr auto kArray = DeviceArray::spring_rows;
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, neighbors), row.neighbors);
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, stiffness), row.stiffness);
    writer.write<SpringRow>(kArray, i, offsetof(SpringRow, rest), row.rest);
  }
  for (Index i = block.volumes.first; i < block.volumes.first + block.volumes.count; ++i) {
    const VolumeRow& row = arrays.volumes[i];
    constexpr auto kArray = DeviceArray::volume_rows;
    for (std::size_t k = 0; k < 3; ++k) {
      writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, face) + k * sizeof(row.face[k]),
                              row.face[k]);
    }
    writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, stiffness), row.stiffness);
    writer.write<VolumeRow>(kArray, i, offsetof(VolumeRow, target), row.target);
  }
  for (Index i = block.hinges.first; i < block.hinges.first + block.hinges.count; ++i) {
    const HingeRow& row = arrays.hinges[i];
    constexpr auto kArray = DeviceArray::hinge_rows;
    for (std::size_t k = 0; k < 3; ++k) {
      writer.write<HingeRow>(kArray, i,
                             offsetof(HingeRow, neighbors) + k * sizeof(row.neighbors[k]),
                             row.neighbors[k]);
    }
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, stiffness), row.stiffness);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, rest), row.rest);
    writer.write<HingeRow>(kArray, i, offsetof(HingeRow, is_opposite), row.is_opposite);
  }
  writer.write(DeviceArray::damped_spring_rows, block.springs, arrays.damped_springs);
  writer.write(DeviceArray::damped_volume_rows, block.volumes, arrays.damped_volumes);
  writer.write(DeviceArray::damped_hinge_rows, block.hinges, arrays.damped_hinges);
}

}  // namespace pbdsurg::cuda
