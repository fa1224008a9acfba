// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/places.h"

namespace cholecystectomy {

rig::RigPlaces hand_places() {
  rig::RigPlaces places;
  places.ports = {Eigen::Vector3f(-0.09F, -0.10F, -0.15F), Eigen::Vector3f(0.16F, -0.10F, -0.15F)};
  places.tips = {Eigen::Vector3f(-0.005F, -0.035F, -0.03F),
                 Eigen::Vector3f(0.075F, -0.035F, -0.03F)};
  const Camera camera = first_scope().camera();
  const Eigen::Vector3f back = (camera.eye - camera.target).normalized();
  const Eigen::Vector3f right = camera.up.cross(back).normalized();
  places.axes << right, back.cross(right), back;
  return places;
}

Reach reach_of(rig::Side side) {
  return {hand_places().ports[static_cast<std::size_t>(side)], kCentre, kReach};
}

Scope first_scope() {
  ScopeOptions options;
  options.working_distance = 0.13F;
  options.least_insertion = 0.06F;  // with this tilt, the lens stays inside of the abdominal wall
  options.widest_tilt = 0.8F;
  return Scope::looking_at({0.003F, -0.192F, -0.138F}, {0.035F, 0, 0.003F}, options);
}

}  // namespace cholecystectomy
