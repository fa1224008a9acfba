// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/coarse_buffers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "lib/device/vertex_counts.h"

namespace pbdsurg::cuda {
namespace {

template <class T>
void write(DeviceArray array, std::size_t first, const T& value, std::vector<WordChange>& words) {
  constexpr std::size_t kWords = sizeof(T) / sizeof(std::uint32_t);
  const auto of_value = std::bit_cast<std::array<std::uint32_t, kWords>>(value);
  for (std::size_t w = 0; w < kWords; ++w) {
    words.push_back({array, static_cast<std::uint32_t>(first * kWords + w), of_value[w]});
  }
}

std::size_t most_members(const CoarseSpace& space) {
  std::size_t most = 0;
  for (Index node = 0; node < space.node_count(); ++node) {
    most = std::max(most, space.members(node).places.size());
  }
  return most;
}

// Of an ascending list.
std::size_t number_before(const std::vector<Index>& places, Index first) {
  return static_cast<std::size_t>(std::ranges::lower_bound(places, first) - places.begin());
}

}  // namespace

void CoarseBuffers::upload(const SolverData& data, std::size_t capacity, cudaStream_t stream) {
  const CoarseSpace& space = data.coarse_space;
  if (space.node_count() == 0) {
    arrays_ = {};
    return;
  }
  const auto nodes = static_cast<std::size_t>(space.node_count());
  const std::size_t modes = space.stiffnesses().size();
  const std::size_t most = most_members(space);
  const auto spare = static_cast<std::size_t>(data.options.spare.vertices);
  const std::size_t room = most + part_to_grow(most) + std::min(spare, most);
  const std::size_t parts = (room + kNodePart - 1) / kNodePart;
  copy_count_ = static_cast<std::size_t>(data.copy_count());

  std::vector<Index> own_counts, counts, pieces;
  Index* const own_places = own_places_.reserve(nodes * room);
  Index* const places = member_places_.reserve(nodes * room);
  CoarseShares* const shares = member_shares_.reserve(nodes * room);
  const auto copy = [&](auto* to, const auto& from) {
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(to, from.data(), from.size() * sizeof(from[0]),
                                       cudaMemcpyHostToDevice, stream));
  };
  for (Index node = 0; node < space.node_count(); ++node) {
    const NodeMembers& members = space.members(node);
    own_counts.push_back(static_cast<Index>(members.own.size()));
    counts.push_back(static_cast<Index>(members.places.size()));
    pieces.push_back(space.piece_of(node));
    const std::size_t first = static_cast<std::size_t>(node) * room;
    copy(own_places + first, members.own);
    copy(places + first, members.places);
    copy(shares + first, members.shares);
  }
  CoarseVertex* const vertices = vertices_.fill(capacity, 0, stream);
  copy(vertices, space.vertices());
  arrays_ = {vertices,
             own_counts_.upload(own_counts, stream),
             own_places,
             member_counts_.upload(counts, stream),
             places,
             shares,
             pieces_.upload(pieces, stream),
             stiffnesses_.upload(space.stiffnesses(), stream),
             modes_.upload(space.all_modes(), stream),
             numbers_.upload(space.all_numbers(), stream),
             residuals_.fill(copy_count_ * capacity, 0, stream),
             moves_.fill(copy_count_ * capacity, 0, stream),
             part_sums_.reserve(copy_count_ * nodes * parts),
             part_gains_.reserve(copy_count_ * nodes * parts),
             sums_.reserve(copy_count_ * nodes),
             moves_of_nodes_.reserve(copy_count_ * nodes),
             gains_before_.reserve(copy_count_ * nodes),
             turns_.reserve(copy_count_ * nodes),
             amplitudes_.reserve(copy_count_ * modes),
             hold_modes_.reserve(copy_count_ * modes * kHoldRows),
             hold_parts_.reserve(copy_count_ * kMostModeParts * HoldSystem::entries(kHoldRows)),
             holds_.reserve(copy_count_),
             hold_sums_.reserve(copy_count_ * nodes * nodes),
             hold_counts_.reserve(copy_count_ * nodes),
             nullptr,
             nullptr,
             0,
             space.node_count(),
             space.piece_count(),
             static_cast<Index>(modes),
             static_cast<Index>(capacity),
             static_cast<Index>(room),
             static_cast<Index>(parts)};
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // lists end here, and the space may change
}

