// SPDX-License-Identifier: Apache-2.0
// A user's program that names nothing of pbdsurg::cuda: whether its backend is there is the
// linking's to say. Without a device the backend has a reason of its own.
#include <cstdio>
#include <string>

#include "pbdsurg/core/error.h"
#include "pbdsurg/solver/solver.h"

int main() {
  pbdsurg::Scene scene;
  const pbdsurg::TetMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  scene.add_body("tet", mesh);
  bool is_linked = true;
  try {
    const pbdsurg::Solver solver(scene, {.backend = pbdsurg::BackendKind::cuda});
    std::printf("%s\n", solver.backend_name());
  } catch (const pbdsurg::BackendUnavailable& error) {
    std::printf("%s\n", error.what());
    is_linked = std::string(error.what()).find("not linked") == std::string::npos;
  }
  std::printf("automatic: %s\n", pbdsurg::Solver(scene).backend_name());
  return is_linked == CONSUMER_HAS_CUDA_BACKEND ? 0 : 1;
}
