// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Free pieces that tools' surfaces or other bodies touch and nothing else holds: they move rigidly
/// to where their contacts balance, those that touch each other at once, see touched_pieces.h. One
/// block a copy.

#include <limits>

#include <cub/block/block_scan.cuh>

#include "cuda/solver/coarse_kernels.cuh"
#include "cuda/solver/momentum_kernels.cuh"
#include "cuda/solver/surface_answer_kernels.cuh"
#include "cuda/solver/surface_projection_kernels.cuh"
#include "cuda/solver/touch_kernels.cuh"
#include "lib/solver/methods/group_balance.h"
#include "lib/solver/methods/piece_easing.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr Index kNoPiece = std::numeric_limits<Index>::max();

/// The total of what each thread has, as momentum.h says.
/// @param room  [kMomentumSums]
template <class Sums>
__device__ Sums total(const Sums& own, Sums* room) {
  const auto thread = static_cast<Index>(threadIdx.x);
  __syncthreads();
  room[thread] = own;
  for (Index half = kMomentumSums / 2; half > 0; half /= 2) {
    __syncthreads();
    if (thread < half) {
      room[thread].add(room[thread + half]);
    }
  }
  __syncthreads();
  return room[0];
}

/// Shared memory for sums.
struct SumRoom {
  alignas(16) unsigned char bytes[kMomentumSums * sizeof(MomentumSums)];

  template <class Sums>
  __device__ Sums* of() {
    static_assert(sizeof(Sums) <= sizeof(MomentumSums));
    return reinterpret_cast<Sums*>(bytes);
  }
};

/// Where the weighted corners of a contact are, in what arm_at(place) says of them; of a contact
/// between bodies those of a side.
template <class ArmAt>
__device__ Vec3<double> arm_of_contact(const SurfaceContact& contact, const ArmAt& arm_at) {
  Vec3<double> sum{0, 0, 0};
  for (int k = 0; k < contact.feature.count(); ++k) {
    sum = sum + static_cast<double>(contact.weights[k]) * arm_at(contact.feature.places[k]);
  }
  return sum;
}
template <class ArmAt>
__device__ Vec3<double> arm_of_contact(const TissueTouch& touch, int side, const ArmAt& arm_at) {
  const double sign = side == 0 ? 1 : -1;
  Vec3<double> sum{0, 0, 0};
  for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
    sum = sum + sign * static_cast<double>(touch.weights[k]) * arm_at(touch.places[k]);
  }
  return sum;
}

/// Pieces that contacts touch and nothing else holds, and with which of them each moves.
class TouchedPieces {
 public:
  __device__ TouchedPieces(const DeviceState& state, const FreePieceArrays& pieces,
                           const ToolArrays& tools, StepInput* input)
      : state_(state),
        pieces_(pieces),
        tools_(tools),
        input_(input),
        surface_count_(tools.surfaces.contact_room > 0 ? contact_count(tools.surfaces) : 0),
        touch_count_(tools.touches.contact_room > 0 ? contact_count(tools.touches) : 0) {}

  [[nodiscard]] __device__ Index surface_count() const { return surface_count_; }
  [[nodiscard]] __device__ Index touch_count() const { return touch_count_; }

  /// Lists them, each as a group of its own. All threads of the block call it.
  __device__ void list(SumRoom& room) {
    for (Index i = thread(); i < pieces_.count; i += kMomentumSums) {
      pieces_.touched[i] = kInvalidIndex;
    }
    for (Index piece = next_touched(kInvalidIndex); piece != kNoPiece;
         piece = next_touched(piece)) {
      if (is_held(piece)) {
        continue;
      }
      MomentumSums own;
      for_each_place(pieces_, piece, [&](Index place) {
        const FlownVertex vertex(state_, place);
        if (vertex.counts()) {
          own.add(1 / static_cast<double>(vertex.moved.w), vertex.arm,
                  to_double(position_of(vertex.moved) - vertex.flight));
        }
      });
      const MomentumSums sums = total(own, room.of<MomentumSums>());
      if (sums.mass > 0 && thread() == 0) {
        pieces_.touched[piece] = piece;
        pieces_.sums[piece] = sums;
      }
    }
    __syncthreads();
  }

