// SPDX-License-Identifier: Apache-2.0
// The maths of the constraints is written once: here it runs on a device and on the host.
#include <algorithm>
#include <cmath>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/attachment.h"
#include "pbdsurg/constraints/contact.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/fibre.h"
#include "pbdsurg/constraints/membrane.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"

#include "cuda/check.cuh"
#include "tests/support/catch.h"

namespace pbdsurg::cuda {
namespace {

constexpr int kCount = 2000;
constexpr float kEdge = 2e-3F;  // m

/// The four vertices of a tetrahedron after one projection of each constraint, in both modes.
struct Projected {
  Vec3<float> x[4];
};

PBDSURG_HOST_DEVICE Projected project_all(std::uint64_t i) {
  const auto number = [i](std::uint64_t round) {
    return static_cast<float>(random_unit(3, i, round));
  };
  Projected result{{{0, 0, 0}, {1, 0, 0}, {0.5F, 0.87F, 0}, {0.5F, 0.29F, 0.82F}}};
  float w[4];
  for (int v = 0; v < 4; ++v) {
    const Vec3<float> jitter{number(4 * v), number(4 * v + 1), number(4 * v + 2)};
    result.x[v] = kEdge * (result.x[v] + 0.4F * jitter);
    w[v] = 1e5F * (0.1F + number(4 * v + 3));
  }
  const float softness = 1e5F * number(20);
  const Substep<float> substep{1, 1};
  const float strong[] = {kEdge, 0.4F, 0};
  const float soft[] = {0.9F * kEdge, softness, 0};
  const float volume[] = {0.1F * kEdge * kEdge * kEdge, 1, 0};
  float multiplier[] = {0};
  Vec3<float> force{};
  Vec3<float> ends[2] = {result.x[0], result.x[1]};
  const float end_weights[2] = {w[0], w[1]};
  DistanceConstraint::project<ProjectionMode::fraction>(ends, end_weights, strong, substep,
                                                        multiplier);
  DistanceConstraint::project<ProjectionMode::compliance>(ends, end_weights, soft, substep,
                                                          multiplier);
  result.x[0] = ends[0];
  result.x[1] = ends[1];
  multiplier[0] = 0;
  VolumeConstraint::project<ProjectionMode::fraction>(result.x, w, volume, substep, multiplier);
  const float per_edge = 1 / kEdge;
  const float solid[] = {per_edge, 0, 0, 0, per_edge, 0, 0, 0, per_edge, 1e-6F, 5, 0};
  float stress[9] = {};
  NeoHookeanConstraint::project<ProjectionMode::compliance>(result.x, w, solid,
                                                            Substep<float>{1e3F, 1e6F}, stress);
  const float fibre[] = {0.4F * per_edge, -0.3F * per_edge, 0.9F * per_edge, 2e-6F};
  float pull[] = {0};
  FibreConstraint::project<ProjectionMode::compliance>(result.x, w, fibre,
                                                       Substep<float>{1e3F, 1e6F}, pull);
  const float sheet[] = {per_edge, 0, 0, per_edge, 1e-6F, 3, 1e-3F};
  float tension[6] = {};
  Vec3<float> corners[3] = {result.x[0], result.x[1], result.x[2]};
  const float corner_weights[3] = {w[0], w[1], w[2]};
  MembraneConstraint::project<ProjectionMode::compliance>(corners, corner_weights, sheet,
                                                          Substep<float>{1e3F, 1e6F}, tension);
  for (int v = 0; v < 3; ++v) {
    result.x[v] = corners[v];
  }
  const float limit[] = {0.8F * kEdge};
  float none[] = {0};
  ends[0] = result.x[0];
  ends[1] = result.x[1];
  StrainLimitConstraint::project<ProjectionMode::compliance>(ends, end_weights, limit, substep,
                                                             none);
  result.x[0] = ends[0];
  result.x[1] = ends[1];
  multiplier[0] = 0;
  AttachmentConstraint::project<ProjectionMode::compliance>(
      result.x[2], w[2], Vec3<float>{kEdge, kEdge, 0}, softness, force);
  ContactConstraint::project(result.x[3], w[3], Vec3<float>{0, 0.6F, 0.8F}, kEdge, multiplier[0]);
  return result;
}

__global__ void project_kernel(Projected* out) {
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < kCount) {
    out[i] = project_all(static_cast<std::uint64_t>(i));
  }
}

}  // namespace

TEST_CASE("cuda constraints: a device projects as the host does", "[device]") {
  std::vector<Projected> actual(kCount);
  Projected* on_device = nullptr;
  PBDSURG_CUDA_CHECK(cudaMalloc(&on_device, kCount * sizeof(Projected)));
  project_kernel<<<(kCount + 127) / 128, 128>>>(on_device);
  PBDSURG_CUDA_CHECK(cudaGetLastError());
  PBDSURG_CUDA_CHECK(
      cudaMemcpy(actual.data(), on_device, kCount * sizeof(Projected), cudaMemcpyDeviceToHost));
  PBDSURG_CUDA_CHECK(cudaFree(on_device));

  // nvcc may fuse multiplications and additions, so single roundings differ
  float largest = 0;
  for (int i = 0; i < kCount; ++i) {
    const Projected expected = project_all(static_cast<std::uint64_t>(i));
    for (int v = 0; v < 4; ++v) {
      const Vec3<float> d = actual[i].x[v] - expected.x[v];
      largest = std::max(largest, std::sqrt(dot(d, d)));
    }
  }
  CHECK(largest < 1e-5F * kEdge);
}

}  // namespace pbdsurg::cuda
