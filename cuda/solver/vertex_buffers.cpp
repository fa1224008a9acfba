// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/vertex_buffers.h"

#include <span>
#include <vector>

namespace pbdsurg::cuda {
namespace {

// One after another, for each copy.
template <class Row>
Row* upload_copies(DeviceBuffer<Row>& buffer, std::span<const Row> rows, Index copy_count,
                   cudaStream_t stream) {
  Row* const start = buffer.reserve(static_cast<std::size_t>(copy_count) * rows.size());
  for (Index copy = 0; copy < copy_count && !rows.empty(); ++copy) {
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(start + static_cast<std::size_t>(copy) * rows.size(),
                                       rows.data(), rows.size_bytes(), cudaMemcpyHostToDevice,
                                       stream));
  }
  return start;
}

}  // namespace

void VertexBuffers::upload(const SolverData& data, cudaStream_t stream) {
  shares_revision_ = 0;  // these are laid out as blocks are
  const VertexBlocks& blocks = data.vertex_blocks;
  const VertexBlocks::Arrays host = blocks.arrays();
  const Index row_copies = blocks.has_damping() ? data.copy_count() : 1;
  const std::size_t lanes = host.blocks.size() * static_cast<std::size_t>(kBlockLanes);
  std::vector<Index> lane_of_place(host.blocks.empty() ? 0 : data.particles.size());
  for (std::size_t v = 0; v < lane_of_place.size(); ++v) {
    const auto [block, lane] = blocks.place_of(static_cast<Index>(v));
    lane_of_place[v] = block == kInvalidIndex ? kInvalidIndex : block * kBlockLanes + lane;
  }
  arrays_ = {blocks_.upload(host.blocks, stream),
             pulls_.upload(host.pulls, stream),
             upload_copies(springs_, host.springs, row_copies, stream),
             upload_copies(volumes_, host.volumes, row_copies, stream),
             upload_copies(hinges_, host.hinges, row_copies, stream),
             damped_springs_.upload(host.damped_springs, stream),
             damped_volumes_.upload(host.damped_volumes, stream),
             damped_hinges_.upload(host.damped_hinges, stream),
             holds_.reserve(static_cast<std::size_t>(data.copy_count()) * lanes),
             lane_of_place_.upload(lane_of_place, stream),
             nullptr,
             static_cast<Index>(host.blocks.size()),
             static_cast<Index>(host.springs.size()),
             static_cast<Index>(host.volumes.size()),
             static_cast<Index>(host.hinges.size()),
             blocks.has_damping()};
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the rows may change
}

void VertexBuffers::take_over(const StableSubstep& stable, cudaStream_t stream) {
  if (shares_revision_ == stable.revision()) {
    return;
  }
  arrays_.stiffness_shares = shares_.upload(stable.shares(), stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // they may change
  shares_revision_ = stable.revision();
}

void FreePieceBuffers::take_over(const PieceLists& pieces, cudaStream_t stream) {
  if (revision_ == pieces.revision()) {
    return;
  }
  arrays_ = {firsts_.upload(pieces.all_firsts(), stream),
             places_.upload(pieces.all_places(), stream), pieces.count()};
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists may change
  revision_ = pieces.revision();
}

std::uint32_t* VertexBuffers::start(DeviceArray array) const noexcept {
  const auto words = [](auto* rows) { return reinterpret_cast<std::uint32_t*>(rows); };
  switch (array) {
    case DeviceArray::vertex_blocks:
      return words(blocks_.get());
    case DeviceArray::pull_rows:
      return words(pulls_.get());
    case DeviceArray::spring_rows:
      return words(springs_.get());
    case DeviceArray::volume_rows:
      return words(volumes_.get());
    case DeviceArray::hinge_rows:
      return words(hinges_.get());
    case DeviceArray::damped_spring_rows:
      return words(damped_springs_.get());
    case DeviceArray::damped_volume_rows:
      return words(damped_volumes_.get());
    case DeviceArray::damped_hinge_rows:
      return words(damped_hinges_.get());
    case DeviceArray::distances:
    case DeviceArray::distance_damping:
    case DeviceArray::volumes:
    case DeviceArray::joints:
    case DeviceArray::neo_hookeans:
    case DeviceArray::strain_limits:
    case DeviceArray::bendings:
    case DeviceArray::stiff_links:
    case DeviceArray::tubes:
    case DeviceArray::particles:
    case DeviceArray::velocities:
    case DeviceArray::cluster:
      break;
  }
  return nullptr;
}

std::size_t VertexBuffers::stride(DeviceArray array) const noexcept {
  std::size_t bytes = 0;  // of a copy's own rows
  if (arrays_.is_damped && array == DeviceArray::spring_rows) {
    bytes = static_cast<std::size_t>(arrays_.spring_count) * sizeof(SpringRow);
  } else if (arrays_.is_damped && array == DeviceArray::volume_rows) {
    bytes = static_cast<std::size_t>(arrays_.volume_count) * sizeof(VolumeRow);
  } else if (arrays_.is_damped && array == DeviceArray::hinge_rows) {
    bytes = static_cast<std::size_t>(arrays_.hinge_count) * sizeof(HingeRow);
  }
  return bytes / sizeof(std::uint32_t);
}

std::size_t VertexBuffers::memory_bytes() const noexcept {
  return blocks_.memory_bytes() + pulls_.memory_bytes() + springs_.memory_bytes() +
         volumes_.memory_bytes() + damped_springs_.memory_bytes() + damped_volumes_.memory_bytes() +
         hinges_.memory_bytes() + damped_hinges_.memory_bytes() + holds_.memory_bytes() +
         lane_of_place_.memory_bytes() + shares_.memory_bytes();
}

}  // namespace pbdsurg::cuda
