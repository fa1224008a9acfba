// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rigid motions that bring organs to the places of others.

#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace cholecystectomy {

/// Centre and principal axes of a cloud of points, the longest axis first. Each points to where the
/// cloud is drawn out (positive third moment), so that blunt ends meet blunt ends.
struct Frame {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< m, standard deviation along each axis
};

Frame frame_of(std::span<const Eigen::Vector3d> points);

/// An organ, and the one whose place it takes.
struct Replacement {
  Frame own, replaced;
};

/// The rigid motion that brings centres and axes of all organs nearest to those that they replace,
/// in the sense of least squares (Kabsch 1976, "A solution for the best rotation to relate two sets
/// of vectors"). Each organ weighs as much, whatever its size; of one alone, centre and axes meet.
/// @param organs  one at least
Eigen::Isometry3d fit_motion(std::span<const Replacement> organs);

}  // namespace cholecystectomy