  /// Makes groups of those that touch each other, in the order of contacts, as large as a group may
  /// be. All threads of the block call it.
  __device__ void join() {
    if (thread() < kWarp) {
      for (Index first = 0; first < touch_count_; first += kWarp) {
        const Index c = first + thread();
        Index ids[2] = {kInvalidIndex, kInvalidIndex};
        for (int side = 0; side < 2 && c < touch_count_; ++side) {
          ids[side] = find(tools_.touches.contacts[c].place_on(side));
        }
        const bool are_two = ids[0] != kInvalidIndex && ids[1] != kInvalidIndex && ids[0] != ids[1];
        for (unsigned left = __ballot_sync(~0U, are_two); left != 0; left &= left - 1) {
          const int from = __ffs(static_cast<int>(left)) - 1;
          join(__shfl_sync(~0U, ids[0], from), __shfl_sync(~0U, ids[1], from));
        }
      }
    }
    __syncthreads();
  }

  /// The one at a place, or kInvalidIndex.
  [[nodiscard]] __device__ Index find(Index place) const {
    const Index piece = piece_at(place);
    return piece == kInvalidIndex || pieces_.touched[piece] == kInvalidIndex ? kInvalidIndex
                                                                             : piece;
  }

  /// The first of its group.
  [[nodiscard]] __device__ Index group_of(Index piece) const { return pieces_.touched[piece]; }

  /// Calls visit(piece) for those that are the first of their group, or for all, ascending. All
  /// threads of the block call it, and may meet in it.
  template <class Visit>
  __device__ void for_each(bool groups, const Visit& visit) const {
    for (Index first = 0; first < pieces_.count; first += kMomentumSums) {
      const Index own = first + thread();
      const Index group = own < pieces_.count ? pieces_.touched[own] : kInvalidIndex;
      const bool is_wanted = group != kInvalidIndex && (!groups || group == own);
      __shared__ bool are_wanted[kMomentumSums];
      __syncthreads();
      are_wanted[thread()] = is_wanted;
      if (__syncthreads_or(is_wanted) == 0) {
        continue;
      }
      for (Index i = 0; i < kMomentumSums; ++i) {
        if (are_wanted[i]) {
          visit(first + i);
        }
      }
    }
  }

  /// Of a contact between bodies, the side that a piece has alone, or -1.
  [[nodiscard]] __device__ int side_of(const TissueTouch& touch, Index piece) const {
    const bool has_first = piece_at(touch.place_on(0)) == piece;
    const bool has_second = piece_at(touch.place_on(1)) == piece;
    return has_first == has_second ? -1 : (has_first ? 0 : 1);
  }

  /// The piece of a contact with a surface.
  [[nodiscard]] __device__ Index piece_of(Index contact) const {
    return piece_at(tools_.surfaces.contacts[contact].contact.feature.places[0]);
  }

 private:
  [[nodiscard]] __device__ static Index thread() { return static_cast<Index>(threadIdx.x); }

  /// The first of the pieces that move with the one at a place.
  [[nodiscard]] __device__ Index piece_at(Index place) const {
    return PBDSURG_KERNELS_NAMESPACE::group_of(pieces_, __ldg(pieces_.piece_of_place + place));
  }

  /// The first piece behind another that contacts touch, or kNoPiece.
  [[nodiscard]] __device__ Index next_touched(Index piece) const {
    __shared__ Index least;
    __syncthreads();
    if (thread() == 0) {
      least = kNoPiece;
    }
    __syncthreads();
    const auto consider = [&](Index own) {
      if (own > piece) {
        atomicMin(&least, own);
      }
    };
    for (Index c = thread(); c < surface_count_; c += kMomentumSums) {
      consider(piece_of(c));
    }
    for (Index c = thread(); c < touch_count_; c += kMomentumSums) {
      consider(piece_at(tools_.touches.contacts[c].place_on(0)));
      consider(piece_at(tools_.touches.contacts[c].place_on(1)));
    }
    __syncthreads();
    return least;
  }

