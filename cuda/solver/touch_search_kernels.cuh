// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where bodies meet each other in a substep, in no order; see touch_search.h. Of vertices and
/// edges that are near a group of triangles or edges each has a warp, whose threads look at groups,
/// then at those in groups that are near.

#include "cuda/solver/contact_crew.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/touch_contact.cuh"
#include "lib/solver/methods/edge_crossing.h"
#include "lib/solver/methods/touch_meeting.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kTouchThreads = 128;
constexpr Index kTouchWarps = kTouchThreads / kWarp;
static_assert(TouchArrays::kGroup == kWarp);

/// Where a substep starts: see touch_meeting.h.
struct DeviceTouchStart {
  const DeviceState& state;

  [[nodiscard]] __device__ Vec3<float> position(Index place) const {
    return position_of(
        load_particle((state.displacements == nullptr ? state.previous : state.particles) + place));
  }
  [[nodiscard]] __device__ float square_of_way(Index place) const {
    const Vec3<float> end = position_of(
        load_particle((state.flights != nullptr ? state.flights : moving_of(state)) + place));
    const Vec3<float> u = end - (counts_from_origin() ? position(place) : Vec3<float>{});
    return is_finite_way(u) ? dot(u, u) : 0.0F;
  }
  [[nodiscard]] __device__ float way(Index place) const { return sqrtf(square_of_way(place)); }
  [[nodiscard]] __device__ Vec3<float> own_start(Index place) const {
    return PBDSURG_KERNELS_NAMESPACE::own_start(state, place);
  }
  [[nodiscard]] __device__ Vec3<float> way_from_start(Index place) const {
    return position_of(load_particle(moving_of(state) + place)) - own_start(place);
  }
  [[nodiscard]] __device__ float mobility(Index place) const {
    return load_particle(state.particles + place).w;
  }
  [[nodiscard]] __device__ bool counts_from_origin() const {
    return state.displacements == nullptr;
  }
};

/// What the last substep left, or the host before the first of a part of a step.
struct RememberedTouches {
  const RememberedTouch* all;
  Index count;

  __device__ RememberedTouches(const TouchArrays& touches, StepInput* input, Index substep)
      : all(substep == 0 ? table<RememberedTouch>(input, input->touches) : touches.remembered),
        count(substep == 0 ? input->touch_count : __ldcg(touches.remembered_counts)) {}

  /// Null if there was none.
  [[nodiscard]] __device__ const RememberedTouch* find(const TouchSlot& slot) const {
    Index low = 0, high = count;
    while (low < high) {
      const Index middle = (low + high) / 2;
      const int order = all[middle].slot.compared_with(slot);
      if (order == 0) {
        return all + middle;
      }
      low = order < 0 ? middle + 1 : low;
      high = order < 0 ? high : middle;
    }
    return nullptr;
  }

  /// Likewise by all threads of a warp, which look at 32 places at a time.
  [[nodiscard]] __device__ const RememberedTouch* find_together(const TouchSlot& slot) const {
    const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
    for (Index low = 0, end = count; low < end;) {
      const Index step = (end - low + kWarp - 1) / kWarp;
      const Index own = low + lane * step;
      const int order = own < end ? all[own].slot.compared_with(slot) : 1;
      const unsigned same = __ballot_sync(~0U, order == 0);
      if (same != 0) {
        return all + low + (__ffs(static_cast<int>(same)) - 1) * step;
      }
      const Index before = __popc(__ballot_sync(~0U, order < 0));  // of those looked at
      if (before == 0) {
        return nullptr;
      }
      const Index next = low + before * step;
      low = next - step + 1;
      end = next < end ? next : end;
    }
    return nullptr;
  }
};

__device__ inline ContactBox box_of(const DeviceTouchStart& start, const Index* places, int count) {
  ContactBox box;
  for (int k = 0; k < count; ++k) {
    const Vec3<float> x = start.position(places[k]);
    if (!is_finite_way(x)) {
      return {};  // nowhere
    }
    box.add(x, x, 0);
  }
  return box;
}

/// With what is within reach, and a little more for what rounding takes off.
__device__ inline ContactBox wider(const ContactBox& box, float reach, float thickness) {
  constexpr float kRounding = 1e-3F;
  ContactBox result;
  result.add(box.low, box.high, (1 + 4 * kAsNear) * reach + kRounding * thickness);
  return result;
}

