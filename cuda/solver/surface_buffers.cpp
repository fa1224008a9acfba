// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/surface_buffers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <vector>

#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda {

void SurfaceBuffers::take_over(const SolverData& data, const Room& room, cudaStream_t stream) {
  if (seen_surface_ != data.surface.revision() || room.vertices != room_.vertices) {
    upload_triangles(data.surface, room.vertices, stream);
    seen_surface_ = data.surface.revision();
  }
  if (room != room_ || room_.meeters == 0) {
    seen_firmness_.reset();
  }
  make_room(data, room, stream);
  if (seen_firmness_ != data.contact_firmness.revision()) {
    upload_firmness(data.contact_firmness, stream);
    seen_firmness_ = data.contact_firmness.revision();
  }
}

void SurfaceBuffers::make_room(const SolverData& data, const Room& room, cudaStream_t stream) {
  const auto copies = static_cast<std::size_t>(data.copy_count());
  const Index candidates =
      room.vertices * (1 + room.half_spaces) + kFeaturesOfTriangle * arrays_.triangle_count;
  if (room == room_ && candidates == arrays_.candidate_room) {
    return;
  }
  const Index most = std::min(candidates, data.options.contact_capacity);
  const Index contacts = room.meeters * most;
  const std::size_t of_tools = copies * static_cast<std::size_t>(room.meeters);
  const std::size_t of_all = copies * static_cast<std::size_t>(contacts);
  const std::size_t of_places = copies * static_cast<std::size_t>(room.vertices);
  const std::size_t ends = copies * static_cast<std::size_t>(1 + room.meeters);
  SurfaceArrays& arrays = arrays_;
  arrays.met_counts = met_counts_.fill(of_tools, 0, stream);
  arrays.found = found_.reserve(of_all);
  arrays.list_memory = list_memory_.reserve(of_all * kListBytes);
  arrays.contacts = contacts_.reserve(of_all);
  arrays.ends = ends_.fill(ends, 0, stream);
  arrays.level_counts = level_counts_.fill(copies, 0, stream);
  arrays.holds_at = holds_at_.fill(of_places, 0, stream);
  arrays.holds = holds_.reserve(3 * of_all);
  arrays.roots = roots_.reserve(3 * of_all);
  arrays.pushes = pushes_.reserve(3 * of_all);
  arrays.levels = levels_.reserve(of_all);
  arrays.handed = handed_.reserve(of_all);
  arrays.passed = passed_.fill(of_places, kNothingPassed & 0xFF, stream);
  arrays.stopped = stopped_.reserve(of_places);
  arrays.springs = springs_.reserve(of_tools);
  arrays.remembered = remembered_.reserve(of_all);
  arrays.remembered_ends = remembered_ends_.fill(ends, 0, stream);
  arrays.told = told_.reserve(of_all);
  arrays.told_remembered = told_remembered_.reserve(of_all);
  arrays.told_ends = told_ends_.reserve(ends);
  std::fill_n(arrays.told_ends, ends, 0);
  arrays.told_springs = told_springs_.reserve(of_tools);
  std::fill_n(arrays.told_springs, of_tools, ToolSpring{});
  arrays.has_springs = room.has_springs;
  arrays.candidate_room = candidates;
  arrays.tool_room = most;
  arrays.meeter_room = room.meeters;
  arrays.contact_room = contacts;
  room_ = room;
}

// In the order in which a host goes through them.
void SurfaceBuffers::upload_triangles(const TissueSurface& surface, Index vertex_room,
                                      cudaStream_t stream) {
  // edits change their number, and recorded steps shall stay
  const auto fill_up = [](std::vector<TissueSurface::PlaceTriangle>& triangles) {
    triangles.resize(triangles.empty() ? 0 : std::bit_ceil(triangles.size()),
                     {kInvalidIndex, kInvalidIndex, kInvalidIndex});
  };
  const auto upload = [&](const std::vector<TissueSurface::PlaceTriangle>& triangles,
                          DeviceBuffer<Index>& buffer) {
    return buffer.upload(
        {triangles.empty() ? nullptr : triangles.front().data(), 3 * triangles.size()}, stream);
  };
  std::vector<TissueSurface::PlaceTriangle> all, thin;
  surface.for_each_triangle([&](const auto& triangle) { all.push_back(triangle); });
  surface.for_each_thin([&](const auto& triangle) { thin.push_back(triangle); });
  fill_up(all);
  fill_up(thin);
  arrays_.triangles = upload(all, triangles_);
  arrays_.triangle_count = static_cast<Index>(all.size());
  arrays_.thin = upload(thin, thin_);
  arrays_.thin_count = static_cast<Index>(thin.size());
  const auto for_each_corner = [&](const auto& visit) {
    for (std::size_t t = 0; t < all.size(); ++t) {
      for (const Index place : all[t]) {
        if (place != kInvalidIndex) {
          visit(static_cast<Index>(t), place);
        }
      }
    }
  };
  std::vector<Index> first(static_cast<std::size_t>(vertex_room) + 1, 0);
  for_each_corner([&](Index, Index place) { ++first[place + 1]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Index> around(3 * all.size()), end(first.begin(), first.end() - 1);
  for_each_corner([&](Index triangle, Index place) { around[end[place]++] = triangle; });
  arrays_.first_around = first_around_.upload(first, stream);
  arrays_.around = around_.upload(around, stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists end here
}

void SurfaceBuffers::upload_firmness(const ContactFirmness& firmness, cudaStream_t stream) {
  std::vector<float> at_places(firmness.of_places().begin(), firmness.of_places().end());
  at_places.resize(static_cast<std::size_t>(room_.vertices), kPlainFirmness);
  arrays_.firmness = firmness_.upload(at_places, stream);
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));
}

void SurfaceBuffers::take_contacts(Index copy, std::span<const Index> meeters,
                                   CopyState& state) const {
  const auto first = static_cast<std::ptrdiff_t>(copy) * arrays_.contact_room;
  const Index* const ends =
      arrays_.told_ends + static_cast<std::ptrdiff_t>(copy) * (1 + arrays_.meeter_room);
  for (ToolState& tool : state.tools) {
    tool.surface_contacts.clear();
    tool.remembered.clear();
  }
  for (std::size_t m = 0; m < meeters.size(); ++m) {
    ToolState& tool = state.tools[meeters[m]];
    const SurfaceContact* const told = arrays_.told + first;
    const RememberedContact* const remembered = arrays_.told_remembered + first;
    tool.surface_contacts.assign(told + ends[m], told + ends[m + 1]);
    tool.remembered.assign(remembered + ends[m], remembered + ends[m + 1]);
    if (tool.is_coupled()) {
      tool.spring.displacement =
          arrays_.told_springs[copy * arrays_.meeter_room + static_cast<Index>(m)].displacement;
    }
  }
}

std::size_t SurfaceBuffers::memory_bytes() const noexcept {
  return triangles_.memory_bytes() + thin_.memory_bytes() + around_.memory_bytes() +
         first_around_.memory_bytes() + firmness_.memory_bytes() + met_counts_.memory_bytes() +
         found_.memory_bytes() + list_memory_.memory_bytes() + contacts_.memory_bytes() +
         ends_.memory_bytes() + levels_.memory_bytes() + level_counts_.memory_bytes() +
         holds_at_.memory_bytes() + holds_.memory_bytes() + roots_.memory_bytes() +
         pushes_.memory_bytes() + handed_.memory_bytes() + passed_.memory_bytes() +
         stopped_.memory_bytes() + springs_.memory_bytes() + remembered_.memory_bytes() +
         remembered_ends_.memory_bytes();
}

}  // namespace pbdsurg::cuda
