// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How pieces of tissue move as rigid bodies that touch surfaces and each other: the balance of
/// rigid_balance.h for all of them at once, on a host. What a contact gives to one, it takes from
/// the other.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/rigid_balance.h"

namespace pbdsurg {

/// A contact of pieces of a group.
struct GroupContact {
  RigidContact contact;         ///< as the first piece has it
  Index first;                  ///< of the group
  Index second{kInvalidIndex};  ///< or kInvalidIndex: what does not move
  Vec3<double> other_arm{};     ///< m, from the centre of the second
};

/// Twists of the pieces of a group, or wrenches on them, one after another.
struct GroupScrews {
  /// Pieces of a group, at most.
  static constexpr Index kMostPieces = 8;

  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6 * kMostPieces, 1> values;

  [[nodiscard]] Screw of(Index piece) const {
    const auto screw = values.segment<6>(6 * piece);
    return {{screw[0], screw[1], screw[2]}, {screw[3], screw[4], screw[5]}};
  }
};

inline double dot(const GroupScrews& a, const GroupScrews& b) {
  return a.values.dot(b.values);
}

inline GroupScrews advanced(const GroupScrews& from, double share, const GroupScrews& way) {
  return {from.values + share * way.values};
}

class GroupBalance {
 public:
  /// @param bodies    at most GroupScrews::kMostPieces
  /// @param contacts  both live as long as this
  GroupBalance(std::span<const RigidBody> bodies, std::span<const GroupContact> contacts)
      : bodies_(bodies), contacts_(contacts) {}

  /// The twists q. Cost: O(pieces^3) and O(contacts), a few times.
  [[nodiscard]] GroupScrews twists() const;

  // For BalancingMotion.
  [[nodiscard]] GroupScrews imbalance(const GroupScrews& twists) const;
  [[nodiscard]] GroupScrews way(const GroupScrews& twists, const GroupScrews& wrenches) const;

 private:
  std::span<const RigidBody> bodies_;
  std::span<const GroupContact> contacts_;
};

}  // namespace pbdsurg
