// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The triangles of moving surfaces that may matter to a tool in the next milliseconds.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/contact/contact_patch.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/views/live_surface.h"

#include "lib/contact/triangle_cull.h"

namespace pbdsurg {

/// Reads from a solver the vertices around a tool alone, and looks at all surfaces group by group,
/// each before what was too far in it may have come near: by the way that the tool and the tissue
/// may have gone since. What a look finds near is read in every step until the next.
class NearTriangles {
 public:
  static constexpr float kSlack = 3e-3F;       ///< m: what is nearer than that is near already
  static constexpr float kMostSlack = 12e-3F;  ///< m: a group waits no longer, however far it is

  /// @param bodies         [n] of the tissue
  /// @param fastest_tissue m/s
  /// @throws InvalidArgument  naming the body that there is not
  NearTriangles(const Tissue& tissue, std::span<const Index> bodies, float fastest_tissue);

  [[nodiscard]] std::size_t body_count() const noexcept { return surfaces_.size(); }

  /// @throws InvalidArgument  if it is another tissue
  void check_tissue(const Tissue& tissue) const;

  /// Reads what is near, what edits show, and the groups that are due.
  /// @param balls  of the tool, in the scene; as many as before
  /// @param time   s; where it goes back all is looked at
  void update(const Solver& solver, std::span<const ToolPoint> balls, double time);

  /// [ball] m: nearer than this no triangle is missing
  [[nodiscard]] std::span<const float> reaches() const noexcept { return reaches_; }

  /// How far triangles mattered in this step, which tells how far they do in the next.
  /// @param reaches  [ball] of TriangleCull::find() with ContactPatch::kMargin
  void note_reaches(std::span<const float> reaches);

  /// Adds what is near, body by body, in the order of their surfaces.
  void add_near(const Tissue& tissue, std::vector<CulledSurface>& surfaces) const;

  /// Of a body, with what it is made of; empty once a compaction has left it out.
  [[nodiscard]] CulledSurface culled(const Tissue& tissue, std::size_t body,
                                     std::span<const Triangle> triangles,
                                     std::span<const Eigen::Vector3f> positions) const;

 private:
  // Slots that are looked at together, and what was found near. Corners are in vertices_.
  struct Group {
    float thickness = 0;                // m, of a sheet
    std::vector<Triangle> triangles{};  // [slot]
    std::vector<Index> vertices{};      // theirs, once each
    std::vector<Index> near{};          // slots, ascending
    std::vector<Triangle> near_triangles{};
    std::vector<Index> near_vertices{};                              // once each
    double looked_at = 0;                                            // m, of travelled_
    float slack = 0;                                                 // m, from there on
    std::array<float, ContactPacket::kLargestPlaneCount> reaches{};  // [ball] m, reaches_ then
  };
  struct Surface {
    std::shared_ptr<const LiveSurface> live;
    float thickness = 0;  // m, of a sheet
    std::uint64_t seen_version = 0;
    int seen_renumberings = 0;
    std::vector<Group> groups{};
  };

  void forget();
  void follow_edits(const Solver& solver);
  void follow(Surface& surface);
  [[nodiscard]] float way_of(std::span<const ToolPoint> balls, double time) const;
  [[nodiscard]] bool is_due(const Group& group) const;
  void read(const Solver& solver);
  void look_at_all(const Solver& solver, std::span<const ToolPoint> balls);
  void look_at_due(std::span<const ToolPoint> balls);
  void note_found();
  void list_near(Group& group);
  void list_vertices(std::span<const Triangle> triangles, std::vector<Index>& vertices);
  template <class Visit>
  void for_each_group(Visit visit);

  float fastest_tissue_;  // m/s
  std::vector<Surface> surfaces_;
  std::vector<Index> vertices_;             // of surfaces, of the scene; some may have left them
  std::vector<Eigen::Vector3f> positions_;  // [vertices_] m, those near as of now
  std::vector<Index> places_;               // [vertex_count] in vertices_, or kInvalidIndex
  double travelled_ = 0;                    // m, by balls and tissue
  std::vector<ToolPoint> balls_;            // of the last step
  double time_ = 0;                         // s, likewise
  std::vector<float> reaches_;              // [ball] m
  bool has_looked_ = false;

  // scratch
  std::vector<Group*> looked_at_;
  std::vector<CulledSurface> culled_;
  std::vector<float> distances_;  // [ball] m
  std::vector<Index> read_, read_vertices_;
  std::vector<Eigen::Vector3f> read_positions_;
  std::vector<std::uint32_t> seen_at_;  // [vertices_] the list that it was put on last
  std::uint32_t lists_ = 0;
  std::vector<SlotRange> ranges_;
  TriangleCull cull_;
};

}  // namespace pbdsurg
