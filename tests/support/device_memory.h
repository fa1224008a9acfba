// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a device holds of a solver, in the memory of the host: constraints and state.

#include <cstddef>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg::testing {

/// A device's copy of one type's constraints: its own records, and ids in the order of groups.
template <class Constraint>
class DeviceRecords {
 public:
  using Slots = ConstraintSlots<Constraint>;

  DeviceRecords() = default;
  DeviceRecords(const Slots& slots, std::size_t id_count)
      : records_(id_count),
        groups_(static_cast<std::size_t>(slots.group_count())),
        group_of_(id_count, kInvalidIndex) {
    for (Index group = 0; group < slots.group_count(); ++group) {
      for (const Index id : slots.ids(group)) {
        records_[id] = slots.record(id);
        groups_[group].push_back(id);
        group_of_[id] = group;
      }
    }
  }

  void set_serial(Index group) { serial_.insert(group); }

  void take_over(const Slots& slots, Index id) {
    if (group_of_[id] != kInvalidIndex) {
      std::erase(groups_[group_of_[id]], id);
      touched_.insert(group_of_[id]);
    }
    group_of_[id] = slots.group_of(id);
    if (group_of_[id] != kInvalidIndex) {
      records_[id] = slots.record(id);
      groups_[group_of_[id]].push_back(id);
      touched_.insert(group_of_[id]);
    }
  }

  /// Of what was taken over: makes slots with the order of the host's where it matters.
  void refresh(const Slots& slots, Slots& own) {
    if (touched_.empty()) {
      return;
    }
    for (const Index group : touched_) {
      if (serial_.contains(group)) {
        const auto ids = slots.ids(group);
        groups_[group].assign(ids.begin(), ids.end());
      }
    }
    touched_.clear();
    own = make_slots();
  }

  // Slots take constraints in an order of their own when they are made, and as they come later.
  [[nodiscard]] Slots make_slots() const {
    const auto spare = static_cast<Index>(groups_.size());
    std::vector<Index> start(records_.size(), kInvalidIndex);
    for (std::size_t id = 0; id < records_.size(); ++id) {
      start[id] = group_of_[id] == kInvalidIndex ? kInvalidIndex : spare;
    }
    Slots slots(records_, start, spare + 1);
    for (std::size_t group = 0; group < groups_.size(); ++group) {
      for (const Index id : groups_[group]) {
        slots.move(id, static_cast<Index>(group));
      }
    }
    return slots;
  }

 private:
  std::vector<ConstraintRecord<Constraint>> records_;  // [id]
  std::vector<std::vector<Index>> groups_;
  std::vector<Index> group_of_;  // [id]
  std::set<Index> serial_, touched_;
};

/// State of all copies as a device holds it: [copy][capacity].
class DeviceState {
 public:
  DeviceState() = default;
  DeviceState(Index copy_count, std::size_t capacity, bool has_carries, bool has_past)
      : capacity_(capacity),
        has_carries_(has_carries),
        has_past_(has_past),
        particles_(copy_count * capacity, {kNan, kNan, kNan, kNan}),
        velocities_(copy_count * capacity, {kNan, kNan, kNan, kNan}),
        carries_(copy_count * capacity, {kNan, kNan, kNan, kNan}),
        ways_(copy_count * capacity, {kNan, kNan, kNan, kNan}),
        velocities_before_(copy_count * capacity, {kNan, kNan, kNan, kNan}) {}

  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }

  /// The first places of a copy, from another state or into one.
  void take(Index copy, const CopyState& from, std::size_t count) {
    for (std::size_t place = 0; place < count; ++place) {
      take_place(copy, from, static_cast<Index>(place));
    }
  }
  void take_place(Index copy, const CopyState& from, Index place) {
    particles_[at(copy, place)] = from.particles[place];
    velocities_[at(copy, place)] = from.velocities[place];
    carries_[at(copy, place)] = has_carries_ ? from.carries[place] : Carry{};
    ways_[at(copy, place)] = has_past_ ? from.ways[place] : Way{};
    velocities_before_[at(copy, place)] = has_past_ ? from.velocities_before[place] : Velocity{};
  }
  void give(Index copy, CopyState& to, std::size_t count) const {
    to.particles.resize(count);
    to.velocities.resize(count);
    to.carries.resize(has_carries_ ? count : 0);
    to.ways.resize(has_past_ ? count : 0);
    to.velocities_before.resize(has_past_ ? count : 0);
    for (Index place = 0; place < static_cast<Index>(count); ++place) {
      to.particles[place].w = particles_[at(copy, place)].w;
      to.set_motion(place, motion(copy, place));
    }
  }

  void set_inverse_mass(Index copy, Index place, float w) {
    particles_[at(copy, place)].w = w;
    if (w == 0) {
      velocities_[at(copy, place)] = {};
    }
  }

  [[nodiscard]] VertexMotion motion(Index copy, Index place) const {
    const Particle& p = particles_[at(copy, place)];
    return {p.x,
            p.y,
            p.z,
            velocities_[at(copy, place)],
            carries_[at(copy, place)],
            ways_[at(copy, place)],
            velocities_before_[at(copy, place)]};
  }

 private:
  static constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

  [[nodiscard]] std::size_t at(Index copy, Index place) const {
    if (place < 0 || static_cast<std::size_t>(place) >= capacity_) {
      throw Error("there is no room for place " + std::to_string(place));
    }
    return static_cast<std::size_t>(copy) * capacity_ + static_cast<std::size_t>(place);
  }

  std::size_t capacity_ = 0;
  bool has_carries_ = false;
  bool has_past_ = false;
  std::vector<Particle> particles_;
  std::vector<Velocity> velocities_;
  std::vector<Carry> carries_;
  std::vector<Way> ways_;
  std::vector<Velocity> velocities_before_;
};

}  // namespace pbdsurg::testing
