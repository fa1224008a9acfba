// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Smoke of the cautery: puffs that rise from the hook, and the haze that they leave in the cavity.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// Smoke in simulation time. Deterministic, and allocates nothing after construction.
///
/// A puff's way is a function of its age, so that steps of any length give the same puffs but for
/// rounding: a jet that the gas around it stops, a plume that rises, and eddies that grow with it.
/// It thins as it spreads. All smoke ends in the haze, which is well mixed: of optical depth D, it
/// takes 1 - exp(-D) of the light.
class Smoke {
 public:
  static constexpr std::size_t kMostPuffs = 150;
  static constexpr double kShortestLife = 1, kLongestLife = 2;  ///< s

  /// J of a puff, but for powers at which there would be more than kMostPuffs: then those are
  /// denser.
  static constexpr double kEnergyPerPuff = 0.8;

  /// Optical depth of the haze for each joule, over the way from scope to target. A choice of
  /// display: 40 W without suction level off at 1 - exp(-1.5) = 0.78, with it at 0.21.
  static constexpr double kDepthPerJoule = 1.5e-3;
  static constexpr double kClearing = 25;          ///< s, in which the haze thins to 1 / e
  static constexpr double kClearingBySuction = 4;  ///< s, the same under suction

  static constexpr double kSuction = 0.3;  ///< a valve that stands a little open

  /// Of the demo: the hook works from below, so that smoke cannot rise: it flows along the organs,
  /// to the scope.
  [[nodiscard]] static Smoke of_scene() { return Smoke(7, {0, -1, 0.3F}); }

  /// @param up  where smoke rises to, of any length but zero
  /// @throws pbdsurg::InvalidArgument  if that has no direction
  explicit Smoke(std::uint64_t seed = 7, const Eigen::Vector3f& up = Eigen::Vector3f::UnitZ());

  /// @param dt  s
  /// @param source  m, where tissue burns; haze alone comes from one that is not finite
  /// @param power  W, delivered to tissue in this step
  /// @param suction  from 0, none, to 1
  /// @throws pbdsurg::InvalidArgument  naming the value that is negative, too large or not finite
  void advance(double dt, const Eigen::Vector3f& source, double power, double suction = 0);

  /// Oldest first.
  [[nodiscard]] std::span<const SmokePuff> puffs() const noexcept { return puffs_; }
  /// Share of the light that it takes, [0, 1).
  [[nodiscard]] float haze() const noexcept;

 private:
  struct Origin {
    Eigen::Vector3f source;  // m
    std::uint64_t number;
    double age;    // s
    double depth;  // optical, in the middle at birth; suction thins it
    double life;   // s
  };
  [[nodiscard]] SmokePuff puff_of(const Origin& origin) const;
  [[nodiscard]] Eigen::Vector3f random_vector(std::uint64_t number, std::uint64_t use) const;
  void emit(double dt, const Eigen::Vector3f& source, double power, double thinning);

  std::uint64_t seed_;
  Eigen::Vector3f up_;
  std::vector<Origin> origins_;  // oldest first, as puffs_
  std::vector<SmokePuff> puffs_;
  std::uint64_t emitted_ = 0;
  double due_ = 0;  // of the next puff, [0, 1)
  Eigen::Vector3f last_source_;
  double haze_depth_ = 0;
};

}  // namespace cholecystectomy
