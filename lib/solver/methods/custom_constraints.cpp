// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/custom_constraints.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <exception>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/describe.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/loose_end.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Neighbouring vertices give way together: see kShareInTissue of sets/stiff_links.cpp.
constexpr float kShareOfBlocks = 0.7F;

constexpr int kForecast = -1;

float* floats_of(Particle* particles) noexcept {
  return &particles->x;
}

// How pushes move vertices: here, where calls of one corner cost no call of a library.
struct Pusher {
  StepScratch& scratch;
  float* moving;  // [place][4]
  bool has_blocks, is_forecast;
  float square_of_dt, inverse_dt_squared;
  bool leaves_out = true;  // of the coarse correction, what it pushes

  [[nodiscard]] Vec3<float> yield(Index place, const Vec3<float>& force) const {
    return has_blocks ? load_end(scratch.link_ends(), offset_of(place)).give * force
                      : (square_of_dt * moving[4 * static_cast<std::size_t>(place) + 3]) * force;
  }

  // @param way  yield() of the force
  // @return     whether that leads somewhere
  [[nodiscard]] bool move(Index place, const Vec3<float>& force, const Vec3<float>& way) const {
    float* const own = is_forecast ? floats_of(&scratch.end_ways[place])
                                   : moving + 4 * static_cast<std::size_t>(place);
    const Vec3<float> before{own[0], own[1], own[2]};
    const Vec3<float> after = before + way;
    if (!(dot(after, after) < kInfinity) || !(dot(force, force) < kInfinity)) {
      return false;
    }
    own[0] = after.x;
    own[1] = after.y;
    own[2] = after.z;
    if (has_blocks) {
      make_load(place, force, before, after);
    }
    return true;
  }

  void make_load(Index place, const Vec3<float>& force, const Vec3<float>& before,
                 const Vec3<float>& after) const {
    push_flight(scratch.flights[place], force, moving[4 * static_cast<std::size_t>(place) + 3],
                inverse_dt_squared);
    if (leaves_out && dot(force, force) > 0) {
      scratch.end_gives[place].w = 1;
    }
    if (!is_forecast) {
      FixedPoint& point = scratch.fixed_points[place];
      point = moved_point(point, before, after);
    }
  }
};

const Particle* starts_of(const StepContext& step) noexcept {
  return has_displacements(step.data.options) ? step.copy.particles.data()
                                              : step.scratch.previous.data();
}

Pusher pusher_of(const StepContext& step, const Substep<float>& lengths, int index) noexcept {
  return {step.scratch,
          floats_of(moving_vertices(step).moving),
          moves_vertices(step.data.options),
          index == kForecast,
          1 / lengths.inverse_dt_squared,
          lengths.inverse_dt_squared};
}

}  // namespace

ConstraintSweep::ConstraintSweep(const StepContext& step, const CustomConstraints& set,
                                 const Substep<float>& lengths, int index)
    : step_(step),
      set_(set),
      lengths_(lengths),
      index_(index),
      has_blocks_(moves_vertices(step.data.options)),
      vertex_count_(step.data.place_of_vertex.size()),
      places_(step.data.place_of_vertex.data()),
      moving_(floats_of(moving_vertices(step).moving)),
      bases_(has_displacements(step.data.options) ? floats_of(step.copy.particles.data())
                                                  : nullptr),
      ahead_(has_blocks_ ? floats_of(step.scratch.end_ways.data()) : nullptr) {}

Index ConstraintSweep::copy() const noexcept {
  return step_.index;
}
float ConstraintSweep::dt() const noexcept {
  return step_.data.part.h;
}
bool ConstraintSweep::is_probe() const noexcept {
  return step_.is_probe;
}
const Tissue& ConstraintSweep::tissue() const noexcept {
  return *step_.data.tissue;
}

Eigen::Vector3f ConstraintSweep::position(Index vertex) const {
  const std::size_t v = quad(vertex);
  return base(v) + moved(v);
}

