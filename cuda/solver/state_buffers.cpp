// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/state_buffers.h"

#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/room_to_grow.h"

namespace pbdsurg::cuda {
namespace {

constexpr std::size_t kLeastMotionRoom = 1024;

}  // namespace

// Whether there are pointers depends on options alone: also while there is no vertex.
DeviceState StateBuffers::Arrays::reserve(const SolverState& solver, std::size_t capacity) {
  const std::size_t all = static_cast<std::size_t>(solver.copy_count()) * capacity;
  const bool displaces = has_displacements(solver.options);
  const bool has_flights = moves_vertices(solver.options);
  const bool remembers = has_past(solver.options);
  return {particles.reserve(all),
          velocities.reserve(all),
          vertex_of_place.reserve(capacity),
          displaces ? nullptr : previous.reserve(all),
          displaces ? displacements.reserve(all) : nullptr,
          displaces ? carries.reserve(all) : nullptr,
          has_flights ? flights.reserve(all) : nullptr,
          has_flights ? fixed_points.reserve(all) : nullptr,
          has_flights
              ? LinkEnds{end_ways.reserve(all), end_gives.reserve(all), end_shears.reserve(all)}
              : LinkEnds{},
          remembers ? ways.reserve(all) : nullptr,
          remembers ? velocities_before.reserve(all) : nullptr,
          nullptr,
          nullptr,
          static_cast<Index>(capacity),
          is_explicit(solver.options)};
}

StateBuffers::StateBuffers(const SolverState& solver) : copy_count_(solver.copy_count()) {
  const auto spare = static_cast<std::size_t>(solver.options.spare.vertices);
  arrays_ = buffers_.reserve(solver, solver.particles.size() + spare);
  reserve_motion(kLeastMotionRoom);
}

void StateBuffers::make_room(const SolverState& solver, cudaStream_t stream) {
  if (solver.particles.size() <= static_cast<std::size_t>(arrays_.capacity)) {
    return;
  }
  Arrays larger;
  DeviceState now = larger.reserve(solver, room_to_grow(solver.particles.size()));
  if (arrays_.forces != nullptr) {
    now.forces = larger.forces.reserve(all_places(now.capacity));
  }
  if (arrays_.gravities != nullptr) {
    now.gravities = larger.gravities.reserve(static_cast<std::size_t>(now.capacity));
  }
  const auto keep = [&](auto* to, const auto* from, Index copies) {  // scratch starts anew
    if (from != nullptr && count_ > 0) {
      const auto pitch = [](const DeviceState& state) {
        return static_cast<std::size_t>(state.capacity) * sizeof(*to);
      };
      PBDSURG_CUDA_CHECK(cudaMemcpy2DAsync(to, pitch(now), from, pitch(arrays_),
                                           count_ * sizeof(*to), static_cast<std::size_t>(copies),
                                           cudaMemcpyDeviceToDevice, stream));
    }
  };
  keep(now.particles, arrays_.particles, copy_count_);
  keep(now.velocities, arrays_.velocities, copy_count_);
  keep(now.carries, arrays_.carries, copy_count_);
  keep(now.ways, arrays_.ways, copy_count_);
  keep(now.velocities_before, arrays_.velocities_before, copy_count_);
  keep(now.forces, arrays_.forces, copy_count_);
  keep(now.gravities, arrays_.gravities, 1);
  keep(now.vertex_of_place, arrays_.vertex_of_place, 1);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the smaller go
  buffers_ = std::move(larger);
  arrays_ = now;
}

void StateBuffers::take_over(const SolverState& solver, cudaStream_t stream) {
  if (count_ == 0) {
    std::vector<Index> vertex_of_place(solver.particles.size());
    for (std::size_t v = 0; v < vertex_of_place.size(); ++v) {
      vertex_of_place[solver.place_of_vertex[v]] = static_cast<Index>(v);
    }
    buffers_.vertex_of_place.upload(vertex_of_place, stream);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the list goes
  }
  count_ = solver.particles.size();
  for (Index copy = 0; copy < copy_count_; ++copy) {
    if (solver.changes.state[copy]) {
      upload(solver.copy(copy), copy, stream);
    }
  }
  upload_gravities(solver, stream);
  upload_forces(solver, stream);
  upload_moved(solver, stream);
}

void StateBuffers::upload_gravities(const SolverState& solver, cudaStream_t stream) {
  if (!solver.changes.gravities) {
    return;
  }
  arrays_.gravities = nullptr;
  if (!solver.gravities.empty()) {
    buffers_.gravities.reserve(static_cast<std::size_t>(arrays_.capacity));
    arrays_.gravities = buffers_.gravities.upload(solver.gravities, stream);
  }
}

// All, once there are any; then those that are named, which the device reads from the host's
// memory.
void StateBuffers::upload_forces(const SolverState& solver, cudaStream_t stream) {
  if (arrays_.forces == nullptr) {
    bool has_forces = false;
    for (Index copy = 0; copy < copy_count_; ++copy) {
      has_forces = has_forces || !solver.copy(copy).forces.empty();
    }
    if (!has_forces) {
      return;
    }
    arrays_.forces = buffers_.forces.fill(all_places(arrays_.capacity), 0, stream);
    for (Index copy = 0; copy < copy_count_; ++copy) {
      const std::vector<Load>& forces = solver.copy(copy).forces;
      if (!forces.empty()) {
        PBDSURG_CUDA_CHECK(cudaMemcpyAsync(arrays_.forces + start(copy), forces.data(),
                                           forces.size() * sizeof(Load), cudaMemcpyHostToDevice,
                                           stream));
      }
    }
    return;
  }
  const std::vector<Changes::Force>& changed = solver.changes.forces;
  if (changed.empty()) {
    return;
  }
  PlacedForce* placed = placed_forces_.reserve(std::bit_ceil(changed.size()));
  for (const auto& [copy, place] : changed) {
    const std::vector<Load>& forces = solver.copy(copy).forces;
    *placed++ = {forces.empty() ? Load{} : forces[place], copy, place};
  }
  write_forces(arrays_, placed_forces_.get(), static_cast<Index>(changed.size()), stream);
}

void StateBuffers::upload(const CopyState& state, Index copy, cudaStream_t stream) {
  const std::size_t count = state.particles.size();
  if (count == 0) {
    return;
  }
  const auto bring = [&](auto* to, const auto& from) {
    if (to != nullptr) {
      PBDSURG_CUDA_CHECK(cudaMemcpyAsync(to + start(copy), from.data(), count * sizeof(*to),
                                         cudaMemcpyHostToDevice, stream));
    }
  };
  bring(arrays_.particles, state.particles);
  bring(arrays_.velocities, state.velocities);
  bring(arrays_.carries, state.carries);
  bring(arrays_.ways, state.ways);
  bring(arrays_.velocities_before, state.velocities_before);
}

// The device reads them from the host's memory.
void StateBuffers::upload_moved(const SolverState& solver, cudaStream_t stream) {
  const std::vector<Index>& vertices = solver.changes.moved;
  if (vertices.empty()) {
    return;
  }
  const std::size_t size = static_cast<std::size_t>(copy_count_) * vertices.size();
  MovedVertex* moved = moved_.reserve(std::bit_ceil(size));  // edits differ in size
  for (Index copy = 0; copy < copy_count_; ++copy) {
    const CopyState& state = solver.copy(copy);
    for (const Index v : vertices) {
      const Index place = solver.place_of_vertex[v];
      *moved++ = {state.motion_of(place),
                  state.forces.empty() ? Load{} : state.forces[place],
                  solver.gravities.empty() ? Load{} : solver.gravities[place],
                  state.particles[place].w,
                  place,
                  v};
    }
  }
  write_vertices(arrays_, copy_count_, moved_.get(), static_cast<Index>(vertices.size()), stream);
}

void StateBuffers::fetch(SolverState& solver, Index copy, cudaStream_t stream) {
  CopyState& state = solver.copy(copy);
  const std::size_t count = std::min(count_, state.particles.size());
  if (count == 0) {
    return;
  }
  Particle* const fetched = fetched_particles_.reserve(count);
  PBDSURG_CUDA_CHECK(cudaMemcpyAsync(fetched, arrays_.particles + start(copy),
                                     count * sizeof(Particle), cudaMemcpyDeviceToHost, stream));
  const auto bring = [&](auto& to, const auto* from) {
    if (from != nullptr) {
      PBDSURG_CUDA_CHECK(cudaMemcpyAsync(to.data(), from + start(copy), count * sizeof(*from),
                                         cudaMemcpyDeviceToHost, stream));
    }
  };
  bring(state.velocities, arrays_.velocities);
  bring(state.carries, arrays_.carries);
  bring(state.ways, arrays_.ways);
  bring(state.velocities_before, arrays_.velocities_before);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
  for (std::size_t place = 0; place < count; ++place) {
    const Particle& p = fetched[place];
    state.particles[place] = {p.x, p.y, p.z, state.particles[place].w};
  }
}

void StateBuffers::read(Index copy, std::span<const Index> places, std::span<Eigen::Vector3f> out,
                        cudaStream_t stream) {
  const std::size_t room = std::bit_ceil(places.size());  // reads differ in size
  Vec3<float>* const read = read_positions_.reserve(room);
  Index* const asked = read_places_.reserve(room);  // the device reads them where they are
  std::ranges::copy(places, asked);
  gather_positions(arrays_.particles + start(copy), asked, read, static_cast<Index>(places.size()),
                   stream);
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
  gather_motion(arrays_, copy_count_, asked_places_.upload(places, stream), motion_.get(),
                static_cast<Index>(places.size()), stream);
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
  return buffers_.particles.memory_bytes() + buffers_.previous.memory_bytes() +
         buffers_.displacements.memory_bytes() + buffers_.flights.memory_bytes() +
         buffers_.fixed_points.memory_bytes() + buffers_.end_ways.memory_bytes() +
         buffers_.end_gives.memory_bytes() + buffers_.end_shears.memory_bytes() +
         buffers_.velocities.memory_bytes() + buffers_.carries.memory_bytes() +
         buffers_.ways.memory_bytes() + buffers_.velocities_before.memory_bytes() +
         buffers_.forces.memory_bytes() + buffers_.gravities.memory_bytes() +
         buffers_.vertex_of_place.memory_bytes() + asked_places_.memory_bytes();
}

}  // namespace pbdsurg::cuda
