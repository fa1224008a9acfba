// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold with a limit: see grip.h. One block a copy goes through the grips, for one may
/// hold what another does; sums are in the order of points, as on the host.

#include "cuda/solver/coarse_kernels.cuh"
#include "cuda/solver/contact_projection.cuh"
#include "cuda/solver/cooperative_kernels.cuh"
#include "cuda/solver/counted_points.cuh"
#include "cuda/solver/grip_points.cuh"
#include "cuda/solver/grip_projection.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/solver/methods/grip_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kGripThreads = 256;

/// One grip in a substep. All threads of a block call each of these, and meet in it.
class GripPatch {
 public:
  /// @param index  of the grip in its copy
  __device__ GripPatch(const DeviceState& state, StepInput* input, Index substep, Index index)
      : state_(state),
        input_(input),
        index_(index),
        tables_(input, substep, index),
        grip_(tables_.grip),
        reach_(grip_.limit * grip_.compliance / tables_.count) {}

  /// Puts targets where the tool is.
  /// @return  whether anchors slid in the substep before
  __device__ bool place() {
    const Vec3<float> slid = grip_.slide;
    for_each_point([&](GripPointInput& point) {
      point.target = tables_.pose.place(point.anchor);
      point.multiplier = {};
    });
    __syncthreads();  // all have read how far anchors slid
    if (threadIdx.x == 0) {
      grip_.slide = {};
    }
    __syncthreads();
    return slid.x != 0 || slid.y != 0 || slid.z != 0;
  }

  /// Of vertex blocks: anchors slide to where the pull is at the limit, if it is beyond.
  __device__ void slide() {
    const Vec3<float> slide = slide_within(mean_way(), reach_);
    if (threadIdx.x == 0) {
      grip_.slide = slide;
    }
    __syncthreads();
  }

  /// Vertices follow while anchors slide.
  __device__ void push(const VertexArrays& vertices, const ToolArrays& tools) {
    constexpr Index kCorners = kGripThreads / kVertexParts;  // at a time
    struct Answer {
      float force, stiffness;
      bool moves, is_held_elsewhere;
    };
    __shared__ Answer answers[kCorners];
    __shared__ Answer sum;
    const Vec3<float> mean = mean_way();
    const float size = length_of(mean);
    if (!(excess_of(size, reach_) > 0)) {
      return;
    }
    const Vec3<float> direction = (1 / size) * mean;
    const auto thread = static_cast<Index>(threadIdx.x);
    const Index part = thread % kVertexParts;
    if (thread == 0) {
      sum = {};
    }
    for (Index first = 0; first < grip_.corner_count; first += kCorners) {
      const Index c = first + thread / kVertexParts;
      Answer own{};
      if (c < grip_.corner_count && moves(tables_.corners[c].place)) {
        const Index place = tables_.corners[c].place;
        const Index block_lane = __ldg(vertices.lane_of_place + place);
        const WaitingLane access{state_.fixed_points,
                                 without_count(load_counted(state_.fixed_points + place)),
                                 block_lane % kBlockLanes};
        const VertexEnergy<float> energy =
            energy_of(state_, vertices, input_, block_lane / kBlockLanes, access, place, part);
        own = {tables_.corners[c].share * grip_.limit + dot(direction, energy.force),
               dot(direction, energy * direction), true, is_held_elsewhere(tools, place)};
      }
      if (part == 0) {
        answers[thread / kVertexParts] = own;
      }
      __syncthreads();
      for (Index i = 0; thread == 0 && i < kCorners; ++i) {
        if (answers[i].moves) {
          sum.force += answers[i].force;
          sum.stiffness += answers[i].stiffness;
          sum.is_held_elsewhere |= answers[i].is_held_elsewhere;
        }
      }
      __syncthreads();
    }
    const float balance = sum.force / sum.stiffness, furthest = size - reach_;
    const float way = furthest < balance ? furthest : balance;
    const bool follows = !sum.is_held_elsewhere && is_finite(way);
    __syncthreads();  // all have read the sum
    if (!follows) {
      return;
    }
    for (Index c = thread; c < grip_.corner_count; c += kGripThreads) {
      const Index place = tables_.corners[c].place;
      const Vec3<float> move = way * direction;
      if (moves(place) &&
          is_finite_way(position_of(load_particle(state_.displacements + place)) + move)) {
        displace(state_, place, move);
      }
    }
    __syncthreads();
    slide();
  }