  /// Whether tools hold a piece, or push it with vertices alone.
  [[nodiscard]] __device__ bool is_held(Index piece) const {
    bool is_any = false;
    const HeldInput* const held = table<HeldInput>(input_, input_->held);
    for (Index h = thread(); h < input_->held_count; h += kMomentumSums) {
      is_any |= piece_at(held[h].place) == piece;
    }
    for (Index pusher = 0; pusher < input_->pusher_count; ++pusher) {
      const Index* const places = tools_.contact_places + of_pusher(pusher, tools_.contact_room);
      for (Index i = thread(); i < tools_.contact_counts[pusher]; i += kMomentumSums) {
        is_any |= piece_at(places[i]) == piece;
      }
    }
    return __syncthreads_or(is_any) != 0;
  }

  /// By a warp.
  __device__ void join(Index first, Index second) {
    const Index one = pieces_.touched[first], other = pieces_.touched[second];
    const Index a = one < other ? one : other, b = one < other ? other : one;
    Index size = 0;
    for (Index i = thread(); i < pieces_.count; i += kWarp) {
      size += pieces_.touched[i] == a || pieces_.touched[i] == b ? 1 : 0;
    }
    for (int distance = kWarp / 2; distance > 0; distance /= 2) {
      size += __shfl_xor_sync(~0U, size, distance);
    }
    if (a != b && size <= GroupSpace::kMostPieces) {
      for (Index i = thread(); i < pieces_.count; i += kWarp) {
        if (pieces_.touched[i] == b) {
          pieces_.touched[i] = a;
        }
      }
    }
    __syncwarp();
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  const ToolArrays& tools_;
  StepInput* input_;
  Index surface_count_, touch_count_;
};

/// The pieces of a group as they are balanced.
struct BalancedGroup {
  Index pieces[GroupSpace::kMostPieces];  ///< ascending
  Index count;
  GroupSpace space;
};

/// Lists the contacts of a group, piece by piece: those with bodies, then those with surfaces.
class GroupList {
 public:
  __device__ GroupList(const DeviceState& state, const FreePieceArrays& pieces,
                       const ToolArrays& tools, const TouchedPieces& touched,
                       const BalancedGroup& group, float inverse_dt_squared)
      : state_(state),
        pieces_(pieces),
        tools_(tools),
        touched_(touched),
        group_(group),
        inverse_dt_squared_(inverse_dt_squared) {}

  /// All threads of the block call it.
  /// @return  how many there are
  __device__ Index list() {
    Index listed = 0;
    for (Index rank = 0; rank < group_.count; ++rank) {
      add(touched_.touch_count(), listed,
          [&](Index c, GroupContact& contact) { return make_touch(rank, c, contact); });
      add(touched_.surface_count(), listed,
          [&](Index c, GroupContact& contact) { return make_surface(rank, c, contact); });
    }
    return listed;
  }

 private:
  template <class Make>
  __device__ void add(Index count, Index& listed, const Make& make) const {
    using Scan = cub::BlockScan<Index, kMomentumSums>;
    __shared__ typename Scan::TempStorage storage;
    for (Index first = 0; first < count; first += kMomentumSums) {
      const Index c = first + static_cast<Index>(threadIdx.x);
      GroupContact contact{};
      const bool is_there = c < count && make(c, contact);
      Index rank = 0, sum = 0;
      Scan(storage).ExclusiveSum(is_there ? 1 : 0, rank, sum);
      if (is_there) {
        tools_.group_contacts[listed + rank] = contact;
      }
      listed += sum;
      __syncthreads();
    }
  }

  [[nodiscard]] __device__ auto arms() const {
    return [this](Index place) { return FlownVertex(state_, place).arm; };
  }
  [[nodiscard]] __device__ Vec3<double> centre(Index piece) const {
    return pieces_.sums[piece].centre();
  }