/// Fits the box of a group: a warp.
__device__ inline void fit_group(const TouchArrays& touches, const DeviceTouchStart& start,
                                 Index warp) {
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  ContactBox box;
  if (warp < touches.triangle_group_count) {
    const auto triangle = load_constant(touches.triangles + warp * kWarp + lane);
    if (triangle.index != kInvalidIndex) {
      box = box_of(start, triangle.corners, 3);
    }
  } else {
    const Index edge =
        __ldg(touches.edge_groups + (warp - touches.triangle_group_count) * kWarp + lane);
    if (edge != kInvalidIndex) {
      box = box_of(start, touches.edges[edge].ends, 2);
    }
  }
  float* const lows[] = {&box.low.x, &box.low.y, &box.low.z};
  float* const highs[] = {&box.high.x, &box.high.y, &box.high.z};
#pragma unroll
  for (int distance = kWarp / 2; distance > 0; distance /= 2) {
#pragma unroll
    for (int k = 0; k < 3; ++k) {
      const float low = __shfl_xor_sync(~0U, *lows[k], distance);
      const float high = __shfl_xor_sync(~0U, *highs[k], distance);
      *lows[k] = low < *lows[k] ? low : *lows[k];
      *highs[k] = high > *highs[k] ? high : *highs[k];
    }
  }
  if (lane == 0) {
    touches.boxes[warp] = {box.low, 0, box.high, 0};
  }
}

/// The longest way of a vertex in this substep, and since those that are near were searched: a
/// warp.
__device__ inline void find_motion(const TouchArrays& touches, const DeviceTouchStart& start,
                                   Index i, TouchSearchState& search) {
  const Index place = i < touches.vertex_count ? __ldg(&touches.vertices[i].place) : kInvalidIndex;
  const float most = kTouchWay * touches.thickest;
  float ahead = 0, moved = 0;  // m^2
  if (place != kInvalidIndex) {
    const float square = start.square_of_way(place);
    ahead = square < most * most ? square : most * most;
    const Vec3<float> d = start.position(place) - touches.seen[i];
    moved = __ldcg(&search.has_searched) != 0 && is_finite_way(d) ? dot(d, d) : 0.0F;
  }
  const int longest = -least_of_warp(-__float_as_int(ahead));
  const int farthest = -least_of_warp(-__float_as_int(moved));
  if (threadIdx.x % kWarp == 0 && longest > 0) {
    atomicMax(&search.most_way, static_cast<std::uint32_t>(longest));
  }
  if (threadIdx.x % kWarp == 0 && farthest > 0) {
    atomicMax(&search.most_moved, static_cast<std::uint32_t>(farthest));
  }
}

/// Boxes around groups, how far vertices go, and whether those that are near are to be searched.
__global__ void __launch_bounds__(kTouchThreads) fit_groups(DeviceState state, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  const DeviceTouchStart start{state};
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  const Index warp = thread_index() / kWarp;
  const Index groups = touches.triangle_group_count + touches.edge_group_count;
  TouchSearchState& search = *touches.searches;
  if (warp >= groups) {
    find_motion(touches, start, (warp - groups) * kWarp + lane, search);
  } else {
    fit_group(touches, start, warp);
  }
  if (is_last_block(&search.blocks_done) && threadIdx.x == 0) {
    const float way = sqrtf(__uint_as_float(__ldcg(&search.most_way)));
    const float moved = sqrtf(__uint_as_float(__ldcg(&search.most_moved)));
    const bool searches =
        __ldcg(&search.has_searched) == 0 || !(moved + way <= __ldcg(&search.slack));
    search.searches = searches ? 1 : 0;
    if (searches) {
      search.has_searched = 1;
      search.slack = way + kTouchSlack * touches.thickest;
      search.near_count = 0;
    }
    search.most_moved = 0;
  }
}

/// Whether the box of a group meets another: without a branch, so that many can be asked for at a
/// time.
__device__ inline bool meets(const GroupBox* group, const ContactBox& box) {
  const float4 low = __ldcg(reinterpret_cast<const float4*>(group));
  const float4 high = __ldcg(reinterpret_cast<const float4*>(group) + 1);
  return ((low.x <= box.high.x) & (box.low.x <= high.x) & (low.y <= box.high.y) &
          (box.low.y <= high.y) & (low.z <= box.high.z) & (box.low.z <= high.z)) != 0;
}

