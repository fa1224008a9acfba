// SPDX-License-Identifier: Apache-2.0
// Presses a thin probe into tissue whose mesh is coarse.
#include <cstdio>
#include <exception>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

constexpr float kTop = 10e-3F;    // m, of the tissue
constexpr float kRadius = 1e-3F;  // m, of the probe
constexpr float kDepth = 3e-3F;   // m

pbdsurg::ToolPose at(float height) {
  return pbdsurg::ToolPose(Eigen::Translation3f(1e-3F, height, 2e-3F));
}

void press(const pbdsurg::TetMesh& mesh, const char* name, const pbdsurg::ToolSurface& surface) {
  pbdsurg::World world;
  const pbdsurg::BodyId liver = world.add_body("liver", mesh, pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.y() < -0.009; });
  const pbdsurg::Capsule ball{{0, 0, 0}, {0, 0, 0}, kRadius};
  const pbdsurg::ToolId probe = world.add_tool({ball}, at(kTop + kRadius), surface);

  constexpr int kSteps = 100;
  for (int step = 1; step <= kSteps; ++step) {
    world.move(probe, at(kTop + kRadius - kDepth * static_cast<float>(step) / kSteps));
    const pbdsurg::Frame frame = world.step(5e-3);  // s
    if (!frame.ok()) {
      throw pbdsurg::Error(frame.why());
    }
  }

  std::size_t pushing = 0;
  for (const pbdsurg::ToolContact& contact : world.solver().tool_contacts(probe)) {
    pushing += contact.force.norm() > 0 ? 1 : 0;
  }
  std::printf("%s: %.1f mN by %zu contacts\n", name, 1e3F * world.force(probe).y(), pushing);
}

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 5e-3;  // m: five times the probe's radius
  const pbdsurg::TetMesh mesh =
      pbdsurg::tetrahedralize(pbdsurg::rounded_box_shape({0, 0, 0}, {0.03, 0.01, 0.03}, 2e-3),
                              options)
          .mesh;
  press(mesh, "vertices alone", {pbdsurg::ContactFeatures::vertices});
  press(mesh, "all features", {});
  press(mesh, "with friction", {.friction = 0.3F});
} catch (const std::exception& error) {
  std::fprintf(stderr, "press: %s\n", error.what());
  return 2;
}