  [[nodiscard]] __device__ bool make_surface(Index rank, Index c, GroupContact& made) const {
    const Index piece = group_.pieces[rank];
    if (touched_.piece_of(c) != piece) {
      return false;
    }
    const DeviceContact& stored = tools_.surfaces.contacts[c];
    const SurfaceContact& contact = stored.contact;
    const ContactReading<float> now = read_contact(state_, tools_.surfaces, stored);
    made.contact = {arm_of_contact(contact, arms()) - centre(piece),
                    to_double(contact.normal),
                    {now.gap, to_double(now.slip)},
                    {contact.multiplier, to_double(contact.friction)},
                    stored.friction,
                    static_cast<double>(contact.stiffness) / inverse_dt_squared_};
    made.first = rank;
    return is_finite(now.gap) && is_finite_way(now.slip);
  }

  /// None that an earlier piece has.
  [[nodiscard]] __device__ bool make_touch(Index rank, Index c, GroupContact& made) const {
    const Index piece = group_.pieces[rank];
    const TissueTouch& touch = tools_.touches.contacts[c];
    const int side = touched_.side_of(touch, piece);
    if (side < 0) {
      return false;
    }
    const Index other = touched_.find(touch.place_on(1 - side));
    const bool is_pair =
        other != kInvalidIndex && touched_.group_of(other) == touched_.group_of(piece);
    if (is_pair && other < piece) {
      return false;
    }
    const ContactReading<float> now =
        read_plane(touch, sum_of_side(state_, touch, 0) + sum_of_side(state_, touch, 1));
    const double sign = side == 0 ? 1 : -1;
    made.contact = {arm_of_contact(touch, side, arms()) - centre(piece),
                    sign * to_double(touch.normal),
                    {now.gap, sign * to_double(now.slip)},
                    {touch.multiplier, sign * to_double(touch.friction)},
                    touch.mu,
                    static_cast<double>(touch.stiffness) / inverse_dt_squared_};
    made.first = rank;
    if (is_pair) {
      for (Index i = 0; i < group_.count; ++i) {
        made.second = group_.pieces[i] == other ? i : made.second;
      }
      made.other_arm = arm_of_contact(touch, 1 - side, arms()) - centre(other);
    }
    return is_finite(now.gap) && is_finite_way(now.slip);
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  const ToolArrays& tools_;
  const TouchedPieces& touched_;
  const BalancedGroup& group_;
  float inverse_dt_squared_;
};

__global__ void __launch_bounds__(kMomentumSums)
    balance_touched(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input) {
  wait_for_previous();
  __shared__ union {
    SumRoom sums;
    BalancedGroup group;
  } room;
  __shared__ SharedRoom<RigidBody> bodies[GroupSpace::kMostPieces];
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  TouchedPieces touched(state, pieces, tools, input);
  touched.list(room.sums);
  touched.join();
  BalancedGroup& group = room.group;
  touched.for_each(true, [&](Index first) {
    __syncthreads();
    if (thread == 0) {
      group.count = 0;
      for (Index piece = first; piece < pieces.count; ++piece) {
        if (pieces.touched[piece] == first) {
          bodies[group.count].get() = RigidBody(pieces.sums[piece]);
          group.pieces[group.count++] = piece;
        }
      }
    }
    __syncthreads();
    const Index listed =
        GroupList(state, pieces, tools, touched, group, input->substep.inverse_dt_squared).list();
    GroupBalance(BlockOfWorkers{thread, kMomentumSums}, &bodies[0].get(), group.count,
                 tools.group_contacts, listed, tools.group_answers, group.space)
        .run();
    for (Index rank = 0; rank < group.count; ++rank) {
      const Index piece = group.pieces[rank];
      const Screw twist = group.space.twist_of(rank);
      const RigidMove move{twist.linear, twist.angular, pieces.sums[piece].centre()};
      for_each_place(pieces, piece, [&](Index place) {
        const FlownVertex vertex(state, place);
        const Vec3<float> way = part_of(move, vertex.arm);
        if (vertex.counts() && is_finite_way(position_of(vertex.moved) + way)) {
          displace(state, place, way);
        }
      });
    }
    __syncthreads();
  });
}

void balance_pieces(const DeviceState& state, const FreePieceArrays& pieces,
                    const ToolArrays& tools, StepInput* input, const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the balance of pieces", 1, kMomentumSums, balance_touched, state, pieces,
           tools, input);
  }
}

