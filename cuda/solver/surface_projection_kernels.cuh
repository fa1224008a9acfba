// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces one after another: see contact_projection.cuh.

#include "cuda/solver/contact_projection.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// A contact while it moves its corners.
struct MovingContact {
  DeviceContact stored;
  Index level;
  Index roots[3];
  /// Of all tools. No pointer to its own, or null: from such a choice ptxas 13.0 makes code that
  /// reads the pointer a cycle too early, see cuda/README.md.
  ToolSpring* springs;
  float stiffness;  ///< kg, see project_contact()
  float gap;        ///< m, when it last looked

  __device__ MovingContact(const SurfaceArrays& surfaces, Index c)
      : stored(surfaces.contacts[c]), level(surfaces.levels[c]), springs(surfaces.springs) {
    for (int k = 0; k < 3; ++k) {
      roots[k] = surfaces.roots[3 * c + (has_corner(k) ? k : 0)];
    }
  }

  /// Once corners are known.
  template <class Corners>
  __device__ void begin(const Corners& corners) {
    const At at(*this, corners);
    float yield = has_spring() ? spring().yield : 0;
    for_each_corner([&](int k) {
      yield += stored.contact.weights[k] * stored.contact.weights[k] * at.corners[k].w;
    });
    stiffness = stiffness_of(yield);
    gap = read(at).gap;
  }

  template <class Corners>
  __device__ void look(const Corners& corners) {
    gap = read(At(*this, corners)).gap;
  }

  // After look():
  [[nodiscard]] __device__ bool acts() const { return pbdsurg::acts(stored.contact, gap); }
  [[nodiscard]] __device__ bool is_left_inside() const {
    return pbdsurg::is_left_inside({gap, {}});
  }

  __device__ void put_back(const SurfaceArrays& surfaces, Index c) const {
    surfaces.contacts[c].contact = stored.contact;
  }

  template <class Corners>
  __device__ void project(const Corners& corners) {
    At at(*this, corners);
    project_contact(
        stored.contact, stored.friction, stiffness, [&] { return read(at); },
        [&](const Vec3<float>& push) { move(at, push); });
    put_back(at, corners);
  }

  /// Out of the plane alone, which it has just looked at.
  template <class Corners>
  __device__ void push_out(const Corners& corners) {
    At at(*this, corners);
    push_contact_out(stored.contact, stiffness, {gap, {}},
                     [&](const Vec3<float>& push) { move(at, push); });
    put_back(at, corners);
  }

 private:
  /// Where the corners are: all are asked for before any is needed.
  struct At {
    Particle corners[3];
    bool have_moved[3] = {};

    template <class Corners>
    __device__ At(const MovingContact& own, const Corners& all) {
#pragma unroll
      for (int k = 0; k < 3; ++k) {  // the first stands for those that there are not
        corners[k] =
            all.load(own.stored.contact.feature.places[own.has_corner(k) ? k : 0], own.roots[k]);
      }
    }
  };

  [[nodiscard]] __device__ bool has_spring() const {
    return stored.spring != kInvalidIndex;
  }
  [[nodiscard]] __device__ ToolSpring& spring() const {
    return springs[stored.spring];
  }
  [[nodiscard]] __device__ bool has_corner(int k) const {
    return stored.contact.feature.places[k] != kInvalidIndex;
  }
  template <class Visit>
  __device__ void for_each_corner(const Visit& visit) const {
#pragma unroll
    for (int k = 0; k < 3; ++k) {
      if (has_corner(k)) {
        visit(k);
      }
    }
  }
  [[nodiscard]] __device__ ContactReading<float> read(const At& at) const {
    Vec3<float> sum;
    for_each_corner(
        [&](int k) { sum = sum + stored.contact.weights[k] * position_of(at.corners[k]); });
    return read_plane(stored.contact, sum - (has_spring() ? spring().shift : Vec3<float>{}));
  }
  __device__ void move(At& at, const Vec3<float>& push) const {
    if (has_spring()) {
      spring().shift = spring().shift - spring().yield * push;
    }
    for_each_corner([&](int k) {
      const Particle& p = at.corners[k];
      const Vec3<float> after = position_of(p) + (stored.contact.weights[k] * p.w) * push;
      if (is_finite_way(after)) {
        at.corners[k] = {after.x, after.y, after.z, p.w};
        at.have_moved[k] = true;
      }
    });
  }
  template <class Corners>
  __device__ void put_back(const At& at, const Corners& corners) const {
#pragma unroll
    for (int k = 0; k < 3; ++k) {
      corners.store_if(at.have_moved[k], stored.contact.feature.places[k], roots[k], at.corners[k]);
    }
  }
};

using OwnSurfaceContacts = OwnContacts<SurfaceArrays, MovingContact>;

/// See settle_surface_contacts().
template <class Crew, class Corners>
__device__ __forceinline__ void settle(Crew& crew, OwnSurfaceContacts& own,
                                       const Corners& corners) {
  bool is_any_inside = true;
  for (int pass = 0; pass < kSettlePasses && is_any_inside; ++pass) {
    is_any_inside = push_out(crew, own, corners);
  }
  own.for_each(corners, [&](MovingContact& contact) {
    contact.look(corners);
    contact.stored.contact.is_left_inside = contact.is_left_inside();
    return true;
  });
}

constexpr int kProjectThreads = 256;

/// Moves corners by their masses: the bits of one contact after another. One block a copy.
/// @tparam kSettles  only those that are inside, without friction
template <bool kSettles>
__global__ void __launch_bounds__(kProjectThreads, 1)
    project_surfaces(DeviceState state, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  go_through_contacts<MovingContact, kProjectThreads, 3>(
      state, surfaces, contact_count(surfaces),
      [&](auto& crew, OwnSurfaceContacts& own, const auto& corners) {
        if constexpr (kSettles) {
          settle(crew, own, corners);
        } else {
          project(crew, own, corners, __ldcg(surfaces.level_counts));
        }
      });
}

void project_surface_contacts(const DeviceState& state, const ToolArrays& tools, bool settles,
                              const Launch& how) {
  launch(how, "launching contacts with surfaces", 1, kProjectThreads,
         settles ? project_surfaces<true> : project_surfaces<false>, state, tools);
}

/// Of BDF2, as ease() for vertices that tools push: by levels. One block a copy.
__global__ void __launch_bounds__(kProjectThreads)
    ease_surfaces(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  for (Index level = 0; level < levels; ++level) {
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kProjectThreads) {
      const DeviceContact& stored = surfaces.contacts[c];
      const SurfaceContact& contact = stored.contact;
      if (surfaces.levels[c] != level || !(contact.multiplier > 0) || contact.is_eased) {
        continue;
      }
      for (int k = 0; k < contact.feature.count(); ++k) {
        const Index place = contact.feature.places[k];
        if (load_particle(state.particles + place).w > 0) {
          ease_vertex(state, place, contact.normal, input->inverse_h);
        }
      }
    }
    __syncthreads();
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
