// SPDX-License-Identifier: Apache-2.0
// A user's project that has CUDA code of its own beside the library's.
#include <cstdio>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"

__global__ void double_values(float* values) {
  values[threadIdx.x] *= 2;
}

int main() {
  pbdsurg::Scene scene;
  scene.add_body("tet",
                 pbdsurg::TetMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}));
  pbdsurg::Solver solver(scene);
  solver.step(0.01F);
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::printf("%s, no device\n", solver.backend_name());
    return 0;
  }
  float* values = nullptr;
  float value = 21;
  if (cudaMalloc(&values, sizeof value) != cudaSuccess) {
    return 1;
  }
  cudaMemcpy(values, &value, sizeof value, cudaMemcpyHostToDevice);
  double_values<<<1, 1>>>(values);
  cudaMemcpy(&value, values, sizeof value, cudaMemcpyDeviceToHost);
  cudaFree(values);
  std::printf("%s, %g\n", solver.backend_name(), value);
  return value == 42 ? 0 : 1;
}
