// SPDX-License-Identifier: Apache-2.0
// Lays a piece of fat on a block of liver, and reads what weighs on the liver.
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

pbdsurg::TetMesh fill(const pbdsurg::ImplicitShape& shape) {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 5e-3;  // m
  return pbdsurg::tetrahedralize(shape, options).mesh;
}

}  // namespace

int main() try {
  pbdsurg::World world;  // gravity is earth's, downwards along y
  const pbdsurg::BodyId liver = world.add_body(
      "liver", fill(pbdsurg::rounded_box_shape({0, -0.01, 0}, {0.03, 0.01, 0.03}, 2e-3)),
      pbdsurg::tissues::liver());
  const pbdsurg::BodyId fat = world.add_body(
      "fat", fill(pbdsurg::rounded_box_shape({0, 0.007, 0}, {0.015, 0.005, 0.015}, 2e-3)),
      pbdsurg::tissues::fat());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.y() < -0.018; });

  world.set_contact(liver, fat, {.thickness = 0.5e-3F, .friction = 0.1F});  // m
  for (int step = 0; step < 200; ++step) {
    const pbdsurg::Frame frame = world.step(5e-3);  // s
    if (!frame.ok()) {
      throw pbdsurg::Error(frame.why());
    }
  }

  float weight = 0;  // N, of forces on the second body
  for (const pbdsurg::BodyContact& contact : world.solver().body_contacts()) {
    weight += contact.first == 1 ? contact.force.y() : -contact.force.y();
  }
  double mass = 0;  // kg
  for (const pbdsurg::Index v : world.tissue().vertices_of(1)) {
    mass += world.tissue().masses()[v];
  }
  std::printf("the liver carries %.1f mN, the fat weighs %.1f mN\n", 1e3F * weight, 9.81e3 * mass);
} catch (const std::exception& error) {
  std::fprintf(stderr, "contact: %s\n", error.what());
  return 2;
}
