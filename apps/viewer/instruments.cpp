// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/instruments.h"

namespace cholecystectomy {
namespace {

ToolPart rod(const Eigen::Isometry3f& pose, const std::vector<Eigen::Vector3f>& points,
             float radius, ToolFinish finish) {
  ToolPart part;
  for (const Eigen::Vector3f& p : points) {
    part.points.push_back(pose * p);
    part.radii.push_back(radius);
  }
  part.finish = finish;
  return part;
}

}  // namespace

Tool draw_hook(const Eigen::Isometry3f& pose) {
  return {
      "hook",
      {rod(pose, {{0, 0, 0}, {0.003F, 0, 0.001F}, {0.003F, 0, 0.014F}}, 0.0006F, ToolFinish::steel),
       rod(pose, {{0.003F, 0, 0.012F}, {0.003F, 0, 0.25F}}, 0.0025F, ToolFinish::insulation)}};
}

Tool draw_grasper(const Eigen::Isometry3f& pose, bool is_closed) {
  Tool tool{"grasper", {}};
  const float gap = is_closed ? 0.0012F : 0.004F;
  for (const float side : {-1.0F, 1.0F}) {
    tool.parts.push_back(
        rod(pose, {{0, side * gap * 0.6F, -0.003F}, {0, side * gap, 0.006F}, {0, 0, 0.018F}},
            0.0013F, ToolFinish::steel));
  }
  tool.parts.push_back(rod(pose, {{0, 0, 0.018F}, {0, 0, 0.25F}}, 0.0025F, ToolFinish::insulation));
  return tool;
}

}  // namespace cholecystectomy
