// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How heat has changed the colour of the organs, followed from step to step.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/thermal/surface_map.h"

#include "simulation.h"

namespace cholecystectomy {

/// A layer over the surface of every organ that the hook may burn, by the colour rule of the
/// thermal model. Strands that heat has parted were boiled dry; their stumps cover part of the
/// surface that they hung on. An update looks at what is warm, and colours only what changed to the
/// eye. Of an undo it sees what heat says, and that events are fewer: stumps stay.
class BurnLayers {
 public:
  /// Takes over what the last step changed: to be called after every step.
  void update(const Simulation& simulation);

  /// sRGB and cover at scene vertices, those of a body in a row. @param body  [vertex_count]
  [[nodiscard]] std::span<const Eigen::Vector4f> of(const pbdsurg::Body& body) const;

  /// @param vertex  of the scene
  [[nodiscard]] const Eigen::Vector4f& at(pbdsurg::Index vertex) const { return layers_[vertex]; }

 private:
  struct OrganMap {
    const pbdsurg::LiveSurface* surface;
    pbdsurg::Index first, end;  // scene vertices
    pbdsurg::SurfaceMap map{};
    std::uint64_t seen = 0;
  };

  void add_stumps(const Simulation& simulation);
  void color(const OrganMap& organ, pbdsurg::Index vertex, pbdsurg::ColorRule rule);

  std::vector<OrganMap> maps_;
  std::vector<Eigen::Vector4f> layers_;     // [scene vertex count]
  std::vector<std::uint8_t> has_stump_;     // [scene vertex count]
  std::size_t seen_events_ = 0;             // of strands
  std::vector<pbdsurg::Index> changed_;     // what was warm after the last step
  std::vector<pbdsurg::SlotRange> ranges_;  // scratch
};

}  // namespace cholecystectomy
