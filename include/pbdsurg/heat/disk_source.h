// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The heat of an electrode in closed form, for meshes that are coarser than the contact.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// A flat electrode on tissue.
struct DiskContact {
  Eigen::Vector3d center;  ///< m, on the surface
  Eigen::Vector3d inward;  ///< unit, into the tissue
  double radius;           ///< m
};

/// A vertex and its part of the whole power.
struct VertexShare {
  Index vertex;  ///< index of its position
  double share;  ///< positive
};

/// Shares the power of a disk electrode among vertices, without a solve.
///
/// On a half-space of even conductivity, surfaces of equal potential are the oblate spheroids
/// sinh(mu) = s around the disk, and the power inside of one is (2/pi) atan(s) of all of it (Newman
/// 1966; V = 1 - (2/pi) atan(s) for 1 V). With t = cos(nu) of the spheroidal coordinates, power is
/// spread evenly over (2/pi) atan(s), t and the angle. So kPoints points that are spread evenly
/// over these carry equal power, rim included, where the density itself is singular. Each point's
/// power goes to the corners of the tetrahedron around it by barycentric coordinates: the load of
/// linear finite elements.
///
/// Use it where edges are longer than about twice the radius, and a PotentialField where they are
/// not. Keeps memory, so that calls of equal size allocate nothing. Deterministic.
class PBDSURG_API DiskSource {
 public:
  static constexpr int kShells = 16;  ///< of equal power: from 0.05 to 20 radii
  static constexpr int kRows = 6;     ///< of equal power, by depth
  static constexpr int kTurns = 12;   ///< points around the axis
  static constexpr int kPoints = kShells * kRows * kTurns;  ///< of equal power

  /// Places the points, once for all contacts.
  DiskSource();

  /// Shares out the power over some tetrahedra. What the half-space would take elsewhere, they take
  /// in the same proportions: leave out those that are gone or carry no current.
  ///
  /// Cost: O(near), 0.1 to 0.5 us each, the more the larger they are.
  /// @param positions  [vertex_count] m, current
  /// @param tets       [tet_count]
  /// @param near       tetrahedra around the contact, each once
  /// @param shares     replaced: vertices ascending, the sum of shares is one; empty if no point
  ///                   lies in the tetrahedra
  /// @return  how much of the half-space's power they cover, [0, 1]
  /// @throws InvalidArgument  naming the radius that is not positive and finite, a centre that is
  ///                          not finite, an inward direction that is not of length one, or the
  ///                          tetrahedron, or the corner of one, that is not there; then nothing
  ///                          has changed
  double distribute(const DiskContact& contact, std::span<const Eigen::Vector3f> positions,
                    std::span<const Tet> tets, std::span<const Index> near,
                    std::vector<VertexShare>& shares);

 private:
  // Points at one depth and distance from the axis, of a disk of radius one around the z axis.
  struct Row {
    double depth, radius;
  };

  std::vector<double> shells_;           // [kShells] s
  std::vector<Row> rows_;                // [kShells * kRows]
  std::vector<Eigen::Vector3d> points_;  // [kPoints], those of a row follow each other
  std::vector<std::uint8_t> is_taken_;   // [kPoints] scratch
};

}  // namespace pbdsurg