void CoarseBuffers::follow(SolverData& data, std::size_t capacity, std::vector<WordChange>& words,
                           cudaStream_t stream) {
  CoarseSpace& space = data.coarse_space;
  const Index first = space.take_first_changed();
  const auto place_count = static_cast<Index>(space.vertices().size());
  if (space.node_count() == 0) {
    return;
  }
  if (static_cast<std::size_t>(arrays_.vertex_room) < capacity ||
      static_cast<std::size_t>(arrays_.member_room) < most_members(space)) {
    upload(data, capacity, stream);
    return;
  }
  for (Index place = first; place < place_count; ++place) {
    write(DeviceArray::coarse_vertices, static_cast<std::size_t>(place), space.vertices()[place],
          words);
  }
  for (Index node = 0; node < space.node_count() && first <= place_count; ++node) {
    const auto& [own, places, shares] = space.members(node);
    const std::size_t start =
        static_cast<std::size_t>(node) * static_cast<std::size_t>(arrays_.member_room);
    for (auto i = number_before(own, first); i < own.size(); ++i) {
      write(DeviceArray::coarse_own_places, start + i, own[i], words);
    }
    for (auto i = number_before(places, first); i < places.size(); ++i) {
      write(DeviceArray::coarse_member_places, start + i, places[i], words);
      write(DeviceArray::coarse_member_shares, start + i, shares[i], words);
    }
    write(DeviceArray::coarse_own_counts, static_cast<std::size_t>(node),
          static_cast<Index>(own.size()), words);
    write(DeviceArray::coarse_member_counts, static_cast<std::size_t>(node),
          static_cast<Index>(places.size()), words);
  }
}

void CoarseBuffers::set_wides(Index count) {
  if (arrays_.node_count == 0) {
    return;
  }
  arrays_.wide_count = std::min(count, kMostWides);
  const std::size_t wides = copy_count_ * static_cast<std::size_t>(arrays_.wide_count);
  arrays_.wide_sums = wide_sums_.reserve(wides * static_cast<std::size_t>(arrays_.node_count));
  arrays_.wide_compliances = wide_compliances_.reserve(wides);
}

void CoarseBuffers::clear_residuals(cudaStream_t stream) {
  if (arrays_.node_count > 0) {
    residuals_.fill(copy_count_ * static_cast<std::size_t>(arrays_.vertex_room), 0, stream);
  }
}

std::uint32_t* CoarseBuffers::start(DeviceArray array) const noexcept {
  const auto words = [](auto* values) { return reinterpret_cast<std::uint32_t*>(values); };
  return array == DeviceArray::coarse_vertices        ? words(vertices_.get())
         : array == DeviceArray::coarse_own_counts    ? words(own_counts_.get())
         : array == DeviceArray::coarse_own_places    ? words(own_places_.get())
         : array == DeviceArray::coarse_member_counts ? words(member_counts_.get())
         : array == DeviceArray::coarse_member_places ? words(member_places_.get())
         : array == DeviceArray::coarse_member_shares ? words(member_shares_.get())
                                                      : nullptr;
}

std::size_t CoarseBuffers::memory_bytes() const noexcept {
  const auto bytes_of = [](const auto&... buffers) { return (buffers.memory_bytes() + ...); };
  return bytes_of(vertices_, own_counts_, own_places_, member_counts_, member_places_, pieces_,
                  member_shares_, stiffnesses_, modes_, numbers_, residuals_, moves_, part_sums_,
                  part_gains_, sums_, gains_before_, moves_of_nodes_, turns_, amplitudes_,
                  hold_modes_, hold_parts_, holds_, hold_sums_, hold_counts_, wide_sums_,
                  wide_compliances_);
}

}  // namespace pbdsurg::cuda
