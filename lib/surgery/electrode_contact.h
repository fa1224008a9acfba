// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where an electrode touches tissue and links.

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/heat/thermal_mesh.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/renumbering.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// Positions of a scene, of which those are up to date that were read last. What is not finite
/// stays where it was.
class ScenePositions {
 public:
  explicit ScenePositions(const Tissue& tissue)
      : values_(static_cast<std::size_t>(tissue.vertex_count()), Eigen::Vector3f::Zero()) {}

  void read(const Solver& solver, std::span<const Index> vertices);

  /// Reads all of them, and none from then on, until release().
  void hold(const Solver& solver);
  void release() noexcept { is_held_ = false; }

  /// Reads what is new since the last call.
  void follow(const Solver& solver);

  /// Keeps the size of the tissue.
  void resize(const Tissue& tissue);

  void renumber(const Tissue& tissue, const Renumbering& ids);

  /// [vertex_count] m
  [[nodiscard]] std::span<const Eigen::Vector3f> values() const noexcept { return values_; }

 private:
  void take(const Solver& solver, std::span<const Index> vertices);

  std::vector<Eigen::Vector3f> values_, some_;
  std::vector<Index> added_;
  Index unread_ = 0;  // vertices from here on are new
  bool is_held_ = false;
};

/// A vertex of the surface near an electrode.
struct NearVertex {
  Index vertex;
  double gap;       ///< m from the electrode's axis to the surface of its body
  double distance;  ///< m along the surface from under the axis
  double radius;    ///< m, of a disk as large as the vertex's part of the surface
};

struct TouchedLink {
  Index link;
  double nearness;  ///< 1 - distance / radius, (0, 1]
};

/// The point of the surface that is nearest to an electrode.
struct NearestPoint {
  /// m outside of tissue to the electrode's axis, 0 inside; infinite: nothing is near
  double gap = std::numeric_limits<double>::infinity();
  double distance = std::numeric_limits<double>::infinity();  ///< m, whichever side
  Eigen::Vector3d point = Eigen::Vector3d::Zero();            ///< m
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();          ///< unit
  Triangle triangle = LiveSurface::kEmptyTriangle;            ///< scene vertices
};

/// Finds what an electrode touches of some bodies' surfaces and of links, in current positions.
///
/// Looks at what lay about the electrode when it last looked at everything, which is often enough
/// for tissue that moves slower than kFastestTissue.
class ElectrodeContact {
 public:
  static constexpr double kFastestTissue = 0.25;  // m/s

  ElectrodeContact(const Tissue& tissue, std::span<const ThermalBody> bodies, double radius);

  /// @param reach  m, >= radius: how far to look beyond the contact, for sparks
  /// @param dt     s since the last call
  void find(const Solver& solver, const Electrode& electrode, double reach, double dt,
            ScenePositions& positions);

  [[nodiscard]] const NearestPoint& nearest() const noexcept { return nearest_; }

  /// m^2: of the contact radius around what touches of the electrode's axis.
  [[nodiscard]] double area() const noexcept { return area_; }

  /// Those within some reach, with the share that is touched.
  /// @param accept  bool(Index vertex)
  template <class Accept>
  void collect_patch(double reach, std::vector<PatchVertex>& patch, Accept accept) const {
    patch.clear();
    for (const NearVertex& near : near_) {
      const double weight = touched_share(near, reach);
      if (near.gap <= reach && weight > kLeastShare && accept(near.vertex)) {
        patch.push_back({near.vertex, weight});
      }
    }
  }

  /// m^2 of a vertex's part of the surface, of vertices of a patch
  [[nodiscard]] double area_of(Index vertex) const { return vertex_areas_[vertex]; }

  [[nodiscard]] std::span<const TouchedLink> links() const noexcept { return links_; }

  /// What was touched has to be found again.
  void renumber(const Tissue& tissue, const Renumbering& ids);

  /// After tissue was put elsewhere.
  void forget() noexcept { slack_ = -1; }

  /// After an undo: what was a new link may be another soon.
  void forget_links() noexcept { seen_links_ = listed_links_ = kUnseen; }

 private:
  static constexpr double kLeastShare = 1e-3;

  struct Body {
    std::shared_ptr<const LiveSurface> surface;
    std::uint64_t seen_version = 0, listed_version = 0;
    std::vector<std::uint8_t> is_candidate;  // [slot_count]
    std::vector<Index> candidates;           // slots
  };

  [[nodiscard]] static double touched_share(const NearVertex& near, double reach);
  void scan(const Solver& solver, const Electrode& electrode, ScenePositions& positions);
  void add_changed_slots(Body& body);
  void find_on(const Body& body, const Electrode& electrode, double reach,
               std::span<const Eigen::Vector3f> positions);
  void find_links(const Solver& solver, const Electrode& electrode,
                  std::span<const Eigen::Vector3f> positions);
  void collect_vertices(const Solver& solver);

  double radius_;
  std::vector<Body> bodies_;
  std::vector<Index> candidate_links_;
  static constexpr std::size_t kUnseen = ~std::size_t{0};
  std::size_t seen_links_ = 0;
  Electrode scanned_{};              // where it was then
  double slack_ = -1;                // m that electrode and tissue may still move
  std::vector<Index> all_vertices_;  // of surfaces and links, as they were listed
  std::size_t listed_links_ = kUnseen;

  NearestPoint nearest_{};
  double area_ = 0;
  std::vector<NearVertex> near_;
  std::vector<TouchedLink> links_;

  // scratch
  std::vector<Index> vertices_;
  std::vector<std::uint32_t> seen_;  // [vertex_count] round in which it was met
  std::uint32_t round_ = 0;
  std::vector<double> vertex_areas_;  // [vertex_count] m^2, of what was met
  std::vector<Index> close_;          // slots
  std::vector<SlotRange> ranges_;
};

}  // namespace pbdsurg
