// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The triangles and links that tools may meet.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// Whether a body is neither of tetrahedra nor a sheet.
[[nodiscard]] inline bool has_particles(const Body& body) noexcept {
  return body.tet_count == 0 && body.triangle_count == 0;
}

/// The surfaces of all bodies, and the links within bodies of particles, by places of the state.
/// Nothing, and at no cost, until a tool asks for them.
class TissueSurface final : public Follower {
 public:
  /// Places of corners; kInvalidIndex of a slot without a triangle. A link has its second end
  /// twice.
  using PlaceTriangle = std::array<Index, 3>;

  /// @param place_of_vertex  [vertex_count] of the solver, as it is whenever refresh() is called
  explicit TissueSurface(const std::vector<Index>& place_of_vertex)
      : place_of_vertex_(place_of_vertex) {}

  /// From here on it is there. Cost: O(T log T) in tetrahedra; nothing, if it was.
  void begin(const Tissue& tissue);
  [[nodiscard]] bool has_begun() const noexcept { return has_begun_; }

  /// Takes what edits have changed since. Cost: proportional to that, as begin() for bodies that
  /// came, and O(n log n) of all particles and their links.
  void refresh(const Tissue& tissue);

  /// Triangles and links of all bodies, as of the last refresh().
  [[nodiscard]] PBDSURG_API Index triangle_count() const noexcept;

  /// As many of them, or more: with slots that have none.
  [[nodiscard]] std::size_t slot_count() const noexcept;

  /// Of these: another number, other triangles.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  /// Calls visit(triangle) in the order of bodies and slots; a sheet's come once a side. Then
  /// come links.
  template <class Visit>
  void for_each_triangle(const Visit& visit) const {
    for (const std::unique_ptr<Surface>& surface : surfaces_) {
      visit_triangles(*surface, visit);
    }
    std::ranges::for_each(links_, visit);
  }

  /// Likewise those of sheets, and links: what has no inside.
  template <class Visit>
  void for_each_thin(const Visit& visit) const {
    for (const std::unique_ptr<Surface>& surface : surfaces_) {
      if (surface->live.is_two_sided()) {
        visit_triangles(*surface, visit);
      }
    }
    std::ranges::for_each(links_, visit);
  }
  [[nodiscard]] bool has_thin() const noexcept {
    return !links_.empty() || std::ranges::any_of(surfaces_, [](const auto& surface) {
      return surface->live.is_two_sided();
    });
  }

  /// The links within a body of particles, each pair of ends once, ascending.
  [[nodiscard]] std::vector<PlaceTriangle> links_of(const Tissue& tissue, Index body) const;

  /// Whether a body is a sheet.
  [[nodiscard]] bool is_two_sided(Index body) const noexcept {
    return surfaces_[body]->live.is_two_sided();
  }

  /// Of the slots of a body: another number, other triangles. No two surfaces share one.
  [[nodiscard]] std::uint64_t revision_of(Index body) const noexcept {
    return surfaces_[body]->revision;
  }

  /// [slot] of a body; kInvalidIndex in those without a triangle.
  [[nodiscard]] std::span<const PlaceTriangle> slots(Index body) const noexcept {
    return surfaces_[body]->triangles;
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

 private:
  struct Surface {
    // Follows along with the others: of itself it could not come while an edit can be undone.
    Surface(const Tissue& tissue, Index body) : live(tissue, body) { live.leave_tissue(); }
    LiveSurface live;
    bool follows_last_edit = false;  // else it came after that
    std::uint64_t seen_version = 0;
    std::uint64_t revision = 0;
    std::vector<PlaceTriangle> triangles{};  // [slot]
  };

  template <class Visit>
  static void visit_triangles(const Surface& surface, const Visit& visit) {
    for (const PlaceTriangle& triangle : surface.triangles) {
      if (triangle[0] != kInvalidIndex) {
        visit(triangle);
      }
    }
  }

  void refresh_links(const Tissue& tissue);

  const std::vector<Index>& place_of_vertex_;
  bool has_begun_ = false;
  std::vector<std::unique_ptr<Surface>> surfaces_;  // [body]
  std::vector<PlaceTriangle> links_;
  std::optional<std::uint64_t> links_version_;  // of the tissue, that these are of
  std::vector<SlotRange> ranges_;               // scratch
  std::uint64_t revision_ = 0;
};

}  // namespace pbdsurg
