// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The triangles of surfaces that matter to the points of a tool.

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/contact/contact_patch.h"

namespace pbdsurg {

/// A body's surface as it is now.
struct CulledSurface {
  std::span<const Triangle> triangles;         ///< corners in positions; thrice the same: none
  std::span<const Eigen::Vector3f> positions;  ///< m
  float youngs_modulus;                        ///< see PatchTriangle
  float poissons_ratio;                        ///< likewise
  float thickness;                             ///< likewise
};

/// Leaves out what is too far to be the nearest triangle of a point, or to be told. Keeps its
/// memory.
class TriangleCull {
 public:
  /// All that can be nearest to a ball's center once that has moved by a margin, of balls that are
  /// then inside of tissue or have some within ContactPatch::kReach.
  /// @param balls   in the scene, at most as many as a packet has planes
  /// @param whole   [ball] m: nearer than this no triangle is missing; what has none is outside
  /// @param margin  m, positive
  /// @throws InvalidArgument  naming the triangle with a corner that is not among the positions
  void find(std::span<const CulledSurface> surfaces, std::span<const ToolPoint> balls,
            std::span<const float> whole, float margin);

  /// All that have some within a distance of a ball's center, and a few more.
  /// @param distances  [ball] m, not negative
  /// @throws InvalidArgument  as find()
  void find_within(std::span<const CulledSurface> surfaces, std::span<const ToolPoint> balls,
                   std::span<const float> distances);

  /// Leaves out of them what lies beyond the nearest triangle of each ball, however it moves by the
  /// margin. That needs the surfaces to stay what they are.
  /// @param margin  m, that of find()
  void tighten(float margin);

  /// [n] what is left, in the order of surfaces and their triangles
  [[nodiscard]] std::span<const PatchTriangle> triangles() const noexcept {
    return near_.triangles;
  }
  /// [ball] m: see PatchPoint::reach
  [[nodiscard]] std::span<const float> reaches() const noexcept { return ball_reaches_; }
  /// [surface] m: by how much farther all others are, at least
  [[nodiscard]] std::span<const float> gaps() const noexcept { return near_.gaps; }
  /// [n] of each, where it stands in all triangles of all surfaces
  [[nodiscard]] std::span<const std::size_t> places() const noexcept { return near_.places; }

 private:
  using EachBall = Eigen::Array<float, ContactPacket::kLargestPlaneCount, 1>;

  // Spheres around balls' centers.
  struct Reaches {
    explicit Reaches(std::span<const ToolPoint> balls);
    [[nodiscard]] EachBall squares_to(const Eigen::Vector3f& point) const noexcept;  // m^2
    [[nodiscard]] bool meet(const PatchTriangle& triangle) const noexcept;

    EachBall x, y, z;   // m, of balls that there are not: nowhere near
    EachBall distance;  // m
    Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
    Eigen::Vector3f high = -low;  // m, of a box around centers
  };
  struct Taken {
    std::vector<PatchTriangle> triangles;
    std::vector<std::size_t> places;
    std::vector<float> gaps;  // [surface] m
    EachBall nearest_corner;  // m, of those that may be in reach
  };

  static void take(std::span<const CulledSurface> surfaces, const Reaches& reaches, Taken& taken);
  [[nodiscard]] bool is_beside_outside(std::span<const ToolPoint> balls, std::size_t ball,
                                       std::span<const bool> is_outside) const noexcept;
  [[nodiscard]] float search(std::span<const CulledSurface> surfaces, const Eigen::Vector3f& point);
  void note_reaches(std::size_t count, float margin);

  Reaches reaches_{{}};
  std::vector<float> ball_reaches_;
  Taken near_, searched_;
};

}  // namespace pbdsurg