/// Calls visit(group), of the whole warp, for groups whose boxes meet another.
template <class Visit>
__device__ inline void for_each_near(const GroupBox* boxes, Index count, const ContactBox& box,
                                     const Visit& visit) {
  constexpr Index kAtOnce = 4;  // boxes of a thread
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  for (Index first = 0; first < count; first += kAtOnce * kWarp) {
    bool are_near[kAtOnce];
#pragma unroll
    for (Index i = 0; i < kAtOnce; ++i) {
      const Index group = first + i * kWarp + lane;
      are_near[i] = meets(boxes + (group < count ? group : 0), box) && group < count;
    }
    unsigned near[kAtOnce];
#pragma unroll
    for (Index i = 0; i < kAtOnce; ++i) {
      near[i] = __ballot_sync(~0U, are_near[i]);
    }
#pragma unroll 1
    for (Index i = 0; i < kAtOnce; ++i) {
      unsigned left = near[0];
#pragma unroll
      for (Index k = 1; k < kAtOnce; ++k) {  // in registers
        left = i == k ? near[k] : left;
      }
      for (; left != 0; left &= left - 1) {
        visit(first + i * kWarp + __ffs(static_cast<int>(left)) - 1);
      }
    }
  }
}

/// m, of any vertex in this substep.
__device__ inline float longest_way(const TouchArrays& touches) {
  return sqrtf(__uint_as_float(__ldcg(&touches.searches->most_way)));
}

/// What all of one search read.
struct TouchSearch {
  const DeviceTouchStart& start;
  const TouchArrays& touches;
  RememberedTouches remembered;
  float way;  ///< m, the longest in this substep
  float h, inverse_dt_squared;
  bool goes_on;  ///< from the forces of the substep before

  __device__ void begin(float distance, const TouchPair& pair, const RememberedTouch* known,
                        TissueTouch& touch) const {
    begin_touch(start, distance, pair.thickness, pair.friction, h, inverse_dt_squared,
                goes_on ? known : nullptr, touch);
  }
};

