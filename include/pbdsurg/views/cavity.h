// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hollows within tissue, kept up to date through edits.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// The walls of all closed hollows of a body: of each the triangles, in scene vertices, wound so
/// that normals point into the tissue. Hollows that meet at an edge alone are apart. In the order
/// of their first tetrahedra. Cost: O(T log T) in the body's tetrahedra.
/// @throws InvalidArgument  if there is no such body
[[nodiscard]] PBDSURG_API std::vector<std::vector<Triangle>> find_cavities(const Tissue& tissue,
                                                                           Index body);

/// A hollow: faces of tissue that close it, and flat caps over the holes that edits made in it.
///
/// A removal that leaves it closed adds what that lays bare. What joins it with the outside opens
/// it: then its wall is what is left of the wall before, and each loop of free edges the rim of a
/// hole. From then on it grows no more, and what goes of its wall makes holes larger; an undo
/// closes it again. Tissue that comes loose within a hollow is not of its wall.
///
/// Cost of an edit: O(k log n) in the k tetrahedra that change, of one that changes the wall O(n)
/// in its n faces, and of one that joins it with another surface O(m log m) in the faces of both.
class PBDSURG_API Cavity final : public Follower {
 public:
  /// @param wall  triangles of the tissue's surface, wound in any way
  /// @throws InvalidArgument  naming the triangle that is no face of living tissue, is not at its
  ///                          surface or is there twice, or the edge at which the wall is open; and
  ///                          if it bounds tissue, or nothing
  Cavity(const Tissue& tissue, std::span<const Triangle> wall);

  /// A closed surface in scene vertices, wound so that normals point out of the hollow: the wall,
  /// then caps. Empty once all of the wall is gone.
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept { return state_.triangles; }
  /// [wall_count] where each triangle of the wall comes from.
  [[nodiscard]] std::span<const TetFace> origins() const noexcept { return state_.origins; }
  /// Vertices of triangles(), ascending.
  [[nodiscard]] std::span<const Index> vertices() const noexcept { return state_.vertices; }
  /// How many triangles are of the wall: the first ones.
  [[nodiscard]] Index wall_count() const noexcept {
    return static_cast<Index>(state_.origins.size());
  }

  /// Whether there are holes, or no wall.
  [[nodiscard]] bool is_open() const noexcept { return state_.is_open; }
  /// How many holes there are.
  [[nodiscard]] Index hole_count() const noexcept {
    return static_cast<Index>(state_.hole_ends.size());
  }
  /// The caps of a hole, of those in triangles().
  /// @throws InvalidArgument  naming the hole that there is not
  [[nodiscard]] std::span<const Triangle> caps(Index hole) const;

  /// m^3, with caps over holes.
  /// @param positions  [vertex_count] m
  /// @throws InvalidArgument  if there are fewer than vertices of the wall need
  [[nodiscard]] double volume(std::span<const Eigen::Vector3f> positions) const;
  /// m^2, of all holes: of each the area of its projection to the plane in which that is largest.
  /// @throws InvalidArgument  as volume()
  [[nodiscard]] double hole_area(std::span<const Eigen::Vector3f> positions) const;

  /// Changes with each edit, undo and compaction that changes the triangles.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_; }

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  struct State {
    std::vector<TetFace> origins;     // [wall_count] ascending
    std::vector<Triangle> triangles;  // [wall_count], then caps
    std::vector<Index> vertices;      // of triangles, ascending
    std::vector<Index> hole_ends;     // [hole_count] of triangles
    bool is_open = false;
  };

  [[nodiscard]] static State make_state(const Tissue& tissue, std::vector<TetFace> wall);
  void check(std::span<const Eigen::Vector3f> positions) const;

  State state_, before_;      // the last edit
  bool has_changed_ = false;  // by the last edit
  std::uint64_t version_ = 1;
};

}  // namespace pbdsurg
