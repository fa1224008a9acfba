// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/filling_buffers.h"

#include <algorithm>

#include "lib/device/filling_lists.h"
#include "lib/solver/methods/filling.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg::cuda {

void FillingBuffers::take_over(const SolverData& data, cudaStream_t stream) {
  const auto& sets = data.custom.sets();
  copy_count_ = static_cast<std::size_t>(data.copy_count());
  if (buffers_.size() != sets.size()) {
    has_ties_ = false;
    buffers_.resize(sets.size());
    arrays_.resize(sets.size());
    ++revision_;
  }
  for (std::size_t i = 0; i < sets.size(); ++i) {
    Buffers& buffers = buffers_[i];
    const Filling& filling = *sets[i]->filling();
    filling.check(*data.tissue);
    const std::uint64_t version = filling.surface().version;
    if (buffers.set != sets[i] || buffers.version != version) {
      has_ties_ = false;
      buffers.set = sets[i];
      arrays_[i] = upload_surface(data, buffers, stream);
      arrays_[i].is_first = i == 0;
      buffers.version = version;
      ++revision_;
    }
    upload_numbers(data, buffers, stream);
  }
  if (moves_vertices(data.options) && !sets.empty() &&
      (!has_ties_ || pieces_revision_ != data.free_pieces.revision())) {
    upload_ties(data, stream);
    pieces_revision_ = data.free_pieces.revision();
    has_ties_ = true;
  }
}

void FillingBuffers::upload_ties(const SolverData& data, cudaStream_t stream) {
  std::vector<std::span<const Index>> walls;
  for (const Buffers& buffers : buffers_) {
    walls.emplace_back(buffers.wall);
  }
  const std::vector<WallTies> ties = find_ties(walls, data.free_pieces, data.particles.size());
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    FillingArrays& arrays = arrays_[i];
    const FillingArrays before = arrays;
    arrays.is_shared = buffers_[i].is_shared.upload(ties[i].is_shared, stream);
    arrays.pieces = buffers_[i].pieces.upload(ties[i].pieces, stream);
    arrays.piece_count = static_cast<Index>(ties[i].pieces.size());
    arrays.is_anchored = ties[i].is_anchored;
    revision_ += arrays == before ? 0 : 1;
  }
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists end here
}

Index FillingBuffers::wall_count() const noexcept {
  return static_cast<Index>(std::ranges::count_if(
      arrays_, [](const FillingArrays& filling) { return filling.wall_count > 0; }));
}

FillingArrays FillingBuffers::upload_surface(const SolverData& data, Buffers& buffers,
                                             cudaStream_t stream) {
  const FillingLists lists(buffers.set->filling()->surface(), data.place_of_vertex);
  buffers.wall = lists.wall_count > 0 ? lists.places : std::vector<Index>();
  const auto copies = static_cast<std::size_t>(data.copy_count());
  const std::size_t vertices = copies * lists.places.size();
  const std::size_t triangles = copies * lists.triangles.size();
  const FillingArrays arrays{buffers.places.upload(lists.places, stream),
                             buffers.triangles.upload(lists.triangles, stream),
                             buffers.firsts.upload(lists.firsts, stream),
                             buffers.triangles_at.upload(lists.triangles_at, stream),
                             buffers.hole_ends.upload(lists.hole_ends, stream),
                             buffers.input.reserve(1),
                             buffers.copies.reserve(copies),
                             buffers.results.reserve(copies),
                             buffers.ways.reserve(vertices),
                             buffers.caps.reserve(triangles),
                             buffers.volumes.reserve(triangles),
                             buffers.thirds.reserve(triangles),
                             buffers.gradients.reserve(vertices),
                             buffers.gives.reserve(vertices),
                             nullptr,
                             nullptr,
                             static_cast<Index>(lists.places.size()),
                             static_cast<Index>(lists.triangles.size()),
                             lists.wall_count,
                             static_cast<Index>(lists.hole_ends.size()),
                             0,
                             false,
                             false};
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists end here
  return arrays;
}

void FillingBuffers::upload_numbers(const SolverData& data, Buffers& buffers, cudaStream_t stream) {
  const Filling& filling = *buffers.set->filling();
  FillingInput* const input = buffers.host_input.reserve(1);
  *input = {filling.law(), data.part.h};
  const auto copies = static_cast<std::size_t>(data.copy_count());
  FillingCopy* const states = buffers.host_copies.reserve(copies);
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    states[copy] = {filling.state(copy), {}, filling.is_new(copy), false};
    buffers.results.get()[copy] = filling.state(copy);
  }
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(buffers.input.get(), input, sizeof(FillingInput),
                                     cudaMemcpyHostToDevice, stream));
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(buffers.copies.get(), states, copies * sizeof(FillingCopy),
                                     cudaMemcpyHostToDevice, stream));
}

void FillingBuffers::give_back() {
  for (Buffers& buffers : buffers_) {
    for (std::size_t copy = 0; copy < copy_count_; ++copy) {
      buffers.set->filling()->take(static_cast<Index>(copy), buffers.results.get()[copy]);
    }
  }
}

std::size_t FillingBuffers::memory_bytes() const noexcept {
  std::size_t bytes = 0;
  for (const Buffers& each : buffers_) {
    bytes +=
        each.places.memory_bytes() + each.firsts.memory_bytes() + each.triangles_at.memory_bytes() +
        each.hole_ends.memory_bytes() + each.triangles.memory_bytes() + each.ways.memory_bytes() +
        each.caps.memory_bytes() + each.volumes.memory_bytes() + each.thirds.memory_bytes() +
        each.gradients.memory_bytes() + each.gives.memory_bytes() + each.input.memory_bytes() +
        each.is_shared.memory_bytes() + each.pieces.memory_bytes() + each.copies.memory_bytes();
  }
  return bytes;
}

}  // namespace pbdsurg::cuda