void answer_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                             Index substep, const Launch& how) {
  if (tools.surfaces.has_springs) {
    launch(how, "launching springs of tools", 1, kSpringThreads, balance_springs, state, tools,
           input);
  }
  launch(how, "launching the answer of surfaces", share_blocks(kAnswerBlocks, 1, how), kToolThreads,
         answer_surfaces, state, tools, input, substep);
}

/// A piece as it is eased.
class EasedPiece {
 public:
  __device__ EasedPiece(const DeviceState& state, const FreePieceArrays& pieces, Index piece,
                        SumRoom& room)
      : state_(state), pieces_(pieces), piece_(piece), room_(room) {
    MomentumSums own;
    for_each_counted([&](Index place, const FlownVertex& vertex) {
      own.add(1 / static_cast<double>(vertex.moved.w), position(place), {0, 0, 0});
    });
    pushes_.sums = total(own, room_.of<MomentumSums>());
  }

  [[nodiscard]] __device__ Index piece() const { return piece_; }
  [[nodiscard]] __device__ const Pushes& pushes() const { return pushes_; }

  /// Contacts in their order; each thread adds up all.
  __device__ void add(const SurfaceContact& contact) {
    pushes_.add(contact.multiplier, contact.normal,
                arm_of_contact(contact, [&](Index place) { return position(place); }));
  }
  __device__ void add(const TissueTouch& touch, int side) {
    pushes_.add(touch.multiplier, side == 0 ? touch.normal : -1.0F * touch.normal,
                arm_of_contact(touch, 1, [&](Index place) { return position(place); }));
  }

  /// Once all pushes are added.
  [[nodiscard]] __device__ EasingSums sums(float h) {
    motion_ = pushes_.sums.rigid_move();
    EasingSums along;
    for_each_counted([&](Index place, const FlownVertex& vertex) {
      along.add(1 / static_cast<double>(vertex.moved.w),
                to_double(part_of(motion_, position(place))),
                load_velocity(state_.velocities + place), load_way(state_.ways + place),
                load_velocity(state_.velocities_before + place), h);
    });
    return total(along, room_.of<EasingSums>());
  }

  __device__ void ease(const Easing& easing) const {
    for_each_counted([&](Index place, const FlownVertex&) {
      const Vec3<float> way = part_of(motion_, position(place));
      Velocity* const now = state_.velocities + place;
      Velocity* const before = state_.velocities_before + place;
      store_velocity(now, load_velocity(now) + static_cast<float>(easing.now) * way);
      store_velocity(before, load_velocity(before) + static_cast<float>(easing.before) * way);
    });
    __syncthreads();
  }

 private:
  [[nodiscard]] __device__ Vec3<double> position(Index place) const {
    return to_double(position_of(load_particle(state_.particles + place)));
  }
  template <class Visit>
  __device__ void for_each_counted(const Visit& visit) const {
    for_each_place(pieces_, piece_, [&](Index place) {
      const FlownVertex vertex(state_, place);
      if (vertex.counts()) {
        visit(place, vertex);
      }
    });
  }

  const DeviceState& state_;
  const FreePieceArrays& pieces_;
  Index piece_;
  SumRoom& room_;
  Pushes pushes_{};
  RigidMove motion_{};
};

