// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which bodies meet each other, and their surfaces by places.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/solver/tissue_contact.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/touch_rules.h"

namespace pbdsurg {

class TissueSurface;

/// Two bodies that meet each other, or one that meets itself.
struct ContactPair {
  Index first, second;  ///< bodies, ascending
  TissueContact contact;
};

/// Of all copies. Empty, and at no cost, until bodies are to meet.
class ContactBodies {
 public:
  using PlaceTriangle = std::array<Index, 3>;

  /// An edge of a surface, or a link of particles.
  struct Edge {
    std::array<Index, 2> ends;  ///< ascending
    /// Corners of the triangles there, first of the one that is wound along the edge;
    /// kInvalidIndex where there is none.
    std::array<Index, 2> opposite;

    auto operator<=>(const Edge& other) const noexcept = default;
  };

  struct Body {
    Index body = kInvalidIndex;  ///< of the tissue
    bool is_two_sided = false;   ///< a sheet, or particles
    bool meets_itself = false;
    Index first_vertex = 0;       ///< of its vertices among those of all
    std::uint64_t revision = 0;   ///< of the lists below: another number, other lists
    std::uint64_t surface = 0;    ///< TissueSurface::revision_of(), which they are of
    std::vector<Index> places{};  ///< of its surface, ascending
    /// Each once, the smallest place first, as they are wound; ascending. Links of particles are
    /// among them, with their second end twice.
    std::vector<PlaceTriangle> triangles{};
    /// Ascending; of what is solid those that are sharp: vertices see all else.
    std::vector<Edge> edges{};
  };

  /// In the order of bodies.
  [[nodiscard]] std::span<const ContactPair> pairs() const noexcept { return pairs_; }
  [[nodiscard]] bool empty() const noexcept { return pairs_.empty(); }

  /// Adds a pair, or replaces what it had.
  void set(const ContactPair& pair);
  /// Takes a pair out, if it is there.
  void remove(Index first, Index second);
  void replace(std::vector<ContactPair> pairs);
  /// Takes out the pairs of bodies from an id on.
  void drop_bodies_from(Index body);

  /// Lists surfaces, if an edit came or pairs have changed since they were.
  /// Cost: O(T) of the triangles of bodies whose surface has changed, O(V) of all, O(links).
  /// @param surface  as of now
  void refresh(const Tissue& tissue, const TissueSurface& surface,
               std::span<const Index> place_of_vertex);

  /// Of the lists: another number, other lists. Above zero.
  [[nodiscard]] std::uint64_t revision() const noexcept { return revision_; }

  /// Bodies of any pair, ascending.
  [[nodiscard]] std::span<const Body> bodies() const noexcept { return bodies_; }
  [[nodiscard]] PBDSURG_API const Body& body(Index of_tissue) const noexcept;
  /// Vertices of all surfaces above.
  [[nodiscard]] Index vertex_count() const noexcept { return vertex_count_; }

  /// They live as long as the lists.
  [[nodiscard]] TouchRules rules() const noexcept {
    return {is_joined_.data(), rest_.data(), first_neighbors_.data(), neighbors_.data()};
  }
  /// [place] m, of all vertices.
  [[nodiscard]] std::span<const Vec3<float>> rest_positions() const noexcept { return rest_; }
  [[nodiscard]] std::span<const std::uint8_t> joined_places() const noexcept { return is_joined_; }
  [[nodiscard]] std::span<const Index> first_neighbors() const noexcept { return first_neighbors_; }
  [[nodiscard]] std::span<const Index> neighbors() const noexcept { return neighbors_; }

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void list(const Tissue& tissue, const TissueSurface& surface,
            std::span<const Index> place_of_vertex);
  void list_body(const Tissue& tissue, const TissueSurface& surface,
                 std::span<const Index> place_of_vertex, Body& body);
  void mark_joined(const Tissue& tissue, std::span<const Index> place_of_vertex);
  void list_neighbors();

  std::vector<ContactPair> pairs_;
  std::vector<Body> bodies_;
  Index vertex_count_ = 0;
  std::uint64_t revision_ = 0, last_body_ = 0;  // of all lists, and of a body's that were made last
  std::optional<std::uint64_t> version_;        // of the tissue, that the lists are of
  // see TouchRules
  std::vector<std::uint8_t> is_joined_;
  std::vector<Vec3<float>> rest_;
  std::vector<Index> first_neighbors_, neighbors_;
};

}  // namespace pbdsurg
