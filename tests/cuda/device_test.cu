// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <cstring>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/cuda/device.h"

#include "cuda/check.cuh"
#include "tests/support/catch.h"

namespace pbdsurg::cuda {
namespace {

using testing::ContainsSubstring;

constexpr int kCount = 1000;

struct Sample {
  std::uint64_t bits;
  double unit;
  Vec3<float> sum, difference, scaled;
};

/// Every operation that rounds once: these may not depend on where they run.
PBDSURG_HOST_DEVICE Sample make_sample(std::uint64_t i) {
  const auto number = [i](std::uint64_t round) {
    return static_cast<float>(random_unit(11, i, round)) - 0.5f;
  };
  const Vec3<float> a{number(1), number(2), number(3)};
  const Vec3<float> b{number(4), number(5), number(6)};
  return {random_bits(5, i, 9), random_unit(5, i, 9), a + b, a - b, number(7) * a};
}

__global__ void fill_samples(Sample* samples) {
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < kCount) {
    samples[i] = make_sample(static_cast<std::uint64_t>(i));
  }
}

std::vector<Sample> samples_from_device() {
  std::vector<Sample> samples(kCount);
  const std::size_t bytes = kCount * sizeof(Sample);
  Sample* on_device = nullptr;
  PBDSURG_CUDA_CHECK(cudaMalloc(&on_device, bytes));
  fill_samples<<<(kCount + 127) / 128, 128>>>(on_device);
  PBDSURG_CUDA_CHECK(cudaGetLastError());
  PBDSURG_CUDA_CHECK(cudaMemcpy(samples.data(), on_device, bytes, cudaMemcpyDeviceToHost));
  PBDSURG_CUDA_CHECK(cudaFree(on_device));
  return samples;
}

bool same_bits(const Vec3<float>& a, const Vec3<float>& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

TEST_CASE("cuda device: there are devices, or a reason why not", "[unit]") {
  const DeviceList list = find_devices();

  CHECK(list.devices.empty() != list.reason.empty());
  for (const DeviceInfo& device : list.devices) {
    INFO("device " << device.id);
    CHECK_FALSE(device.name.empty());
    CHECK(device.compute_major > 0);
    CHECK(device.memory > 0);
    CHECK(device.multiprocessor_count > 0);
    CHECK(device.supports_clusters == (device.compute_major >= 9));
  }
}

TEST_CASE("cuda device: a failed call is named with its reason", "[unit]") {
  CHECK_NOTHROW(check(cudaSuccess, "cudaFree(nothing)"));
  CHECK_THROWS_AS(check(cudaErrorInvalidValue, "cudaFree(nothing)"), DeviceError);
  CHECK_THROWS_WITH(
      check(cudaErrorInvalidValue, "cudaFree(nothing)"),
      ContainsSubstring("cudaFree(nothing) failed") && ContainsSubstring("cudaErrorInvalidValue"));
}

// Would catch shared maths that means one thing to nvcc's host compiler and another on the device.
TEST_CASE("cuda device: random numbers and vectors have the host's bits", "[device]") {
  const std::vector<Sample> samples = samples_from_device();

  for (int i = 0; i < kCount; ++i) {
    const Sample expected = make_sample(static_cast<std::uint64_t>(i));
    INFO("element " << i);
    REQUIRE(samples[i].bits == expected.bits);
    REQUIRE(samples[i].unit == expected.unit);
    REQUIRE(same_bits(samples[i].sum, expected.sum));
    REQUIRE(same_bits(samples[i].difference, expected.difference));
    REQUIRE(same_bits(samples[i].scaled, expected.scaled));
  }
}

// Would catch an error that is cleared too late and blamed on the next call.
TEST_CASE("cuda device: a failed call leaves the next one alone", "[device]") {
  CHECK_THROWS_AS([] { PBDSURG_CUDA_CHECK(cudaSetDevice(1 << 20)); }(), DeviceError);
  CHECK_NOTHROW([] { PBDSURG_CUDA_CHECK(cudaGetLastError()); }());
}

}  // namespace pbdsurg::cuda
