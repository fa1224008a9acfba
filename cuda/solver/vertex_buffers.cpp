// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/vertex_buffers.h"

#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "lib/device/vertex_changes.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg::cuda {
namespace {

constexpr int kNothing = 0;    // a byte of rows that name the first place
constexpr int kNoLane = 0xff;  // of kInvalidIndex

// Of so many parts, one after another, each with the same room.
struct Room {
  std::size_t parts, size;
};

template <class T>
void upload_parts(DeviceBuffer<T>& buffer, std::span<const T> values, const Room& room, int byte,
                  cudaStream_t stream) {
  T* const start = buffer.fill(room.parts * room.size, byte, stream);
  for (std::size_t part = 0; part < room.parts && !values.empty(); ++part) {
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(start + part * room.size, values.data(), values.size_bytes(),
                                       cudaMemcpyHostToDevice, stream));
  }
}

std::size_t row_parts(const SolverData& data) {
  return static_cast<std::size_t>(data.vertex_blocks.has_damping() ? data.copy_count() : 1);
}

}  // namespace

void VertexBuffers::upload(const SolverData& data, bool has_grown, cudaStream_t stream) {
  const VertexBlocks& blocks = data.vertex_blocks;
  const VertexBlocks::Arrays host = blocks.arrays();
  counts_ = VertexCounts(data);
  room_ = with_room(counts_, data, has_grown);
  const std::size_t parts = row_parts(data);
  const std::size_t is_damped = blocks.has_damping() ? 1 : 0;
  const std::size_t has_shares = is_explicit(data.options) ? 1 : 0;
  std::vector<Index> lane_of_place(counts_.places);
  for (std::size_t v = 0; v < lane_of_place.size(); ++v) {
    lane_of_place[v] = lane_of(blocks, static_cast<Index>(v));
  }
  upload_parts(blocks_, host.blocks, {1, room_.blocks}, kNothing, stream);
  upload_parts(pulls_, host.pulls, {1, room_.pulls}, kNothing, stream);
  upload_parts(springs_, host.springs, {parts, room_.springs}, kNothing, stream);
  upload_parts(volumes_, host.volumes, {parts, room_.volumes}, kNothing, stream);
  upload_parts(hinges_, host.hinges, {parts, room_.hinges}, kNothing, stream);
  upload_parts(triangles_, host.triangles, {parts, room_.triangles}, kNothing, stream);
  upload_parts(fibres_, host.fibres, {1, room_.fibres}, kNothing, stream);
  upload_parts(damped_springs_, host.damped_springs, {is_damped, room_.springs}, kNothing, stream);
  upload_parts(damped_volumes_, host.damped_volumes, {is_damped, room_.volumes}, kNothing, stream);
  upload_parts(damped_triangles_, host.damped_triangles, {is_damped, room_.triangles}, kNothing,
               stream);
  upload_parts(lane_of_place_, std::span<const Index>(lane_of_place), {1, room_.places}, kNoLane,
               stream);
  upload_parts(shares_, data.stable_substep.shares(), {has_shares, room_.blocks * kBlockLanes},
               kNothing, stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the rows may change
  point(data);
}

void VertexBuffers::make_room(const SolverData& data, cudaStream_t stream) {
  if (!room_.has_room_for(counts_)) {
    enlarge(data, stream);
  }
  point(data);
  if (arrays_.guards != nullptr) {
    guards_.fill(static_cast<std::size_t>(data.copy_count()) * lane_room(), kNothing, stream);
  }
}

void VertexBuffers::enlarge(const SolverData& data, cudaStream_t stream) {
  const VertexCounts before = room_;
  VertexCounts room = with_room(counts_, data, true);
  room.include(before);
  const std::size_t parts = row_parts(data);
  const std::size_t is_damped = data.vertex_blocks.has_damping() ? 1 : 0;
  const std::size_t has_shares = is_explicit(data.options) ? 1 : 0;
  const auto enlarge_rows = [&](auto& buffer, std::size_t buffer_parts, auto count) {
    buffer.enlarge(buffer_parts, before.*count, room.*count, kNothing, stream);
  };
  enlarge_rows(blocks_, 1, &VertexCounts::blocks);
  enlarge_rows(pulls_, 1, &VertexCounts::pulls);
  enlarge_rows(springs_, parts, &VertexCounts::springs);
  enlarge_rows(volumes_, parts, &VertexCounts::volumes);
  enlarge_rows(hinges_, parts, &VertexCounts::hinges);
  enlarge_rows(triangles_, parts, &VertexCounts::triangles);
  enlarge_rows(fibres_, 1, &VertexCounts::fibres);
  enlarge_rows(damped_springs_, is_damped, &VertexCounts::springs);
  enlarge_rows(damped_volumes_, is_damped, &VertexCounts::volumes);
  enlarge_rows(damped_triangles_, is_damped, &VertexCounts::triangles);
  lane_of_place_.enlarge(1, before.places, room.places, kNoLane, stream);
  shares_.enlarge(has_shares, before.blocks * kBlockLanes, room.blocks * kBlockLanes, kNothing,
                  stream);
  room_ = room;
}

void VertexBuffers::point(const SolverData& data) {
  const std::size_t lanes = static_cast<std::size_t>(data.copy_count()) * lane_room();
  const bool has_guards = moves_vertices(data.options) && !data.custom.empty();
  arrays_ = {blocks_.get(),
             pulls_.get(),
             springs_.get(),
             volumes_.get(),
             hinges_.get(),
             triangles_.get(),
             fibres_.get(),
             damped_springs_.get(),
             damped_volumes_.get(),
             damped_triangles_.get(),
             holds_.reserve(lanes),
             has_guards ? guards_.reserve(lanes) : nullptr,
             lane_of_place_.get(),
             shares_.get(),
             data.vertex_blocks.block_count(),
             static_cast<Index>(room_.blocks),
             static_cast<Index>(room_.springs),
             static_cast<Index>(room_.volumes),
             static_cast<Index>(room_.hinges),
             static_cast<Index>(room_.triangles),
             data.vertex_blocks.has_damping(),
             room_.has_rare_rows()};
}

// Room and pieces are a power of two, so that few edits change what a step launches.
void FreePieceBuffers::take_over(const SolverData& data, Index vertex_room, cudaStream_t stream) {
  upload(data.free_pieces, vertex_room, stream);
  const std::size_t all =
      static_cast<std::size_t>(data.copy_count()) * static_cast<std::size_t>(arrays_.count);
  const bool may_join = all > 0 && moves_vertices(data.options);
  arrays_.groups = may_join && !data.custom.empty() ? groups_.reserve(all) : nullptr;
  arrays_.meeting = may_join && !data.contact_bodies.empty() ? meeting_.reserve(all) : nullptr;
  arrays_.touched = touched_.reserve(all);
  arrays_.sums = sums_.reserve(all);
}

void FreePieceBuffers::upload(const PieceLists& pieces, Index vertex_room, cudaStream_t stream) {
  if (revision_ == pieces.revision() && vertex_room == vertex_room_) {
    return;
  }
  const auto count = static_cast<std::size_t>(pieces.count());
  const std::size_t room = count == 0 ? 0 : std::bit_ceil(count);
  std::vector<Index> firsts(pieces.all_firsts().begin(), pieces.all_firsts().end());
  firsts.resize(room + 1, firsts.back());
  places_.reserve(std::bit_ceil(pieces.all_places().size()));
  arrays_ = {firsts_.upload(firsts, stream), places_.upload(pieces.all_places(), stream),
             static_cast<Index>(room)};
  std::vector<Index> piece_of(room > 0 ? static_cast<std::size_t>(vertex_room) : 0);
  pieces.find_pieces(piece_of);
  arrays_.piece_of_place = pieces_.upload(piece_of, stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists may change
  revision_ = pieces.revision();
  vertex_room_ = vertex_room;
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
    case DeviceArray::triangle_rows:
      return words(triangles_.get());
    case DeviceArray::fibre_rows:
      return words(fibres_.get());
    case DeviceArray::damped_spring_rows:
      return words(damped_springs_.get());
    case DeviceArray::damped_volume_rows:
      return words(damped_volumes_.get());
    case DeviceArray::damped_triangle_rows:
      return words(damped_triangles_.get());
    case DeviceArray::lane_of_place:
      return words(lane_of_place_.get());
    case DeviceArray::stiffness_shares:
      return words(shares_.get());
    case DeviceArray::tile_blocks:
    case DeviceArray::tile_neighbors:
    case DeviceArray::coarse_vertices:
    case DeviceArray::coarse_own_counts:
    case DeviceArray::coarse_own_places:
    case DeviceArray::coarse_member_counts:
    case DeviceArray::coarse_member_places:
    case DeviceArray::coarse_member_shares:
    case DeviceArray::distances:
    case DeviceArray::distance_damping:
    case DeviceArray::volumes:
    case DeviceArray::joints:
    case DeviceArray::neo_hookeans:
    case DeviceArray::fibres:
    case DeviceArray::membranes:
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
    bytes = static_cast<std::size_t>(arrays_.spring_room) * sizeof(SpringRow);
  } else if (arrays_.is_damped && array == DeviceArray::volume_rows) {
    bytes = static_cast<std::size_t>(arrays_.volume_room) * sizeof(VolumeRow);
  } else if (arrays_.is_damped && array == DeviceArray::hinge_rows) {
    bytes = static_cast<std::size_t>(arrays_.hinge_room) * sizeof(HingeRow);
  } else if (arrays_.is_damped && array == DeviceArray::triangle_rows) {
    bytes = static_cast<std::size_t>(arrays_.triangle_room) * sizeof(TriangleRow);
  }
  return bytes / sizeof(std::uint32_t);
}

std::size_t VertexBuffers::memory_bytes() const noexcept {
  return blocks_.memory_bytes() + pulls_.memory_bytes() + springs_.memory_bytes() +
         volumes_.memory_bytes() + damped_springs_.memory_bytes() + damped_volumes_.memory_bytes() +
         hinges_.memory_bytes() + triangles_.memory_bytes() + damped_triangles_.memory_bytes() +
         fibres_.memory_bytes() + holds_.memory_bytes() + guards_.memory_bytes() +
         lane_of_place_.memory_bytes() + shares_.memory_bytes();
}

}  // namespace pbdsurg::cuda
