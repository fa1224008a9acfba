// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How heat has changed the colour of the organs.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/views/change_log.h"

#include "apps/cholecystectomy/simulation.h"

namespace cholecystectomy {

/// A layer over each vertex of the tissue, by the colour rule of the thermal model: sRGB and cover,
/// zero where nothing burns. Strands that heat has parted were boiled dry; their stumps cover part
/// of the surface that they hung on. Keeps up with a simulation at the cost of what changed.
class BurnLayers {
 public:
  /// @param simulation  kept by reference
  explicit BurnLayers(const Simulation& simulation);

  /// Takes over what changed since the last update.
  void update();

  /// [vertex_count of the tissue]
  [[nodiscard]] std::span<const Eigen::Vector4f> layers() const { return layers_; }

  /// Of the vertices of an organ's surface, as Surface::collect_mark_changes().
  [[nodiscard]] std::uint64_t version(Organ organ) const { return of(organ).changes.version(); }
  void collect_changes(Organ organ, std::uint64_t since,
                       std::vector<pbdsurg::SlotRange>& ranges) const;

 private:
  struct OfOrgan {
    pbdsurg::ChangeLog changes;    // of places in the surface's vertices
    std::uint64_t seen_marks = 0;  // of the surface
  };
  [[nodiscard]] const OfOrgan& of(Organ organ) const {
    return organs_[static_cast<std::size_t>(organ)];
  }
  void add_stump(pbdsurg::Index vertex);
  void find_layer(Organ organ, pbdsurg::Index place);

  const Simulation& simulation_;
  std::vector<Eigen::Vector4f> layers_;
  std::vector<bool> has_stump_;  // [vertex_count] where strands hung that heat has parted
  std::array<OfOrgan, pbdsurg::kOrgans.size()> organs_;
  std::size_t seen_events_ = 0;
  std::vector<pbdsurg::SlotRange> ranges_;  // scratch
};

}  // namespace cholecystectomy
