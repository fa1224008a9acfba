// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/palette.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pbdsurg::bench {
namespace {

constexpr int kGrid = 16;         // colours along an axis of the cube
constexpr float kDarkest = 0.5F;  // Oklab's lightness: black has no hue
constexpr float kLightnessWeight = 0.5F;

float linear_of_srgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}

Eigen::Vector3f oklab_of(const Eigen::Vector3f& srgb) {
  Eigen::Matrix3f cones, lab;
  cones << 0.4122214708F, 0.5363325363F, 0.0514459929F,  //
      0.2119034982F, 0.6806995451F, 0.1073969566F,       //
      0.0883024619F, 0.2817188376F, 0.6299787005F;
  lab << 0.2104542553F, 0.7936177850F, -0.0040720468F,  //
      1.9779984951F, -2.4285922050F, 0.4505937099F,     //
      0.0259040371F, 0.7827717662F, -0.8086757660F;
  const Eigen::Vector3f response = cones * srgb.unaryExpr(&linear_of_srgb);
  return lab * response.unaryExpr([](float value) { return std::cbrt(value); });
}

struct Candidate {
  Eigen::Vector3f srgb;
  Eigen::Vector3f place;
  float distance = std::numeric_limits<float>::infinity();  // to the nearest that is taken
};

}  // namespace

std::vector<Eigen::Vector3f> distinct_colors(int count) {
  const Eigen::Vector3f weights(kLightnessWeight, 1, 1);
  std::vector<Candidate> candidates;
  for (int i = 0; i < kGrid * kGrid * kGrid; ++i) {
    const Eigen::Vector3f srgb =
        Eigen::Vector3f(static_cast<float>(i % kGrid), static_cast<float>(i / kGrid % kGrid),
                        static_cast<float>(i / kGrid / kGrid)) /
        (kGrid - 1);
    const Eigen::Vector3f oklab = oklab_of(srgb);
    if (oklab.x() >= kDarkest) {
      candidates.push_back({srgb, oklab.cwiseProduct(weights)});
    }
  }
  std::vector<Eigen::Vector3f> colors;
  Eigen::Vector3f taken = oklab_of(Eigen::Vector3f::Ones()).cwiseProduct(weights);
  while (static_cast<int>(colors.size()) < count) {
    for (Candidate& candidate : candidates) {
      candidate.distance = std::min(candidate.distance, (candidate.place - taken).norm());
    }
    const Candidate& next = *std::max_element(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
    colors.push_back(next.srgb);
    taken = next.place;
  }
  return colors;
}

}  // namespace pbdsurg::bench