/// Where a vertex meets a body: all threads of a warp look for it, and one of them has what they
/// find.
/// @param shared  of the warp
/// @return        whether this thread has a contact
__device__ inline bool meet_vertex(const TouchSearch& search, const TouchVertex& vertex,
                                   NearPoint& shared, TissueTouch& touch) {
  const TouchArrays& touches = search.touches;
  const DeviceTouchStart& start = search.start;
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  const Vec3<float> x = start.position(vertex.place);
  const TouchBody& body = touches.bodies[vertex.other];
  const TouchPair& pair = touches.pairs[vertex.pair];
  const float limit = touch_limit(pair.thickness, search.way);
  const TouchTriangle* const triangles = touches.triangles + body.first_group * kWarp;
  const auto for_each_triangle = [&](float reach, const auto& visit) {
    ContactBox point;
    point.add(x, x, 0);
    for_each_near(touches.boxes + body.first_group, body.group_count,
                  wider(point, reach, pair.thickness),
                  [&](Index group) { visit(load_constant(triangles + group * kWarp + lane)); });
  };
  const TouchSlot slot = slot_of_vertex(vertex.place, body.body);
  const RememberedTouch* const known = search.remembered.find_together(slot);
  const Vec3<float>* const left = known != nullptr && !body.is_two_sided ? &known->normal : nullptr;
  // No farther than a limit.
  const auto find = [&](const TouchTriangle& triangle, float most, NearPoint& near) {
    return triangle.index != kInvalidIndex &&
           find_near(start, vertex.place, triangle.corners, left, near) && near.distance <= most &&
           touches.rules.may_meet(vertex.place, triangle.corners, vertex.body == body.body,
                                  kDeepestTouch * pair.thickness);
  };
  NearPoint nearest;  // of this thread, with its number
  nearest.distance = limit;
  Index own = kNoLevel;
  bool has_more = false;  // as near as that
  for_each_triangle(limit, [&](const TouchTriangle& triangle) {
    NearPoint near;
    if (!find(triangle, (1 + 2 * kAsNear) * nearest.distance, near)) {
      return;
    }
    if (own == kNoLevel || near.distance < nearest.distance) {
      has_more = own != kNoLevel && nearest.distance <= (1 + 2 * kAsNear) * near.distance;
      own = triangle.index;
      nearest = near;
    } else {
      has_more = true;
    }
  });
  const float least = least_of_warp(nearest.distance);
  if (!(least < limit)) {
    return false;
  }
  const bool is_near = own != kNoLevel && is_as_near(nearest, least);
  if (is_near) {
    face(start, nearest);
  }
  float most = is_near ? fabsf(nearest.alignment) : -1.0F;
  if (__any_sync(~0U, is_near && has_more) != 0) {
    for_each_triangle(least, [&](const TouchTriangle& triangle) {
      NearPoint near;
      if (find(triangle, (1 + kAsNear) * least, near)) {
        face(start, near);
        const float alignment = fabsf(near.alignment);
        most = alignment > most ? alignment : most;
      }
    });
    most = -least_of_warp(-most);
    own = kNoLevel;  // the first of those of this thread
    for_each_triangle(least, [&](const TouchTriangle& triangle) {
      NearPoint near;
      if (triangle.index < own && find(triangle, (1 + kAsNear) * least, near)) {
        face(start, near);
        if (faces_as_much(near, most)) {
          own = triangle.index;
          nearest = near;
        }
      }
    });
  } else {
    most = -least_of_warp(-most);
    own = is_near && faces_as_much(nearest, most) ? own : kNoLevel;
  }
  const Index first = least_of_warp(own);
  bool has_contact = first != kNoLevel && own == first;
  float distance = 0;
  if (has_contact) {
    shared = nearest;
    const TouchSide side = side_of(nearest, body.is_two_sided, known);
    distance = side.distance;
    touch = touch_of(slot, vertex.body, nearest, side.normal);
    has_contact = !(nearest.is_corner() && vertex.body > body.body) &&
                  is_within_reach(start, touch, pair.thickness, distance);
  }
  const unsigned owner = __ballot_sync(~0U, has_contact);
  if (owner == 0) {
    return false;
  }
  __syncwarp();
  const int from = __ffs(static_cast<int>(owner)) - 1;
  const Vec3<float> normal{__shfl_sync(~0U, touch.normal.x, from),
                           __shfl_sync(~0U, touch.normal.y, from),
                           __shfl_sync(~0U, touch.normal.z, from)};
  const PassedEdge passed(start, vertex.place, shared, normal, pair.thickness);
  if (passed.has_any()) {
    NearPoint best_face;
    float clear = passed.clear();
    Index of_face = kNoLevel;
    for_each_triangle(least, [&](const TouchTriangle& triangle) {
      NearPoint own_face;
      float own_clear = 0;
      if (triangle.index != kInvalidIndex &&
          passed.find_face(start, triangle.corners, own_face, own_clear) &&
          touches.rules.may_meet(vertex.place, triangle.corners, vertex.body == body.body,
                                 kDeepestTouch * pair.thickness) &&
          (own_clear > clear || (own_clear == clear && triangle.index < of_face))) {
        clear = own_clear;
        of_face = triangle.index;
        best_face = own_face;
      }
    });
    const float most_clear = -least_of_warp(-clear);
    const Index best = least_of_warp(clear == most_clear ? of_face : kNoLevel);
    if (best != kNoLevel) {
      has_contact = best == of_face && clear == most_clear;
      if (has_contact) {
        touch = touch_of(slot, vertex.body, best_face, best_face.outwards);
        distance = best_face.distance;
      }
    }
  }
  if (has_contact) {
    search.begin(distance, pair, known, touch);
  }
  return has_contact;
}

/// Where an edge meets those behind it: each thread finds its own.
__device__ inline void meet_edges(const TouchSearch& search, Index index) {
  const TouchArrays& touches = search.touches;
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  const CrossingEdge edge = touches.edges[index];
  const Index own_body = __ldg(touches.edge_bodies + index);
  const ContactBox box = box_of(search.start, edge.ends, 2);
  for (Index p = 0; p < touches.pair_count; ++p) {
    const TouchPair& pair = touches.pairs[p];
    if (pair.first != own_body && pair.second != own_body) {
      continue;
    }
    const TouchBody& body = touches.bodies[pair.first == own_body ? pair.second : pair.first];
    const float limit = touch_limit(pair.thickness, search.way);
    const auto visit = [&](Index group) {
      const Index other =
          __ldg(touches.edge_groups + (body.first_edge_group + group) * kWarp + lane);
      if (other <= index) {  // or none
        return;
      }
      const CrossingEdge its = touches.edges[other];
      if (!box_of(search.start, its.ends, 2).meets(wider(box, limit, pair.thickness))) {
        return;
      }
      const EdgeCrossing crossing(search.start, edge, its);
      if (!(crossing.distance() < limit) || !crossing.do_cross()) {
        return;
      }
      const Index link[] = {its.ends[0], its.ends[1], its.ends[1]};
      const float apart = kDeepestTouch * pair.thickness;
      const RememberedTouch* const known = search.remembered.find(crossing.slot());
      TissueTouch touch;
      float distance = 0;
      if (touches.rules.may_meet(edge.ends[0], link, edge.body == its.body, apart) &&
          touches.rules.may_meet(edge.ends[1], link, edge.body == its.body, apart) &&
          crossing.meet(pair.thickness, known, touch, distance)) {
        search.begin(distance, pair, known, touch);
        const Index i = atomicAdd(&touches.searches->crossing_count, 1);
        if (i < touches.crossing_room) {
          touches.crossings[i] = touch.slot.turn;
          touches.found[touches.vertex_count + i] = touch;
        }
      }
    };
    for_each_near(touches.boxes + touches.triangle_group_count + body.first_edge_group,
                  body.edge_group_count, wider(box, limit, pair.thickness), visit);
  }
}