Eigen::Vector3f ConstraintSweep::start(Index vertex) const {
  return vector_of(load(starts_of(step_)[quad(vertex) / 4]));
}

bool ConstraintSweep::has_tissue(Index vertex) const {
  return inverse_mass(vertex) > 0 || tissue().has_tissue(vertex);
}

Eigen::Vector3f ConstraintSweep::yield(Index vertex, const Eigen::Vector3f& force) const {
  return vector_of(pusher_of(step_, lengths_, index_).yield(named_place(vertex), load(force)));
}

Index ConstraintSweep::named_place(Index vertex) const {
  const auto place = static_cast<Index>(quad(vertex) / 4);
  if (!step_.data.custom.is_named(place)) {
    refuse(vertex, "is not among its vertices()");
  }
  return place;
}

bool ConstraintSweep::is_lost(std::size_t quad) const noexcept {
  const auto place = static_cast<Index>(quad / 4);
  const bool is_known = !has_blocks_ || (step_.scratch.end_ways[place].w > 0 &&
                                         !pbdsurg::is_lost(step_.scratch.fixed_points[place]));
  return !is_known || !vector(moving_, quad).allFinite();
}

void ConstraintSweep::push(Index vertex, const Eigen::Vector3f& force) {
  move(vertex, force);
  if (has_blocks_) {
    step_.scratch.pushed.anchor(places_[vertex]);
  }
}

void ConstraintSweep::move(Index vertex, const Eigen::Vector3f& force) {
  const Eigen::Vector3f way = yield(vertex, force);
  const std::size_t v = quad(vertex);
  const auto place = static_cast<Index>(v / 4);
  if (!pusher_of(step_, lengths_, index_).move(place, load(force), load(way)) && !is_lost(v)) {
    refuse(vertex, "would go nowhere under a force of " + describe(force.cast<double>()) + " N");
  }
}

float ConstraintSweep::satisfy(std::span<const Corner> corners, float value, float compliance,
                               float multiplier, Range range) {
  const float share = has_blocks_ && index_ != kForecast ? kShareOfBlocks : 1.0F;
  const Answer answer = solve(corners, value, compliance, multiplier, range, share);
  return change(corners, answer, multiplier, true);
}

float ConstraintSweep::satisfy_together(std::span<const Corner> corners, float value,
                                        float compliance, float multiplier, Range range) {
  const Answer answer = solve(corners, value, compliance, multiplier, range, 1);
  const bool is_before_correction = has_blocks_ && index_ == 0;
  WideConstraints& wide = step_.scratch.coarse.wide;
  const bool has_room = !is_before_correction || wide.begin(compliance);
  for (const Corner& corner : corners) {
    const Index place = places_[corner.vertex];
    if (!has_room) {
      step_.scratch.end_gives[place].w = 1;  // left out
    } else if (is_before_correction) {
      wide.add(place, load(corner.gradient));
    }
  }
  return change(corners, answer, multiplier, false);
}

// What a constraint's multiplier is to become; the give is zero where that stays.
ConstraintSweep::Answer ConstraintSweep::solve(std::span<const Corner> corners, float value,
                                               float compliance, float multiplier, Range range,
                                               float share) const {
  if (corners.empty()) {
    return {multiplier, 0};
  }
  const Pusher pusher = pusher_of(step_, lengths_, index_);
  float give = compliance;
  for (const Corner& corner : corners) {
    const Vec3<float> gradient = load(corner.gradient);
    give += dot(gradient, pusher.yield(named_place(corner.vertex), gradient));
  }
  const float wanted = multiplier - share * (value + compliance * multiplier) / give;
  if (!(compliance >= 0) || !std::isfinite(wanted)) {
    if (compliance >= 0 && !(give > 0) && std::isfinite(value)) {
      return {multiplier, 0};  // nothing yields
    }
    for (const Corner& corner : corners) {
      if (is_lost(quad(corner.vertex))) {
        return {multiplier, 0};
      }
    }
    refuse(corners.front().vertex, "has a constraint of value " + describe(value) +
                                       ", compliance " + describe(compliance) + ", multiplier " +
                                       describe(multiplier) + " and yield " + describe(give) +
                                       "; all must be finite, and the compliance not negative");
  }
  return {std::min(std::max(wanted, range.least), range.most), give};
}

