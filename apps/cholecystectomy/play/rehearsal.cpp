// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/rehearsal.h"

#include <algorithm>
#include <vector>

namespace cholecystectomy {
namespace {

using Eigen::Vector3f;
using pbdsurg::Waypoint;

std::vector<Vector3f> positions_of(const SurgicalScene& scene, Organ organ) {
  const pbdsurg::Body& body = scene.scene.bodies()[static_cast<std::size_t>(body_of(organ))];
  std::vector<Vector3f> positions;
  for (pbdsurg::Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
    positions.push_back(scene.scene.positions()[static_cast<std::size_t>(v)].cast<float>());
  }
  return positions;
}

Vector3f farthest(const std::vector<Vector3f>& positions, const Vector3f& direction) {
  return *std::ranges::max_element(positions, {},
                                   [&](const Vector3f& x) { return x.dot(direction); });
}

Vector3f nearest(const std::vector<Vector3f>& positions, const Vector3f& point) {
  return *std::ranges::min_element(positions, {},
                                   [&](const Vector3f& x) { return (x - point).squaredNorm(); });
}

Vector3f centre(const std::vector<Vector3f>& positions) {
  Vector3f sum = Vector3f::Zero();
  for (const Vector3f& x : positions) {
    sum += x / static_cast<float>(positions.size());
  }
  return sum;
}

}  // namespace

Rehearsal make_rehearsal(const SurgicalScene& scene, const std::array<Vector3f, 2>& tips) {
  Rehearsal rehearsal{};

  // force is let in while nothing is touched, which takes a second
  const Vector3f fundus = farthest(positions_of(scene, Organ::gallbladder), Vector3f(-1, 0, -0.7F));
  const Vector3f pulled = fundus + Vector3f(-0.014F, -0.004F, -0.016F);
  rehearsal.hands[0] = {{.time = 0, .tip = tips[0]},
                        {.time = 1.5, .tip = tips[0]},
                        {.time = 2.5, .tip = fundus},
                        {.time = 2.7, .tip = fundus},
                        {.time = 2.9, .tip = fundus, .jaw = 0},
                        {.time = 3.2, .tip = fundus, .jaw = 0},
                        {.time = 4.2, .tip = pulled, .jaw = 0},
                        {.time = 4.7, .tip = pulled, .jaw = 0},
                        {.time = 4.75, .tip = pulled},
                        {.time = 5.2, .tip = pulled},
                        {.time = 5.7, .tip = tips[0]}};

  // the side of Calot's fat that faces the scope
  const std::vector<Vector3f> fat = positions_of(scene, Organ::calot_fat);
  const Vector3f facing = nearest(fat, centre(fat) + Vector3f(-0.004F, -0.03F, -0.03F));
  const Vector3f outwards = Vector3f(0, -0.7F, -0.7F);  // to the scope
  const Vector3f along(0.005F, 0.001F, 0);
  const auto at = [&](float way, float depth) -> Vector3f {
    return facing + way * along - depth * outwards;
  };
  constexpr pbdsurg::Pedals kCoagulate{.coagulation = true}, kCut{.cut = true};
  rehearsal.hands[1] = {{.time = 0, .tip = tips[1]},
                        {.time = 5.8, .tip = tips[1]},
                        {.time = 6.6, .tip = at(0, -0.01F)},
                        {.time = 7, .tip = at(0, 0.002F)},
                        {.time = 7.3, .tip = at(0, 0.002F), .pedals = kCoagulate},
                        {.time = 8.3, .tip = at(1, 0.002F), .pedals = kCoagulate},
                        {.time = 9.3, .tip = at(0, 0.002F)},
                        {.time = 9.8, .tip = at(0, -0.01F)},
                        {.time = 10.3, .tip = at(-0.6F, -0.004F)},
                        {.time = 10.6, .tip = at(-0.6F, 0.003F)},
                        {.time = 10.8, .tip = at(-0.6F, 0.003F), .pedals = kCut},
                        {.time = 12.3, .tip = at(0.6F, 0.006F), .pedals = kCut},
                        {.time = 12.8, .tip = at(1, 0.004F)},
                        {.time = 13.3, .tip = tips[1]}};
  rehearsal.parts = {{{"drag", 0, 2.5, 5.7}, {"burn", 1, 6.6, 9.8}, {"cut", 1, 10.3, 13.3}}};
  rehearsal.length = 13.5;
  return rehearsal;
}

}  // namespace cholecystectomy
