// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The skin of a body, for who draws or touches it.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/views/change_log.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

class HeatField;

/// Triangles, positions, normals and burn marks of a body, which follow every step and edit by
/// themselves. A sheet has each triangle twice, once a side. World::surface() gives it. Of
/// replicas, the first. It has the vertices of its body, inner and dead ones included, in ascending
/// order of their ids: a renderer sends positions() and triangles() as they are. All spans are
/// valid until the next step or edit of the world.
class PBDSURG_API Surface {
 public:
  /// World::surface() makes these.
  /// @param body  of the solver's tissue
  Surface(const Solver& solver, BodyId body);
  ~Surface();
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  /// [vertex_count] ids in the tissue
  [[nodiscard]] std::span<const Index> vertices() const noexcept { return vertices_; }

  /// [slot_count] corners in vertices(), wound outwards; the same corner thrice where a slot is
  /// empty. A triangle keeps its slot.
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept { return triangles_; }

  /// Grows with every slot that changes. Above zero.
  [[nodiscard]] std::uint64_t version() const noexcept;

  /// Which slots a reader has to copy that has seen a version, as LiveSurface::collect_changes().
  void collect_changes(std::uint64_t since, std::vector<SlotRange>& ranges) const;

  /// [vertex_count] m
  [[nodiscard]] std::span<const Eigen::Vector3f> positions() const noexcept { return positions_; }

  /// [vertex_count] m, at rest: where a texture sticks
  [[nodiscard]] std::span<const Eigen::Vector3f> rest_positions() const noexcept { return rest_; }

  /// [vertex_count] unit, outwards, of a sheet those of the front: of the triangles around, by
  /// area; zero off the surface. Cost: O(triangles) at the first call after a step.
  [[nodiscard]] std::span<const Eigen::Vector3f> normals() const;

  /// [vertex_count] degrees Celsius; empty where nothing burns the body, as are the next two.
  [[nodiscard]] std::span<const float> temperatures() const noexcept { return temperatures_; }

  /// [vertex_count] the highest so far, degrees Celsius, of vertices that a triangle has: with
  /// marks() what burn_layer() takes.
  [[nodiscard]] std::span<const float> peak_temperatures() const noexcept { return peaks_; }
  /// [vertex_count] what heat left to see, of vertices that a triangle has.
  [[nodiscard]] std::span<const BurnBytes> marks() const noexcept { return marks_; }

  /// Grows with every vertex whose marks or peak temperature change. Above zero.
  [[nodiscard]] std::uint64_t marks_version() const noexcept { return mark_changes_.version(); }

  /// Which vertices, as places in vertices(), a reader of marks() has to copy that has seen a
  /// marks_version(), as LiveSurface::collect_changes().
  void collect_mark_changes(std::uint64_t since, std::vector<SlotRange>& ranges) const {
    mark_changes_.collect(since, static_cast<Index>(marks_.size()), ranges);
  }

  /// Takes over what a step or an edit changed. The world does this. Cost: O(vertices).
  /// @param solver  of the tissue that the surface is of
  /// @param heat    null where nothing burns the body
  void refresh(const Solver& solver, const HeatField* heat);

 private:
  void number(const Tissue& tissue);
  void take_triangles();
  [[nodiscard]] Index local(Index vertex) const noexcept;

  std::shared_ptr<const LiveSurface> live_;
  Index seen_count_ = 0;  // of the tissue's vertices
  int seen_renumberings_ = 0;
  std::uint64_t seen_slots_ = 0;
  std::vector<Index> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::Vector3f> positions_, rest_;
  mutable std::vector<Eigen::Vector3f> normals_;
  mutable bool has_normals_ = false;
  SurfaceMap map_;
  std::vector<Index> warm_;  // before the last refresh
  std::vector<float> temperatures_, peaks_;
  std::vector<BurnBytes> marks_;
  ChangeLog mark_changes_;         // of marks_ and peaks_
  std::vector<SlotRange> ranges_;  // scratch
};

}  // namespace pbdsurg
