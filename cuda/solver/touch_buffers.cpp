// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/touch_buffers.h"

#include <algorithm>

namespace pbdsurg::cuda {

void TouchBuffers::take_over(const SolverData& data, Index vertex_room, cudaStream_t stream) {
  const ContactBodies& bodies = data.contact_bodies;
  if (bodies.empty()) {
    arrays_ = {};
    seen_.reset();
    return;
  }
  if (seen_ == bodies.revision() && vertex_room == vertex_room_) {
    return;
  }
  const bool are_others = seen_ != bodies.revision();
  seen_.reset();  // until all is there
  if (are_others) {
    upload(bodies, stream);
  }
  make_room(data, vertex_room, stream);
  seen_ = bodies.revision();
}

void TouchBuffers::upload(const ContactBodies& bodies, cudaStream_t stream) {
  const TouchLists lists(bodies);
  TouchArrays& arrays = arrays_;
  arrays.vertices = vertices_.upload(lists.vertices, stream);
  arrays.bodies = bodies_.upload(lists.bodies, stream);
  arrays.pairs = pairs_.upload(lists.pairs, stream);
  arrays.triangles = triangles_.upload(lists.triangles, stream);
  arrays.edges = edges_.upload(lists.edges, stream);
  arrays.edge_bodies = edge_bodies_.upload(lists.edge_bodies, stream);
  arrays.edge_groups = edge_groups_.upload(lists.edge_groups, stream);
  arrays.rules = {joined_.upload(bodies.joined_places(), stream),
                  rest_.upload(bodies.rest_positions(), stream),
                  first_neighbors_.upload(bodies.first_neighbors(), stream),
                  neighbors_.upload(bodies.neighbors(), stream)};
  const auto count_of = [](const auto& list) { return static_cast<Index>(list.size()); };
  arrays.vertex_count = count_of(lists.vertices);
  arrays.edge_count = count_of(lists.edges);
  arrays.pair_count = count_of(lists.pairs);
  arrays.triangle_group_count = count_of(lists.triangles) / TouchArrays::kGroup;
  arrays.edge_group_count = count_of(lists.edge_groups) / TouchArrays::kGroup;
  arrays.thickest = lists.thickest;
  PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists end here
}

void TouchBuffers::make_room(const SolverData& data, Index vertex_room, cudaStream_t stream) {
  // of edges, beyond those that there is room for: which of them are dropped then hangs on luck
  constexpr Index kMoreCrossings = 4096;
  const auto copies = static_cast<std::size_t>(data.copy_count());
  TouchArrays& arrays = arrays_;
  arrays.contact_room = data.options.contact_capacity;
  arrays.crossing_room = arrays.contact_room + kMoreCrossings;
  const auto all = [&](Index of_copy) { return copies * static_cast<std::size_t>(of_copy); };
  const std::size_t contacts = all(arrays.contact_room);
  const std::size_t holds = TissueTouch::kCorners * contacts;
  arrays.boxes = boxes_.reserve(all(arrays.triangle_group_count + arrays.edge_group_count));
  arrays.searches = searches_.fill(copies, 0, stream);
  arrays.seen = seen_positions_.reserve(all(arrays.vertex_count));
  arrays.near = near_.reserve(all(arrays.vertex_count + arrays.edge_count));
  arrays.is_met = is_met_.reserve(all(arrays.vertex_count));
  arrays.crossings = crossings_.reserve(all(arrays.crossing_room));
  arrays.found = found_.reserve(all(arrays.vertex_count + arrays.crossing_room));
  static_assert(kInvalidIndex == -1);  // all bits
  arrays.last_holds = last_holds_.fill(all(vertex_room), 0xff, stream);
  arrays.order = order_.reserve(contacts);
  arrays.contacts = contacts_.reserve(contacts);
  arrays.counts = counts_.fill(copies, 0, stream);
  arrays.level_counts = level_counts_.fill(copies, 0, stream);
  arrays.holds_at = holds_at_.fill(all(vertex_room), 0, stream);
  arrays.holds = holds_.reserve(holds);
  arrays.roots = roots_.reserve(holds);
  arrays.befores = befores_.reserve(holds);
  arrays.pushes = pushes_.reserve(holds);
  arrays.levels = levels_.reserve(all(arrays.crossing_room));
  arrays.remembered = remembered_.reserve(contacts);
  arrays.remembered_counts = remembered_counts_.fill(copies, 0, stream);
  arrays.told = told_.reserve(contacts);
  arrays.told_remembered = told_remembered_.reserve(contacts);
  arrays.told_counts = told_counts_.reserve(copies);
  std::fill_n(arrays.told_counts, copies, 0);
  vertex_room_ = vertex_room;
}

void TouchBuffers::take_contacts(Index copy, CopyState& state) const {
  state.touches.contacts.clear();
  state.touches.remembered.clear();
  if (seen_) {
    const auto first = static_cast<std::ptrdiff_t>(copy) * arrays_.contact_room;
    const Index count = arrays_.told_counts[copy];
    const TissueTouch* const told = arrays_.told + first;
    const RememberedTouch* const remembered = arrays_.told_remembered + first;
    state.touches.contacts.assign(told, told + count);
    state.touches.remembered.assign(remembered, remembered + count);
  }
}

std::size_t TouchBuffers::memory_bytes() const noexcept {
  const auto bytes_of = [](const auto&... buffers) { return (buffers.memory_bytes() + ...); };
  return bytes_of(vertices_, bodies_, pairs_, triangles_, edges_, edge_bodies_, edge_groups_,
                  joined_, rest_, first_neighbors_, neighbors_, boxes_, searches_, seen_positions_,
                  is_met_, near_, crossings_, found_, contacts_, last_holds_, order_, counts_,
                  level_counts_, holds_, roots_, befores_, levels_, remembered_counts_, holds_at_,
                  pushes_, remembered_);
}

}  // namespace pbdsurg::cuda
