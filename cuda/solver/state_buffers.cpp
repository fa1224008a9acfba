// SPDX-License-Identifier: Apache-2.0
#include "solver/state_buffers.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "solver/word_kernels.h"

namespace pbdsurg::cuda {
namespace {

constexpr std::size_t kLeastMotionRoom = 1024;

}  // namespace

StateBuffers::StateBuffers(const SolverData& data, std::size_t motion_room, cudaStream_t stream)
    : copy_count_(data.copy_count()) {
  const std::size_t count = data.particles.size();
  std::vector<Index> vertex_of_place(count);
  for (std::size_t v = 0; v < count; ++v) {
    vertex_of_place[data.place_of_vertex[v]] = static_cast<Index>(v);
  }
  const std::size_t all = static_cast<std::size_t>(data.copy_count()) * count;
  const std::size_t falling = data.falling.empty() ? 0 : all;
  arrays_ = {particles_.reserve(all),   previous_.reserve(all),
             velocities_.reserve(all),  vertex_of_place_.upload(vertex_of_place, stream),
             falling_.reserve(falling), flights_.reserve(falling),
             static_cast<Index>(count)};
  reserve_motion(std::max(motion_room, kLeastMotionRoom));
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the list goes
}

void StateBuffers::upload(const SolverData& data, Index copy, cudaStream_t stream) {
  const CopyState& state = data.copy(copy);
  const std::size_t count = state.particles.size();
  if (count == 0) {
    return;
  }
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(arrays_.particles + start(copy), state.particles.data(),
                                     count * sizeof(Particle), cudaMemcpyHostToDevice, stream));
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(arrays_.velocities + start(copy), state.velocities.data(),
                                     count * sizeof(Velocity), cudaMemcpyHostToDevice, stream));
  if (arrays_.falling != nullptr) {
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(arrays_.falling + start(copy), state.falling.data(),
                                       count * sizeof(float), cudaMemcpyHostToDevice, stream));
  }
}

void StateBuffers::fetch(SolverData& data, Index copy, cudaStream_t stream) {
  CopyState& state = data.copy(copy);
  const std::size_t count = state.particles.size();
  if (count == 0) {
    return;
  }
  Particle* const fetched = fetched_particles_.reserve(count);
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(fetched, arrays_.particles + start(copy),
                                     count * sizeof(Particle), cudaMemcpyDeviceToHost, stream));
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(state.velocities.data(), arrays_.velocities + start(copy),
                                     count * sizeof(Velocity), cudaMemcpyDeviceToHost, stream));
  if (arrays_.falling != nullptr) {
    PBDSURG_CUDA_CHECK(cudaMemcpyAsync(state.falling.data(), arrays_.falling + start(copy),
                                       count * sizeof(float), cudaMemcpyDeviceToHost, stream));
  }
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
  for (std::size_t place = 0; place < count; ++place) {
    const Particle& p = fetched[place];
    state.particles[place] = {p.x, p.y, p.z, state.particles[place].w};
  }
}

void StateBuffers::read(Index copy, std::span<const Index> places, std::span<Eigen::Vector3f> out,
                        cudaStream_t stream) {
  Vec3<float>* const read = read_positions_.reserve(places.size());
  gather_positions(arrays_.particles + start(copy), read_places_.upload(places, stream), read,
                   static_cast<Index>(places.size()), stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = {read[i].x, read[i].y, read[i].z};
  }
}

void StateBuffers::ask_for_motion(std::span<const Index> places, cudaStream_t stream) {
  const std::size_t size = static_cast<std::size_t>(copy_count_) * places.size();
  if (size > motion_room_) {
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the read before may be at work
    reserve_motion(std::bit_ceil(size));
  }
  gather_motion(
      {arrays_.particles, arrays_.velocities, arrays_.falling, arrays_.count, copy_count_},
      asked_places_.upload(places, stream), motion_.get(), static_cast<Index>(places.size()),
      stream);
}

void StateBuffers::reserve_motion(std::size_t size) {
  motion_.reserve(size);
  asked_places_.reserve(size);
  motion_room_ = size;
}

void StateBuffers::collect_motion(Index copy, std::span<VertexMotion> out, cudaStream_t stream) {
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
  std::copy_n(motion_.get() + static_cast<std::size_t>(copy) * out.size(), out.size(), out.begin());
}

std::size_t StateBuffers::memory_bytes() const noexcept {
  return particles_.memory_bytes() + previous_.memory_bytes() + velocities_.memory_bytes() +
         falling_.memory_bytes() + flights_.memory_bytes() + vertex_of_place_.memory_bytes() +
         read_places_.memory_bytes() + asked_places_.memory_bytes();
}

}  // namespace pbdsurg::cuda
