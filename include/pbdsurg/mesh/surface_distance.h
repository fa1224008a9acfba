// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Signed distance to a triangle surface of any quality.

#include <Eigen/Geometry>
#include <memory>
#include <span>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// Closest point, winding number and signed distance of a triangle surface.
///
/// What is inside is decided by the generalised winding number (Jacobson, Kavan, Sorkine-Hornung
/// 2013, "Robust inside-outside segmentation using generalized winding numbers"), so the surface
/// may be open, cross itself or have repeated triangles. Distant triangles count as dipoles
/// (Barill, Dickson, Schmidt, Levin, Jacobson 2018, "Fast winding numbers for soups and clouds").
/// Before that, triangles wound against their neighbours are turned, and so is a surface that is
/// inside out. Any number of threads may query one object at once.
class PBDSURG_API SurfaceDistance {
 public:
  /// @param points     [point_count] m
  /// @param triangles  point ids; triangles without area are left out
  /// @throws InvalidMesh  if a point in use is not finite, an id is out of range, no triangle has
  ///                      an area, or the winding number is near 1 almost nowhere behind the
  ///                      surface, so that there is no inside
  /// @note Cost: O(n log n); about 20 ms for 15 000 triangles.
  SurfaceDistance(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles);
  SurfaceDistance(const SurfaceDistance&) = default;  ///< a move copies, so that none is left empty
  SurfaceDistance& operator=(const SurfaceDistance&) = default;  ///< likewise

  /// Nearest point on any triangle, m.
  [[nodiscard]] Eigen::Vector3d closest_point(const Eigen::Vector3d& point) const;

  /// How often the surface winds around a point: 1 inside and 0 outside where it is closed, between
  /// where it is open. Approximate to a few hundredths.
  [[nodiscard]] double winding_number(const Eigen::Vector3d& point) const;

  /// Distance to the surface, m, negative where the winding number exceeds 1/2. Fades to zero where
  /// that happens without a triangle nearby, so that holes are closed by a smooth lid.
  [[nodiscard]] double signed_distance(const Eigen::Vector3d& point) const;

  /// Box around the triangles that have an area, m.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const noexcept;

  /// Triangles that were turned to agree with their neighbours.
  [[nodiscard]] Index turned_triangles() const noexcept;

  /// Whether the whole surface was inside out and has been turned.
  [[nodiscard]] bool was_inside_out() const noexcept;

 private:
  struct Tree;
  std::shared_ptr<const Tree> tree_;
};

/// The solid within a surface.
/// @throws InvalidMesh  as SurfaceDistance does
[[nodiscard]] PBDSURG_API ImplicitShape surface_shape(std::span<const Eigen::Vector3d> points,
                                                      std::span<const Triangle> triangles);

}  // namespace pbdsurg
