// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which constraint has which record, and which records are free.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_plan.h"

#include "lib/device/stages.h"

namespace pbdsurg::cuda {

/// What ids count: tetrahedra have volumes, in joint records or others, Neo-Hookean constraints, or
/// are only watched.
enum class Holder : std::uint8_t {
  distance,
  volume,
  neo_hookean,
  fibre,
  membrane,
  strain_limit,
  bending,
  stiff_link,
  tube
};
inline constexpr int kHolderCount = 9;

/// Of constraints of a kind.
[[nodiscard]] constexpr Holder holder_of(PhaseKind kind) noexcept {
  switch (kind) {
    case PhaseKind::distance:
      return Holder::distance;
    case PhaseKind::neo_hookean:
      return Holder::neo_hookean;
    case PhaseKind::fibre:
      return Holder::fibre;
    case PhaseKind::membrane:
      return Holder::membrane;
    case PhaseKind::strain_limit:
      return Holder::strain_limit;
    case PhaseKind::bending:
      return Holder::bending;
    case PhaseKind::stiff_link:
      return Holder::stiff_link;
    case PhaseKind::volume:
    case PhaseKind::joint:
    case PhaseKind::vertex:
    case PhaseKind::attachment:
    case PhaseKind::grip:
    case PhaseKind::contact:
    case PhaseKind::body_contact:
    case PhaseKind::custom:
      break;  // the last six have no records
  }
  return Holder::volume;
}

/// The array of the records that stages of a kind project.
[[nodiscard]] constexpr DeviceArray array_of(PhaseKind kind) noexcept {
  switch (kind) {
    case PhaseKind::distance:
      return DeviceArray::distances;
    case PhaseKind::neo_hookean:
      return DeviceArray::neo_hookeans;
    case PhaseKind::fibre:
      return DeviceArray::fibres;
    case PhaseKind::membrane:
      return DeviceArray::membranes;
    case PhaseKind::strain_limit:
      return DeviceArray::strain_limits;
    case PhaseKind::bending:
      return DeviceArray::bendings;
    case PhaseKind::stiff_link:
      return DeviceArray::stiff_links;
    case PhaseKind::joint:
      return DeviceArray::joints;
    case PhaseKind::volume:
    case PhaseKind::vertex:
    case PhaseKind::attachment:
    case PhaseKind::grip:
    case PhaseKind::contact:
    case PhaseKind::body_contact:
    case PhaseKind::custom:
      break;  // the last six have no records
  }
  return DeviceArray::volumes;
}

// In place of a pool:
inline constexpr Index kNoPool = kInvalidIndex;  ///< nowhere to go: no stage takes it
inline constexpr Index kSerialPool = -2;         ///< a serial stage, whose order nobody follows
inline constexpr Index kRemoved = -3;            ///< nothing now, but it may come back
inline constexpr Index kGone = -4;               ///< never comes back, or others project it

/// A pool has the records of a parallel stage, those in use and those that are free. A constraint
/// that is removed keeps its record, which does nothing; one that is gone, or that moves to another
/// pool, leaves it to others.
class RecordTable {
 public:
  struct Record {
    DeviceArray array;
    Index index;
  };

  /// @return  the new pool
  Index add_pool(DeviceArray array);

  // While stages are made, record by record of an array.
  void add(Index pool, Holder holder, Index id, Index record);
  void add_serial(Holder holder, Index id);
  void add_free(Index pool, Index first, Index count);

  /// Records of the pool that are free.
  [[nodiscard]] Index free_count(Index pool) const {
    return static_cast<Index>(pools_[pool].free.size());
  }

  // While edits are followed: all that change leave before any of them joins, so that none misses
  // a record that another leaves.

  /// Takes a constraint out of its pool unless it stays or was removed.
  /// @param wanted  a pool, or what stands for one
  /// @return        false if the stages must be made anew: it was or is to be in a serial one, or
  ///                there is none for it
  [[nodiscard]] bool leave(Holder holder, Index id, Index wanted);

  /// Gives a constraint a record, if it is to have one and has none.
  /// @return  false if the pool has none left
  [[nodiscard]] bool join(Holder holder, Index id, Index wanted);

  /// Records of what left, joined or stayed, some more than once; empties the list.
  [[nodiscard]] std::span<const Record> touched() const noexcept { return touched_; }
  void forget_touched() noexcept { touched_.clear(); }

  /// Whose record it is, alive or removed; kInvalidIndex if it is free.
  [[nodiscard]] Index holder_of(Record record) const {
    return holders_[static_cast<std::size_t>(record.array)][record.index];
  }

  /// kInvalidIndex if it has none in a parallel stage.
  [[nodiscard]] Index record_of(Holder holder, Index id) const {
    const auto& all = locations_[static_cast<std::size_t>(holder)];
    return id < static_cast<Index>(all.size()) ? all[id].record : kInvalidIndex;
  }

 private:
  struct Location {
    Index pool = kNoPool;
    Index record = kInvalidIndex;
  };
  struct Pool {
    DeviceArray array;
    std::vector<Index> free;  // the next to be taken last
  };

  Location& location(Holder holder, Index id);
  void hold(Index pool, Holder holder, Index id, Index record);

  std::vector<Pool> pools_;
  std::array<std::vector<Location>, kHolderCount> locations_;  // [holder][id]
  std::array<std::vector<Index>, kDeviceArrayCount> holders_;  // [array][record] id
  std::vector<Record> touched_;
};

}  // namespace pbdsurg::cuda