  __device__ void find_multipliers() {
    const float scale = 1 / (grip_.compliance * input_->substep.inverse_dt_squared);
    for_each_point([&](GripPointInput& point) {
      const Vec3<float> multiplier = scale * way_to_jaws(state_, grip_, point);
      point.multiplier = is_finite_way(multiplier) ? multiplier : Vec3<float>{};
    });
    __syncthreads();
  }

  /// Of projections: from corners near at hand, if there is room for all.
  __device__ void project() {
    constexpr Index kRoom = 1024;
    struct Stage {
      Particle corners[kRoom];
    };
    __shared__ SharedRoom<Stage> room;
    Particle* const staged = room.get().corners;
    Particle* const moving = moving_of(state_);
    const bool are_staged = grip_.corner_count <= kRoom;
    const auto for_each_staged = [&](const auto& visit) {
      for (Index c = static_cast<Index>(threadIdx.x); are_staged && c < grip_.corner_count;
           c += kGripThreads) {
        visit(staged[c], moving + tables_.corners[c].place);
      }
    };
    for_each_staged([](Particle& here, const Particle* there) { here = load_particle(there); });
    __syncthreads();
    if (threadIdx.x < kWarp && are_staged) {
      GripProjection(state_, input_, tables_, StagedCorners(staged)).run();
    } else if (threadIdx.x < kWarp) {
      GripProjection(state_, input_, tables_, CornersInPlace(moving)).run();
    }
    __syncthreads();
    for_each_staged([](const Particle& here, Particle* there) {
      store_particle(there, position_of(here), here.w);
    });
    __syncthreads();
  }

  /// At the end of the substep anchors have slid.
  /// @param scale  1/s^2, force per multiplier
  __device__ void end(float scale) {
    const Vec3<float> sum =
        sum_of_points([&](const GripPointInput& point) { return scale * point.multiplier; });
    const Vec3<float> slid = tables_.pose.in_frame(grip_.slide);
    for_each_point([&](GripPointInput& point) {
      point.force = point.force + scale * point.multiplier;
      point.anchor = point.anchor + slid;
    });
    if (threadIdx.x == 0) {
      grip_.pull = grip_.pull + along_pad(tables_.pose.normal, sum);
      grip_.slid += length_of(grip_.slide);
    }
    __syncthreads();
  }

 private:
  template <class Visit>
  __device__ void for_each_point(const Visit& visit) {
    for (Index i = static_cast<Index>(threadIdx.x); i < grip_.point_count; i += kGripThreads) {
      visit(tables_.points[i]);
    }
  }

  /// In the order of points.
  template <class Of>
  __device__ Vec3<float> sum_of_points(const Of& of) const {
    __shared__ float parts[3][kGripThreads];
    __shared__ float sums[3];
    const auto thread = static_cast<Index>(threadIdx.x);
    float sum = 0;
    for (Index first = 0; first < grip_.point_count; first += kGripThreads) {
      if (first + thread < grip_.point_count) {
        const Vec3<float> own = of(tables_.points[first + thread]);
        parts[0][thread] = own.x;
        parts[1][thread] = own.y;
        parts[2][thread] = own.z;
      }
      __syncthreads();
      for (Index i = 0; thread < 3 && i < kGripThreads && first + i < grip_.point_count; ++i) {
        sum += parts[thread][i];
      }
      __syncthreads();
    }
    if (thread < 3) {
      sums[thread] = sum;
    }
    __syncthreads();
    const Vec3<float> all{sums[0], sums[1], sums[2]};
    __syncthreads();
    return all;
  }

  /// m, along the pad, as if nothing slid.
  [[nodiscard]] __device__ Vec3<float> mean_way() const {
    const Vec3<float> sum = sum_of_points([&](const GripPointInput& point) {
      const Vec3<float> way = way_to_jaws(state_, grip_, point) - grip_.slide;
      return is_finite_way(way) ? way : Vec3<float>{};
    });
    return along_pad(tables_.pose.normal, (1 / tables_.count) * sum);
  }

