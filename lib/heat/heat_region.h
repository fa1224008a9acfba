// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The warm part of a thermal mesh, and the linear system of conduction in it.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"

#include "lib/heat/device_system.h"
#include "lib/heat/local_system.h"

namespace pbdsurg {

/// Some vertices of a mesh, ascending: the rows of a system. Elements conduct whose corners are
/// all among them, so the rim is insulated. Two regions of the same vertices and living tissue are
/// the same to the bit on the CPU, however they came to be; a device sums what has gone, too, in
/// another order, and takes no region with triangles.
class HeatRegion {
 public:
  /// @param device_rows  from which a device solves, where the executor is one
  HeatRegion(const Executor& executor, Index device_rows)
      : system_(executor), device_(executor, device_rows) {}

  [[nodiscard]] std::span<const Index> vertices() const noexcept { return vertices_; }

  /// The row of a vertex, kInvalidIndex outside.
  [[nodiscard]] Index row(Index vertex) const {
    return vertex < static_cast<Index>(rows_.size()) ? rows_[vertex] : kInvalidIndex;
  }

  // of a row, valid after update()

  /// Whether all neighbours are in the region, too.
  [[nodiscard]] bool is_inner(Index row) const { return inner_[row] != 0; }
  [[nodiscard]] double mass(Index row) const { return masses_[row]; }       ///< kg
  [[nodiscard]] double surface(Index row) const { return surfaces_[row]; }  ///< m^2, if asked for
  [[nodiscard]] LocalSystem& system() noexcept { return system_; }          ///< couplings in W/K
  [[nodiscard]] const LocalSystem& system() const noexcept { return system_; }

  /// Adds seeds and some rings of neighbours around them. Cost: O(added + region log region).
  void add(const ThermalMesh& mesh, std::span<const Index> seeds, int rings);

  /// Drops all vertices. Those that an undo did away with must be dropped before the next use.
  void clear();
  void drop_from(Index first_vertex);

  /// Goes along with a compaction.
  /// @param vertices      old to new  @param vertex_count  of the mesh from now on
  void renumber(const std::vector<Index>& vertices, Index vertex_count);

  /// Tells that elements in the region may have changed.
  void mark_changed() noexcept;

  /// Tells that elements have gone that had all their corners among some vertices, and nothing
  /// else has changed.
  void mark_gone(std::span<const Index> vertices);

  /// Makes rows and system anew if anything has changed. Cost: O(region) then; O(gone) where
  /// elements went and nothing else.
  /// @param needs_surfaces  the same in every call
  void update(const ThermalMesh& mesh, bool needs_surfaces);

  /// Conductances at temperatures, where any tissue's depend on them; to be told again after
  /// update(). Cost: O(region), and nothing where none does.
  /// @param temperatures  [row_count] degrees Celsius
  void set_temperatures(const ThermalMesh& mesh, std::span<const double> temperatures);

  /// Takes a system on a device over from another of the same field, which needs it no more.
  void take_device(HeatRegion& other) noexcept;

  struct Solution {
    LinearSolveReport report;
    bool is_on_device;
  };

  /// Solves the system with `added` on its diagonal, as LocalSystem.
  /// @throws Error  if a device fails; then x is what it was
  Solution solve(std::span<const double> added, std::span<const double> b, std::span<double> x,
                 const LinearSolveOptions& options);

 private:
  // A copy knows no rows yet.
  struct Device {
    Device(const Executor& executor, Index rows) : choice(executor, rows) {}
    Device(const Device& other) : choice(other.choice) {}
    Device& operator=(const Device&) = delete;

    DeviceChoice choice;
    bool has_old_rows = true;  // or none
    bool has_old_conductances = true;
    bool takes_rows = false;
  };

  template <class OnElement>
  void measure(const ThermalMesh& mesh, Index row, bool needs_surfaces,
               const OnElement& on_element);
  void lay_out(const ThermalMesh& mesh, bool needs_surfaces);
  void drop_gone(const ThermalMesh& mesh, bool needs_surfaces);
  [[nodiscard]] DeviceSystem* move_to_device();

  LocalSystem system_;
  Device device_;
  std::vector<Index> vertices_;  // ascending
  std::vector<Index> rows_;      // [vertices of the mesh]
  bool has_changed_ = false;
  std::vector<Index> gone_at_;                       // vertices
  std::vector<std::uint8_t> inner_;                  // [row_count]
  std::vector<double> masses_, surfaces_;            // [row_count]
  std::vector<Index> element_starts_;                // [row_count + 1]
  std::vector<Index> elements_;                      // by the smallest row, then as at its vertex
  std::vector<Tet> corners_;                         // [elements_] rows, as LocalSystem has them
  std::vector<std::array<double, 6>> conductances_;  // [elements_] W/K
  bool has_triangles_ = false;
  // scratch
  std::vector<Index> gone_rows_;
  std::vector<Index> front_, next_front_;
  std::vector<std::uint32_t> seen_at_;  // [vertices of the mesh] the search that saw it last
  std::uint32_t search_ = 0;
};

}  // namespace pbdsurg
