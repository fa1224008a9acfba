// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Connective tissue as thin translucent sheets between the organs that it joins.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/types.h"

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// A link at rest, and what it hangs on. Colours are sRGB in [0, 1].
struct SheetLink {
  Eigen::Vector3f first, second;              ///< m, its ends
  Eigen::Vector3f first_color, second_color;  ///< of the organs at its ends
};

/// The same link now. A link that is not finite is not drawn, a burn that is not finite is none.
struct SheetLinkState {
  Eigen::Vector3f first, second;  ///< m
  Eigen::Vector4f first_burn = Eigen::Vector4f::Zero();
  Eigen::Vector4f second_burn = Eigen::Vector4f::Zero();  ///< layers over the organs there
  bool is_alive = true;
};

/// Sheets to draw, of links and of the triangles that join them into a membrane.
///
/// - The border of what lives of the membrane is a curtain from organ to organ, welded where edges
///   meet, with a waist, as tissue under tension has it.
/// - Within, some edges between living triangles are fainter curtains. They show where the gap is
///   open, which is what one sees in it: areolar tissue that bridges it.
/// - Links in no living triangle, and those that no triangle names, are soft ribbons, from a
///   millimetre of length on.
///
/// Volume is constant: of a sheet stretched from A0 to A, 1 - (1 - alpha)^(A0 / A) is left of its
/// opacity. Towards an organ it is denser and of that organ's colour, and there it fades into it.
/// Heat colours it as its two ends: it is not heated by itself. Opacities, widths and the depth of
/// the waist are choices of display.
///
/// Deterministic: sheets depend on the last states alone, not on those before.
class MembraneSheets {
 public:
  /// @param links  [link_count]
  /// @param membrane  triangles of link ids; an edge may have any number of triangles
  /// @param color  of the tissue, sRGB
  /// @throws pbdsurg::InvalidArgument  naming the triangle and the link that there is not, or the
  ///                                   link that is not finite
  MembraneSheets(std::span<const SheetLink> links, std::span<const pbdsurg::Triangle> membrane,
                 const Eigen::Vector3f& color);

  /// Cost: O(links + triangles). Allocates until buffers have grown as large as they get.
  /// @param states  [link_count]
  /// @throws pbdsurg::InvalidArgument  naming the two counts that differ
  void update(std::span<const SheetLinkState> states);

  /// Curtain, web and ribbons, with colours and normals for each vertex; empty before update().
  [[nodiscard]] const std::array<Surface, 3>& surfaces() const noexcept { return surfaces_; }
  [[nodiscard]] const Surface& curtain() const noexcept { return surfaces_[0]; }
  [[nodiscard]] const Surface& web() const noexcept { return surfaces_[1]; }
  [[nodiscard]] const Surface& ribbons() const noexcept { return surfaces_[2]; }

  /// Places of vertices along a link, from 0 at its first end to 1: of curtain and web, whose
  /// vertices are in rows of one link each.
  static constexpr std::array<float, 7> kLevels{0, 0.15F, 0.3F, 0.5F, 0.7F, 0.85F, 1};

 private:
  struct MembraneEdge {
    std::array<pbdsurg::Index, 2> links;
    bool is_web;  // one of those that show within the membrane
    // now
    int living_triangles;
    pbdsurg::Triangle last;  // of these, turned so that this edge comes first; links
  };
  // Some edges of the membrane, and the links that they join: rows of vertices.
  struct Sheet {
    std::vector<std::array<pbdsurg::Index, 2>> edges;  // rows, as a living triangle goes round
    std::vector<pbdsurg::Index> opposite;              // [edge] link
    std::vector<pbdsurg::Index> links;                 // [row]
  };
  struct SheetStyle;

  void note_living(std::span<const SheetLinkState> states);
  void sort_edges();
  void collect(Sheet& sheet, bool is_border);
  void shape(const Sheet& sheet, const SheetStyle& style, std::span<const SheetLinkState> states,
             Surface& surface);
  void find_ends(const Sheet& sheet, int rounds, std::span<const SheetLinkState> states);
  void find_waists(const Sheet& sheet, int rounds, std::span<const SheetLinkState> states);
  void smooth(const Sheet& sheet, int rounds, std::vector<Eigen::Vector3f>& values);
  void find_thinning(const Sheet& sheet, std::span<const SheetLinkState> states);
  void shape_ribbons(std::span<const SheetLinkState> states);
  void add_ribbon(const SheetLink& rest, const SheetLinkState& now);
  [[nodiscard]] Eigen::Vector4f color_at(const SheetLink& rest, const SheetLinkState& now,
                                         float place, float alpha, float end_alpha) const;

  std::vector<SheetLink> links_;
  std::vector<pbdsurg::Triangle> triangles_;
  std::vector<std::array<pbdsurg::Index, 3>> edges_of_triangle_;
  std::vector<MembraneEdge> edges_;
  Eigen::Vector3f color_;

  std::vector<std::uint8_t> is_alive_;   // [link] as of the last update
  std::vector<std::uint8_t> is_lonely_;  // [link] alive, in no living triangle
  bool is_sorted_ = false;
  Sheet border_, inner_;
  std::array<Surface, 3> surfaces_;
  // scratch
  std::vector<pbdsurg::Index> row_of_;                     // [link]
  std::vector<Eigen::Vector3f> first_ends_, second_ends_;  // [row] m
  std::vector<Eigen::Vector3f> waists_;                    // [row] unit, or zero
  std::vector<Eigen::Vector2f> areas_;                     // [row] m^2 at rest, now
  std::vector<Eigen::Vector3f> sums_;                      // [row]
  std::vector<int> counts_;                                // [row]
};

}  // namespace cholecystectomy