/// Off tools and what has no such motion.
__device__ inline void ease_alone(const ToolArrays& tools, const TouchedPieces& touched,
                                  const StepInput* input, EasedPiece& eased) {
  const auto for_each = [&](Index from, Index stride, const auto& visit_touch,
                            const auto& visit_surface) {
    for (Index c = from; c < touched.touch_count(); c += stride) {
      TissueTouch& touch = tools.touches.contacts[c];
      const int side = touched.side_of(touch, eased.piece());
      if (side >= 0 && touched.find(touch.place_on(1 - side)) == kInvalidIndex) {
        visit_touch(touch, side);
      }
    }
    for (Index c = from; c < touched.surface_count(); c += stride) {
      if (touched.piece_of(c) == eased.piece()) {
        visit_surface(tools.surfaces.contacts[c].contact);
      }
    }
  };
  for_each(
      0, 1, [&](const TissueTouch& touch, int side) { eased.add(touch, side); },
      [&](const SurfaceContact& contact) { eased.add(contact); });
  const Easing easing = eased.sums(input->h).easing(eased.pushes());
  eased.ease(easing);
  const float relief = relief_of(easing, input->h, input->per_step, input->density);
  for_each(
      static_cast<Index>(threadIdx.x), kMomentumSums,
      [](TissueTouch& touch, int) { touch.is_eased = true; },
      [&](SurfaceContact& contact) {
        contact.is_eased = true;
        contact.relief = relief;
      });
  __syncthreads();
}

/// Off each other. What both have in common of mass stands for that of one.
__device__ inline void ease_pair(const DeviceState& state, const FreePieceArrays& pieces,
                                 const ToolArrays& tools, const TouchedPieces& touched,
                                 const StepInput* input, Index first, Index second, SumRoom& room) {
  EasedPiece one(state, pieces, first, room);
  EasedPiece other(state, pieces, second, room);
  for (Index c = 0; c < touched.touch_count(); ++c) {
    const TissueTouch& touch = tools.touches.contacts[c];
    const int side = touched.side_of(touch, first);
    if (side >= 0 && touched.find(touch.place_on(1 - side)) == second) {
      one.add(touch, side);
      other.add(touch, 1 - side);
    }
  }
  __syncthreads();
  for (Index c = static_cast<Index>(threadIdx.x); c < touched.touch_count(); c += kMomentumSums) {
    TissueTouch& touch = tools.touches.contacts[c];
    const int side = touched.side_of(touch, first);
    if (side >= 0 && touched.find(touch.place_on(1 - side)) == second) {
      touch.is_eased = true;
    }
  }
  EasingSums sums = one.sums(input->h);
  sums.add(other.sums(input->h));
  Pushes pushes;
  pushes.total = one.pushes().total;
  pushes.sums.mass = 1 / (1 / one.pushes().sums.mass + 1 / other.pushes().sums.mass);
  const Easing easing = sums.easing(pushes);
  one.ease(easing);
  other.ease(easing);
}

/// The pair of pieces behind another that push each other, or kNoPair.
constexpr unsigned long long kNoPair = ~0ULL;
__device__ inline unsigned long long next_pair(const ToolArrays& tools,
                                               const TouchedPieces& touched,
                                               unsigned long long behind, bool is_first) {
  __shared__ unsigned long long least;
  __syncthreads();
  if (threadIdx.x == 0) {
    least = kNoPair;
  }
  __syncthreads();
  for (Index c = static_cast<Index>(threadIdx.x); c < touched.touch_count(); c += kMomentumSums) {
    const TissueTouch& touch = tools.touches.contacts[c];
    const Index a = touched.find(touch.place_on(0)), b = touched.find(touch.place_on(1));
    if (touch.multiplier > 0 && a != kInvalidIndex && b != kInvalidIndex && a != b) {
      const auto low = static_cast<unsigned>(a < b ? a : b);
      const auto high = static_cast<unsigned>(a < b ? b : a);
      const unsigned long long own = static_cast<unsigned long long>(low) << 32 | high;
      if (is_first || own > behind) {
        atomicMin(&least, own);
      }
    }
  }
  __syncthreads();
  return least;
}