  [[nodiscard]] __device__ bool moves(Index place) const {
    return load_particle(state_.displacements + place).w > 0 &&
           !is_lost(without_count(load_counted(state_.fixed_points + place)));
  }

  /// By another grip, by an attachment, or by what pushes.
  [[nodiscard]] __device__ bool is_held_elsewhere(const ToolArrays& tools, Index place) const {
    bool is_any = false;
    const HeldInput* const held = table<HeldInput>(input_, input_->held);
    const Index* const order = table<Index>(input_, input_->held_order);
    const GripHold* const holds = table<GripHold>(input_, input_->grip_holds);
    const Index h = find_held(input_, place);
    for (Index i = 0; h != kInvalidIndex && i < held[h].count; ++i) {
      const Index hold = order[held[h].first + i] - input_->attachment_count;
      is_any |= hold < 0 || holds[hold].grip != index_;
    }
    for (Index pusher = 0; pusher < input_->pusher_count; ++pusher) {
      is_any |= touches(tools, pusher, place);
    }
    return is_any || holds_of(tools.surfaces, place).count > 0 ||
           holds_of(tools.touches, place).count > 0;
  }

  const DeviceState& state_;
  StepInput* input_;
  Index index_;
  GripTables tables_;
  GripInput& grip_;
  float reach_;  // m, of the mean way at the limit
};

/// @param slides  whether vertex blocks move: what slid goes on sliding
__global__ void __launch_bounds__(kGripThreads)
    place_grips(DeviceState state, StepInput* input, Index substep, bool slides) {
  wait_for_previous();
  state = of_copy(state);
  input += copy_index();
  for (Index g = 0; g < input->grip_count; ++g) {
    GripPatch patch(state, input, substep, g);
    if (patch.place() && slides) {
      patch.slide();
    }
  }
}

/// After a sweep of vertex blocks.
__global__ void __launch_bounds__(kGripThreads)
    balance_grips(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                  Index substep) {
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  for (Index g = 0; g < input->grip_count; ++g) {
    GripPatch patch(state, input, substep, g);
    patch.slide();
    patch.push(vertices, tools);
    patch.find_multipliers();
  }
}

/// After one of projections.
__global__ void __launch_bounds__(kGripThreads)
    pull_grips(DeviceState state, StepInput* input, Index substep) {
  wait_for_previous();
  state = of_copy(state);
  input += copy_index();
  for (Index g = 0; g < input->grip_count; ++g) {
    GripPatch(state, input, substep, g).project();
  }
}

/// @param tells  whether the host reads what comes of it
__global__ void __launch_bounds__(kGripThreads)
    finish_grips(DeviceState state, ToolArrays tools, StepInput* input, Index substep, bool tells) {
  wait_for_previous();
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  for (Index g = 0; g < input->grip_count; ++g) {
    GripPatch(state, input, substep, g).end(input->force_per_multiplier);
  }
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index g = thread; tells && g < input->grip_count; g += kGripThreads) {
    tools.told_grips[g] = table<GripInput>(input, input->grips)[g];
  }
  for (Index i = thread; tells && i < input->grip_point_count; i += kGripThreads) {
    tools.told_points[i] = table<GripPointInput>(input, input->grip_points)[i];
  }
}

void begin_grips(const DeviceState& state, StepInput* input, Index substep, bool slides,
                 const Launch& how) {
  launch(how, "launching where grips are", 1, kGripThreads, place_grips, state, input, substep,
         slides);
}

void answer_grips(const DeviceState& state, const VertexArrays& vertices, const ToolArrays& tools,
                  StepInput* input, Index substep, const Launch& how) {
  launch(how, "launching the answer of grips", 1, kGripThreads, balance_grips, state, vertices,
         tools, input, substep);
}

void project_grips(const DeviceState& state, StepInput* input, Index substep, const Launch& how) {
  launch(how, "launching the phase of grips", 1, kGripThreads, pull_grips, state, input, substep);
}

void end_grips(const DeviceState& state, const ToolArrays& tools, StepInput* input, Index substep,
               bool tells, const Launch& how) {
  launch(how, "launching the end of grips", 1, kGripThreads, finish_grips, state, tools, input,
         substep, tells);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
