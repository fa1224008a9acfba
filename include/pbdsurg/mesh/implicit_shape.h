// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Solids described by a function that is negative inside: primitives, and what combines them.
/// Values of primitives are exact distances; their sizes are positive and finite, else they throw
/// InvalidArgument.

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <span>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// A solid: the points where a distance-like function is negative.
///
/// The function is in metres, zero on the surface, and should change by at most about 1.3 m per
/// metre travelled (a signed distance changes by 1): the tetrahedraliser skips space on that
/// promise. Values are cheap to copy (they share their definition) and safe to evaluate from any
/// number of threads if the given functions are.
class PBDSURG_API ImplicitShape {
 public:
  /// m, at a point in m.
  using Value = std::function<double(const Eigen::Vector3d&)>;
  /// m, to a point in m.
  using ClosestPoint = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

  /// @param value          m, negative inside
  /// @param bounds         m, a box around all points where the value is negative; sides may be
  ///                       infinite for shapes that only serve to cut others
  /// @param closest_point  nearest point of the surface, where it is cheaper than following the
  ///                       value's gradient
  /// @throws InvalidArgument  if there is no value function or the box is empty or not a number
  ImplicitShape(Value value, const Eigen::AlignedBox3d& bounds, ClosestPoint closest_point = {});
  ImplicitShape(const ImplicitShape&) = default;  ///< a move copies, so that none is left empty
  ImplicitShape& operator=(const ImplicitShape&) = default;  ///< likewise

  /// Distance-like value at a point, m; negative inside.
  [[nodiscard]] double operator()(const Eigen::Vector3d& point) const {
    return definition_->value(point);
  }

  /// Box around the solid, m.
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const noexcept { return definition_->bounds; }

  /// Whether it was given a function for the closest point.
  [[nodiscard]] bool has_closest_point() const noexcept {
    return static_cast<bool>(definition_->closest_point);
  }

  /// Moves a point that lies near the surface onto it.
  ///
  /// By the closest point where the shape has one, else by two Newton steps along one gradient.
  /// @param reach  m; a point that would have to travel farther stays where it is. The gradient is
  ///               differenced over a twenty-fifth of it.
  [[nodiscard]] Eigen::Vector3d project(const Eigen::Vector3d& point, double reach) const;

 private:
  struct Definition {
    Value value;
    Eigen::AlignedBox3d bounds;
    ClosestPoint closest_point;
  };
  std::shared_ptr<const Definition> definition_;
};

// --- primitives

/// All points within `radius` of a centre.
[[nodiscard]] PBDSURG_API ImplicitShape sphere_shape(const Eigen::Vector3d& center, double radius);

/// All points within `radius` of a segment.
[[nodiscard]] PBDSURG_API ImplicitShape capsule_shape(const Eigen::Vector3d& from,
                                                      const Eigen::Vector3d& to, double radius);

/// The convex hull of two spheres.
[[nodiscard]] PBDSURG_API ImplicitShape round_cone_shape(const Eigen::Vector3d& from,
                                                         double from_radius,
                                                         const Eigen::Vector3d& to,
                                                         double to_radius);

/// A tube of varying width: round cones along a uniform Catmull-Rom spline.
///
/// @param knots            [knot_count >= 2] x, y, z, radius; m
/// @param pieces_per_span  cones between two knots; below 8 the joints show as faint rings
/// @note Pieces are culled by bounding spheres, so a value costs a few cones, not all.
[[nodiscard]] PBDSURG_API ImplicitShape tube_shape(std::span<const Eigen::Vector4d> knots,
                                                   int pieces_per_span = 10);

/// An ellipsoid along the axes. The distance is exact to 1e-7 of its smallest radius.
[[nodiscard]] PBDSURG_API ImplicitShape ellipsoid_shape(const Eigen::Vector3d& center,
                                                        const Eigen::Vector3d& radii);

/// A box along the axes with rounded edges.
/// @param half_size      m, rounding included
/// @param corner_radius  m, at least zero and at most the smallest half size
[[nodiscard]] PBDSURG_API ImplicitShape rounded_box_shape(const Eigen::Vector3d& center,
                                                          const Eigen::Vector3d& half_size,
                                                          double corner_radius);

/// Everything on the far side of a plane: {x : normal . (x - point) < 0}. Unbounded.
[[nodiscard]] PBDSURG_API ImplicitShape half_space_shape(const Eigen::Vector3d& point,
                                                         const Eigen::Vector3d& normal);

// --- combinations

/// What is in `a` or in `b`, blended where they meet.
/// @param blend_radius  m, zero or more: points whose two values differ by less are blended,
///                      which moves the surface by at most a quarter of it
[[nodiscard]] PBDSURG_API ImplicitShape smooth_union(const ImplicitShape& a, const ImplicitShape& b,
                                                     double blend_radius);
/// What is in both, blended likewise.
/// @throws InvalidArgument  if their boxes are apart
[[nodiscard]] PBDSURG_API ImplicitShape smooth_intersection(const ImplicitShape& a,
                                                            const ImplicitShape& b,
                                                            double blend_radius);
/// What is in `a` and not in `b`.
[[nodiscard]] PBDSURG_API ImplicitShape smooth_difference(const ImplicitShape& a,
                                                          const ImplicitShape& b,
                                                          double blend_radius);

/// Grows a shape by `distance` metres, or shrinks it when negative.
[[nodiscard]] PBDSURG_API ImplicitShape offset_shape(const ImplicitShape& shape, double distance);

/// The outermost `thickness` metres of a shape: hollow inside.
[[nodiscard]] PBDSURG_API ImplicitShape shell_shape(const ImplicitShape& shape, double thickness);

}  // namespace pbdsurg