/// The vertices and edges that are near what they may meet, in any order: a thread each looks at
/// all groups, side by side.
__global__ void __launch_bounds__(kTouchThreads)
    find_near_ones(DeviceState state, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  const DeviceTouchStart start{state};
  if (__ldcg(&touches.searches->searches) == 0) {
    return;
  }
  const float slack = __ldcg(&touches.searches->slack);
  const auto is_near_any = [&](const ContactBox& box, const TouchPair& pair, const GroupBox* boxes,
                               Index count) {
    const ContactBox reached =
        wider(box, kDeepestTouch * pair.thickness + 2 * slack, pair.thickness);
    bool is_near = false;
#pragma unroll 8
    for (Index g = 0; g < count; ++g) {
      is_near |= meets(boxes + g, reached);
    }
    return is_near;
  };
  const Index i = thread_index();
  bool is_near = false;
  if (i < touches.vertex_count) {
    const auto vertex = load_constant(touches.vertices + i);
    if (vertex.place != kInvalidIndex) {
      const TouchBody& body = touches.bodies[vertex.other];
      const ContactBox box = box_of(start, &vertex.place, 1);
      touches.seen[i] = start.position(vertex.place);
      is_near =
          box.low.x < kInfinity && is_near_any(box, touches.pairs[vertex.pair],
                                               touches.boxes + body.first_group, body.group_count);
    }
    touches.is_met[i] = 0;
  } else if (i < touches.vertex_count + touches.edge_count) {
    const Index edge = i - touches.vertex_count;
    const Index own = __ldg(touches.edge_bodies + edge);
    const ContactBox box =
        own != kInvalidIndex ? box_of(start, touches.edges[edge].ends, 2) : ContactBox{};
    for (Index p = 0; p < touches.pair_count && box.low.x < kInfinity; ++p) {
      const TouchPair& pair = touches.pairs[p];
      if (pair.first == own || pair.second == own) {
        const TouchBody& body = touches.bodies[pair.first == own ? pair.second : pair.first];
        is_near |= is_near_any(box, pair,
                               touches.boxes + touches.triangle_group_count + body.first_edge_group,
                               body.edge_group_count);
      }
    }
  }
  const unsigned near = __ballot_sync(~0U, is_near);
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  Index first = 0;
  if (lane == 0 && near != 0) {
    first = atomicAdd(&touches.searches->near_count, __popc(near));
  }
  first = __shfl_sync(~0U, first, 0);
  if (is_near) {
    touches.near[first + __popc(near & ((1U << lane) - 1))] = i;
  }
}

/// A warp takes one of them after another.
__global__ void __launch_bounds__(kTouchThreads, 3)
    meet_bodies(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  input += copy_index();
  __shared__ SharedRoom<NearPoint> rooms[kTouchWarps];
  NearPoint& room = rooms[static_cast<Index>(threadIdx.x) / kWarp].get();
  const DeviceTouchStart start{state};
  const TouchSearch search{start,
                           touches,
                           RememberedTouches(touches, input, substep),
                           longest_way(touches),
                           input->h,
                           input->substep.inverse_dt_squared,
                           state.flights != nullptr && !state.starts};
  const Index count = __ldcg(&touches.searches->near_count);
  for (Index n = thread_index() / kWarp; n < count; n += thread_count() / kWarp) {
    const Index i = __ldcg(touches.near + n);
    if (i >= touches.vertex_count) {
      meet_edges(search, i - touches.vertex_count);
      continue;
    }
    TissueTouch touch;
    const bool is_met = meet_vertex(search, load_constant(touches.vertices + i), room, touch);
    if (is_met) {
      touches.found[i] = touch;
    }
    const bool is_any = __any_sync(~0U, is_met) != 0;
    if (threadIdx.x % kWarp == 0) {
      touches.is_met[i] = is_any ? 1 : 0;
    }
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