float ConstraintSweep::change(std::span<const Corner> corners, const Answer& answer,
                              float multiplier, bool leaves_out) {
  const float change = answer.multiplier - multiplier;
  if (!(answer.give > 0)) {
    return multiplier;
  }
  if (has_blocks_ && answer.multiplier != 0) {
    for (const Corner& corner : corners) {
      const Vec3<float> gradient = load(corner.gradient);
      guard(places_[corner.vertex], dot(gradient, gradient) / answer.give);
    }
  }
  if (change == 0) {
    return answer.multiplier;
  }
  Pusher pusher = pusher_of(step_, lengths_, index_);
  pusher.leaves_out = leaves_out;
  for (const Corner& corner : corners) {
    const Index place = places_[corner.vertex];
    const Vec3<float> force = change * load(corner.gradient);
    if (!pusher.move(place, force, pusher.yield(place, force))) {
      move(corner.vertex, change * corner.gradient);  // which says why not
    }
  }
  if (has_blocks_) {
    PushedPieces& pushed = step_.scratch.pushed;
    if (corners.size() == 1) {
      pushed.anchor(places_[corners.front().vertex]);
    }
    for (const Corner& corner : corners.subspan(1)) {
      pushed.join(places_[corners.front().vertex], places_[corner.vertex]);
    }
  }
  return answer.multiplier;
}

void ConstraintSweep::guard(Index place, float stiffness) {
  const VertexBlocks& blocks = step_.data.vertex_blocks;
  const Index block = blocks.place_of(place).block;
  if (block == kInvalidIndex) {
    return;
  }
  constexpr LaneBits kAll = (LaneBits{1} << kBlockLanes) - 1;
  for (LaneBits lanes = blocks.lanes_of(place) & kAll; lanes != 0; lanes &= lanes - 1) {
    step_.scratch.guards[block].stiffness[std::countr_zero(lanes)] += stiffness;
  }
}

void ConstraintSweep::refuse(Index vertex) const {
  throw InvalidArgument("constraint set '" + set_.name() + "': there is no vertex " +
                        std::to_string(vertex) + "; ids must be in [0, " +
                        std::to_string(vertex_count_) + ")");
}

void ConstraintSweep::refuse(Index vertex, const std::string& why) const {
  throw InvalidArgument("constraint set '" + set_.name() + "': vertex " + std::to_string(vertex) +
                        " " + why);
}

bool has_custom(const StepContext& step) noexcept {
  return !step.data.custom.empty();
}

bool is_pushed(const StepContext& step, Index place) noexcept {
  return step.scratch.end_gives[place].w > 0;
}

void begin_custom(const StepContext& step, const Substep<float>& lengths) {
  for (const Index place : step.data.custom.places()) {
    step.scratch.flights[place].w = kToLeastEnergy;
  }
  if (has_custom(step)) {
    step.scratch.pushed.begin();
    step.scratch.coarse.wide.clear();
  }
  for (Index set = 0; set < step.data.custom.count(); ++set) {
    project_custom(step, set, lengths, kForecast);
  }
}

void project_custom(const StepContext& step, Index set_index, const Substep<float>& lengths,
                    int sweep) {
  CustomSets& sets = step.data.custom;
  if (sets.has_failed(step.index)) {
    return;
  }
  CustomConstraints& set = sets.set(set_index);
  if (set_index == 0 && moves_vertices(step.data.options)) {
    std::ranges::fill(step.scratch.guards, GuardBlock{});
  }
  const int first = moves_vertices(step.data.options) ? kForecast : 0;
  try {
    ConstraintSweep view(step, set, lengths, sweep);
    if (sweep == first) {
      set.begin_substep(view);
    }
    set.project(view);
  } catch (...) {
    sets.fail(step.index, std::current_exception());
  }
}

}  // namespace pbdsurg
