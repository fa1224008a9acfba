// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The part of a mesh around an electrode, kept from one solution to the next while it serves.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/heat/thermal_mesh.h"

#include "lib/heat/potential_region.h"
#include "lib/heat/region_joints.h"

namespace pbdsurg {

/// Where the electrode touches: a disk of the same size, for what is known before solving.
struct ContactPatch {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m, of the contact or what the mesh resolves
  double reach = 0;                                  // m, of the region
  double edge = 0;                                   // m, of the mesh there

  /// Potential of a disk on a half-space along its axis, zero from the reach on.
  [[nodiscard]] double guess(const Eigen::Vector3d& point) const;
};

/// Follows patch, ground, conductivities and what lives. A region serves while the patch stays in
/// its middle and elements at most go from it, or cease to conduct, without cutting anything off:
/// they stay listed then, and conduct nothing.
class ContactRegion {
 public:
  /// @param radii  of the region over that of the contact
  ContactRegion(const ThermalMesh& mesh, double radii);

  /// @param patch  ascending
  /// @param area   m^2
  /// @return       whether that is another contact than before
  bool set_patch(std::span<const PatchVertex> patch, double area);
  void set_ground(std::span<const Index> vertices);

  /// Goes along with a compaction, after the mesh has: patch and ground stay where they are, but
  /// for vertices that were gone. Keeps nothing else.
  /// @param vertices  old ids to new
  /// @throws InvalidArgument  if the mesh lacks a vertex of patch or ground; then nothing has
  /// changed
  void renumber(const std::vector<Index>& vertices);

  /// Finds the region of what is touched now, for the next enter().
  /// @return  whether anything that is touched conducts; if not, nothing is found
  /// @throws InvalidArgument  naming the element met whose conductivity is not >= 0 and finite
  /// Cost: O(region), a small part of a solution's; a search costs more, see RegionSearch.
  bool find(const ElementSpan& conductivities);

  /// [vertex_count] ids of what was found last
  [[nodiscard]] std::span<const Index> found_vertices() const noexcept {
    return (has_next_ ? next_ : region_).vertices;
  }

  /// [element_count] S/m of what was found last, zero for what has gone
  [[nodiscard]] std::span<const double> found_conductivities() const noexcept {
    return found_conductivities_;
  }

  /// Whether that is another region than region().
  [[nodiscard]] bool has_next() const noexcept { return has_next_; }

  /// Makes it so.
  void enter() noexcept;

  /// Keeps nothing.
  void leave();

  [[nodiscard]] const PotentialRegion& region() const noexcept { return region_; }

  // of what was found last

  [[nodiscard]] Index patch_size() const noexcept { return static_cast<Index>(patch_.size()); }

  /// Those of the patch that conduct.
  [[nodiscard]] std::span<const PatchVertex> seeds() const noexcept { return seeds_; }
  [[nodiscard]] const ContactPatch& contact() const noexcept { return contact_; }

  /// As it was when the region was searched for.
  [[nodiscard]] const ContactPatch& found_contact() const noexcept { return found_contact_; }

  /// Row of a vertex in it, kInvalidIndex for others.
  [[nodiscard]] Index row_of(Index vertex) const { return search_.row_of(vertex); }

 private:
  void find_seeds(const ElementSpan& conductivities);
  [[nodiscard]] ContactPatch measure_contact() const;
  bool serves(const PotentialRegion& region, const ElementSpan& conductivities);
  bool collect_gone(const PotentialRegion& region, const ElementSpan& conductivities);
  [[nodiscard]] bool is_in_middle(const PotentialRegion& region) const;
  [[nodiscard]] bool is_seed(Index vertex) const;
  [[nodiscard]] bool is_given_ground(Index vertex) const;
  [[nodiscard]] bool overrides_ground() const;
  void search(const ElementSpan& conductivities);

  const ThermalMesh& mesh_;
  double radii_;
  std::vector<double> sides_;  // [tissue_count] m, longest
  std::vector<PatchVertex> patch_, seeds_;
  double area_ = 0;
  std::uint64_t patch_number_ = 0;
  std::vector<Index> ground_;  // ascending; none: the ball
  ContactPatch contact_;

  PotentialRegion region_, next_;
  bool has_next_ = false;
  RegionSearch search_;
  RegionJoints joints_;

  std::uint64_t version_ = 0, growth_ = 0;  // of the mesh when it was looked at last

  // of the last search
  bool is_found_ = false;
  std::uint64_t found_patch_ = 0;
  ContactPatch found_contact_;
  bool has_overridden_ground_ = false;
  std::vector<char> is_gone_;  // [element_count] since
  std::size_t gone_count_ = 0;
  std::vector<double> found_conductivities_;  // [element_count]
  std::vector<Index> gone_;  // scratch: places among the elements of those that have just gone
};

}  // namespace pbdsurg
