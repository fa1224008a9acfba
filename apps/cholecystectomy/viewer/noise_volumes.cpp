// SPDX-License-Identifier: Apache-2.0
#include "viewer/noise_volumes.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "pbdsurg/core/random.h"

namespace cholecystectomy {
namespace {

constexpr std::uint64_t kGradientSeed = 1;
constexpr std::uint64_t kCellSeed = 2;

std::size_t cell_index(int x, int y, int z) {
  const auto wrap = [](int i) { return static_cast<std::size_t>((i + kNoiseCells) % kNoiseCells); };
  return (wrap(z) * kNoiseCells + wrap(y)) * kNoiseCells + wrap(x);
}

/// One vector per cell, each component in [-1, 1).
std::vector<Eigen::Vector3f> random_vectors(std::uint64_t seed) {
  std::vector<Eigen::Vector3f> vectors(kNoiseCells * kNoiseCells * kNoiseCells);
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      vectors[i][axis] = static_cast<float>(
          2 * pbdsurg::random_unit(seed, i, static_cast<std::uint64_t>(axis)) - 1);
    }
  }
  return vectors;
}

/// Fills a volume from a function of the position in cells that returns four numbers in [-1, 1].
template <class Function>
std::vector<std::uint8_t> fill(const Function& function) {
  std::vector<std::uint8_t> texels;
  texels.reserve(4 * static_cast<std::size_t>(kNoiseSize) * kNoiseSize * kNoiseSize);
  constexpr float kStep = static_cast<float>(kNoiseCells) / kNoiseSize;
  for (int z = 0; z < kNoiseSize; ++z) {
    for (int y = 0; y < kNoiseSize; ++y) {
      for (int x = 0; x < kNoiseSize; ++x) {
        const Eigen::Vector4f value =
            function(kStep * Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y),
                                             static_cast<float>(z)));
        for (int i = 0; i < 4; ++i) {
          texels.push_back(static_cast<std::uint8_t>(
              std::lround(127.5f + 127.5f * std::clamp(value[i], -1.0f, 1.0f))));
        }
      }
    }
  }
  return texels;
}

}  // namespace

std::vector<std::uint8_t> make_gradient_noise() {
  const std::vector<Eigen::Vector3f> gradients = random_vectors(kGradientSeed);
  const auto value_at = [&](const Eigen::Vector3f& p) {
    const std::array<int, 3> base{static_cast<int>(std::floor(p.x())),
                                  static_cast<int>(std::floor(p.y())),
                                  static_cast<int>(std::floor(p.z()))};
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::array<int, 3> bit{corner & 1, (corner >> 1) & 1, corner >> 2};
      Eigen::Vector3f offset;
      float weight = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t a = static_cast<std::size_t>(axis);
        offset[axis] = p[axis] - static_cast<float>(base[a] + bit[a]);
        const float t = 1 - std::abs(offset[axis]);
        weight *= t * t * t * (t * (t * 6 - 15) + 10);
      }
      sum +=
          weight *
          gradients[cell_index(base[0] + bit[0], base[1] + bit[1], base[2] + bit[2])].dot(offset);
    }
    return sum;
  };
  constexpr float kHalfStep = 0.5f * kNoiseCells / kNoiseSize;
  return fill([&](const Eigen::Vector3f& p) -> Eigen::Vector4f {
    Eigen::Vector4f texel;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f step = kHalfStep * Eigen::Vector3f::Unit(axis);
      // shifted by one period, so that the cell of a position is never negative
      const Eigen::Vector3f shifted = p + Eigen::Vector3f::Constant(kNoiseCells);
      texel[axis] = (value_at(shifted + step) - value_at(shifted - step)) / (2 * kHalfStep) / 2;
    }
    texel[3] = 1.4f * value_at(p);
    return texel;
  });
}

std::vector<std::uint8_t> make_cell_noise() {
  const std::vector<Eigen::Vector3f> seeds = random_vectors(kCellSeed);
  return fill([&](const Eigen::Vector3f& p) -> Eigen::Vector4f {
    const std::array<int, 3> base{static_cast<int>(p.x()), static_cast<int>(p.y()),
                                  static_cast<int>(p.z())};
    Eigen::Vector3f nearest = Eigen::Vector3f::Constant(8);
    float second = 8;
    for (int z = base[2] - 1; z <= base[2] + 1; ++z) {
      for (int y = base[1] - 1; y <= base[1] + 1; ++y) {
        for (int x = base[0] - 1; x <= base[0] + 1; ++x) {
          const Eigen::Vector3f corner(static_cast<float>(x), static_cast<float>(y),
                                       static_cast<float>(z));
          const Eigen::Vector3f seed =
              corner + Eigen::Vector3f::Constant(0.5f) + 0.42f * seeds[cell_index(x, y, z)];
          const Eigen::Vector3f offset = p - seed;
          if (offset.norm() < nearest.norm()) {
            second = nearest.norm();
            nearest = offset;
          } else {
            second = std::min(second, offset.norm());
          }
        }
      }
    }
    return {nearest.x(), nearest.y(), nearest.z(), 2 * (second - nearest.norm()) - 1};
  });
}

}  // namespace cholecystectomy
