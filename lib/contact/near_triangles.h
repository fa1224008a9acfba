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

/// Reads from a solver the vertices around a tool alone, and looks at those of all surfaces little
/// by little: groups of triangles take turns, so that each is looked at before the tool and the
/// tissue have gone kSlack since. What a look finds that near is read in every step until the next.
class NearTriangles {
 public:
  static constexpr float kSlack = 3e-3F;  ///< m

  /// @param bodies         [n] of the tissue
  /// @param fastest_tissue m/s
  /// @throws InvalidArgument  naming the body that there is not
  NearTriangles(const Tissue& tissue, std::span<const Index> bodies, float fastest_tissue);

  [[nodiscard]] std::size_t body_count() const noexcept { return surfaces_.size(); }

  /// @throws InvalidArgument  if it is another tissue
  void check_tissue(const Tissue& tissue) const;

  /// Reads what is near, what edits show, and the groups whose turn it is.
  /// @param balls  of the tool, in the scene; as many as before
  /// @param time   s; where it goes back all is looked at
  void update(const Solver& solver, std::span<const ToolPoint> balls, double time);

  /// [ball] m: nearer than this no triangle is missing
  [[nodiscard]] std::span<const float> reaches() const noexcept { return reaches_; }

  /// How far triangles mattered in this step, which tells how far they do in the next.
  /// @param reaches  [ball] of TriangleCull::find() with ContactPatch::kMargin
  void note_reaches(std::span<const float> reaches);

  /// Adds a surface for each body, with what is near of it.
  void add_near(const Tissue& tissue, std::vector<CulledSurface>& surfaces) const;

  /// Of a body, with what it is made of; empty once a compaction has left it out.
  [[nodiscard]] CulledSurface culled(const Tissue& tissue, std::size_t body,
                                     std::span<const Triangle> triangles,
                                     std::span<const Eigen::Vector3f> positions) const;

 private:
  // Slots that are looked at together, and what was found near.
  struct Group {
    double looked_at = 0;                                            // m, of travelled_
    std::array<float, ContactPacket::kLargestPlaneCount> reaches{};  // [ball] m, reaches_ then
    std::vector<Index> near{};                                       // slots, ascending
  };
  struct Surface {
    std::shared_ptr<const LiveSurface> live;
    std::uint64_t seen_version = 0;
    int seen_renumberings = 0;
    std::vector<Triangle> triangles{};  // [slot] corners in vertices_
    std::vector<Group> groups{};
    std::vector<Triangle> near{};  // of all groups
  };
  struct GroupPlace {
    std::size_t surface, group;
  };

  void forget();
  void follow_edits(const Solver& solver);
  void follow(Surface& surface);
  [[nodiscard]] float way_of(std::span<const ToolPoint> balls, double time) const;
  [[nodiscard]] bool is_due(const Group& group) const;
  void choose_groups(float way);
  void read(const Solver& solver);
  void look_at_all(const Solver& solver, std::span<const ToolPoint> balls);
  void share_found();
  void look_at_chosen(std::span<const ToolPoint> balls);
  void list_near();
  void take_turn(Group& group);
  [[nodiscard]] static std::span<const Triangle> triangles_of(const Surface& surface,
                                                              std::size_t group);

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
  std::size_t next_ = 0;  // of all groups, whose turn is next

  // scratch
  std::vector<GroupPlace> chosen_;
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