__global__ void __launch_bounds__(kMomentumSums)
    ease_touched(DeviceState state, FreePieceArrays pieces, ToolArrays tools, StepInput* input,
                 Index substep) {
  wait_for_previous();
  __shared__ SumRoom room;
  state = of_copy(state);
  pieces = of_copy(pieces);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  TouchedPieces touched(state, pieces, tools, input);
  touched.list(room);
  touched.for_each(false, [&](Index piece) {
    EasedPiece eased(state, pieces, piece, room);
    ease_alone(tools, touched, input, eased);
  });
  for (unsigned long long pair = next_pair(tools, touched, 0, true); pair != kNoPair;
       pair = next_pair(tools, touched, pair, false)) {
    ease_pair(state, pieces, tools, touched, input, static_cast<Index>(pair >> 32),
              static_cast<Index>(pair & ~0U), room);
  }
  const SurfaceArrays& surfaces = tools.surfaces;
  for (Index t = 0; t < input->tool_count; ++t) {
    const Index meeter = table<ToolInput>(input, input->tools)[t].meeter;
    if (meeter == kInvalidIndex) {
      continue;
    }
    const Index first = surfaces.ends[meeter];
    const auto at = [&](Index i, Vec3<float>& force, Vec3<float>& point) {
      const SurfaceContact& contact = surfaces.contacts[first + i].contact;
      const float scale = contact.is_eased ? contact.relief : 0.0F;
      force = scale * (contact.multiplier * contact.normal);
      point = contact.point;
    };
    feel<kMomentumSums>(table<Wrench>(input, input->wrenches)[t],
                        origin_of(input, substep, t, surfaces, meeter),
                        surfaces.ends[meeter + 1] - first, at);
    __syncthreads();
  }
}

void ease_pieces(const DeviceState& state, const FreePieceArrays& pieces, const ToolArrays& tools,
                 StepInput* input, Index substep, const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching the easing of pieces", 1, kMomentumSums, ease_touched, state, pieces,
           tools, input, substep);
  }
}

void ease_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                           const Launch& how) {
  launch(how, "launching the easing of surfaces", 1, kProjectThreads, ease_surfaces, state, tools,
         input);
}

/// After all sweeps: which pieces keep their momentum together, as contacts push them. One block a
/// copy.
__global__ void __launch_bounds__(kMomentumSums)
    join_meeting(DeviceState state, FreePieceArrays pieces, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  pieces = of_copy(pieces);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index i = thread; i < pieces.count; i += kMomentumSums) {
    pieces.meeting[i] = group_of(pieces, i);
  }
  __syncthreads();
  if (thread >= kWarp) {
    return;
  }
  const Index count = contact_count(touches);
  for (Index first = 0; first < count; first += kWarp) {
    const Index c = first + thread;
    Index ids[2] = {kInvalidIndex, kInvalidIndex};  // pieces
    for (int side = 0; side < 2 && c < count; ++side) {
      if (touches.contacts[c].multiplier > 0) {
        ids[side] = __ldg(pieces.piece_of_place + touches.contacts[c].place_on(side));
      }
    }
    const bool is_any = ids[0] != kInvalidIndex || ids[1] != kInvalidIndex;
    for (unsigned left = __ballot_sync(~0U, is_any); left != 0; left &= left - 1) {
      const int from = __ffs(static_cast<int>(left)) - 1;
      const Index one = __shfl_sync(~0U, ids[0], from), other = __shfl_sync(~0U, ids[1], from);
      const Index a = one == kInvalidIndex ? one : pieces.meeting[one];
      const Index b = other == kInvalidIndex ? other : pieces.meeting[other];
      const Index low = a < b ? a : b, high = a < b ? b : a;  // kInvalidIndex is the least
      __syncwarp();
      for (Index i = thread; i < pieces.count && low != high; i += kWarp) {
        if (pieces.meeting[i] == high) {
          pieces.meeting[i] = low;
        }
      }
      __syncwarp();
    }
  }
}

void join_pieces(const DeviceState& state, const FreePieceArrays& pieces, const ToolArrays& tools,
                 const Launch& how) {
  if (pieces.count > 0) {
    launch(how, "launching what joins pieces", 1, kMomentumSums, join_meeting, state, pieces,
           tools);
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
