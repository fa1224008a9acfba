// SPDX-License-Identifier: Apache-2.0
// A user's program that takes a GPU where there is one, if it links pbdsurg::cuda.
#include <cstdio>

#include "pbdsurg/solver/solver.h"
#if CONSUMER_HAS_CUDA
#include "pbdsurg/cuda/device.h"
#endif

int main() {
  pbdsurg::Scene scene;
  const pbdsurg::TetMesh mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
  scene.add_body("tet", mesh);
#if CONSUMER_HAS_CUDA
  const pbdsurg::Executor executor = pbdsurg::cuda::best();
  if (pbdsurg::cuda::find_devices().devices.empty()) {
    try {
      static_cast<void>(pbdsurg::cuda::device());
      return 1;
    } catch (const pbdsurg::BackendUnavailable& error) {
      std::printf("%s\n", error.what());
    }
  }
#else
  const pbdsurg::Executor executor = pbdsurg::executor::threads();
#endif
  pbdsurg::Solver solver(scene, {.executor = executor});
  solver.step(1e-3F);
  std::printf("%s: %s\n", executor.name().c_str(), solver.backend_name());
}
