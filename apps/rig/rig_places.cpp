// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig_places.h"

#include <cstddef>

namespace rig {

pbdsurg::InstrumentMapping mapping_of(const HandDescription& hand, const RigPlaces& places,
                                      Side side) {
  const std::size_t i = static_cast<std::size_t>(side);
  pbdsurg::InstrumentMappingOptions options;
  options.held = hand.held;
  options.motion_scale = hand.motion_scale;
  options.port = places.ports[i];
  Eigen::Vector3f origin = places.tips[i];
  if (hand.held == pbdsurg::HeldPart::handle) {
    origin += options.shaft_length * (options.port - origin).normalized();
  }
  options.to_scene.linear() = places.axes;
  options.to_scene.translation() = origin;
  return pbdsurg::InstrumentMapping(options);
}

}  // namespace rig
