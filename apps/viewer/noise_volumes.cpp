// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/noise_volumes.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "pbdsurg/base/random.h"

namespace cholecystectomy {
namespace {

constexpr std::uint64_t kGradientSeed = 1;
constexpr std::uint64_t kCellSeed = 3;

/// Cell of a lattice that repeats after a number of cells along each side.
std::size_t cell_index(int x, int y, int z, int period = kNoiseCells) {
  const auto wrap = [period](int i) { return static_cast<std::size_t>((i + period) % period); };
  const std::size_t side = static_cast<std::size_t>(period);
  return (wrap(z) * side + wrap(y)) * side + wrap(x);
}

/// One vector per cell of a lattice, each component in [-1, 1).
std::vector<Eigen::Vector3f> random_vectors(std::uint64_t seed, int period) {
  std::vector<Eigen::Vector3f> vectors(static_cast<std::size_t>(period * period * period));
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      vectors[i][axis] = static_cast<float>(
          2 * pbdsurg::random_unit(seed, i, static_cast<std::uint64_t>(axis)) - 1);
    }
  }
  return vectors;
}

/// Perlin's noise over a lattice that repeats.
class Octave {
 public:
  Octave(std::uint64_t seed, int period)
      : period_(period), gradients_(random_vectors(seed, period)) {}

  /// @param place  in volumes, [0, 1)
  [[nodiscard]] float operator()(const Eigen::Vector3f& place) const {
    const Eigen::Vector3f p = static_cast<float>(period_) * place;
    const Eigen::Vector3i base = p.cast<int>();
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3i node =
          base + Eigen::Vector3i(corner & 1, (corner >> 1) & 1, corner >> 2);
      const Eigen::Vector3f offset = p - node.cast<float>();
      float weight = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const float t = 1 - std::abs(offset[axis]);
        weight *= t * t * t * (t * (t * 6 - 15) + 10);
      }
      sum += weight * gradients_[cell_index(node.x(), node.y(), node.z(), period_)].dot(offset);
    }
    return sum;
  }

 private:
  int period_;
  std::vector<Eigen::Vector3f> gradients_;
};

/// Fills a volume from a function of the texel that returns four numbers in [-1, 1].
template <class Function>
std::vector<std::uint8_t> fill(const Function& function) {
  std::vector<std::uint8_t> texels;
  texels.reserve(4 * static_cast<std::size_t>(kNoiseSize) * kNoiseSize * kNoiseSize);
  for (int z = 0; z < kNoiseSize; ++z) {
    for (int y = 0; y < kNoiseSize; ++y) {
      for (int x = 0; x < kNoiseSize; ++x) {
        const Eigen::Vector4f value = function(x, y, z);
        for (int i = 0; i < 4; ++i) {
          texels.push_back(static_cast<std::uint8_t>(
              std::lround(127.5f + 127.5f * std::clamp(value[i], -1.0f, 1.0f))));
        }
      }
    }
  }
  return texels;
}

Eigen::Vector3f vector_of(int x, int y, int z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

}  // namespace

std::vector<std::uint8_t> make_gradient_noise() {
  const Octave broad(kGradientSeed, kNoiseCells);
  const Octave fine(kGradientSeed + 1, 2 * kNoiseCells);
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(kNoiseSize) * kNoiseSize * kNoiseSize);
  for (int z = 0; z < kNoiseSize; ++z) {
    for (int y = 0; y < kNoiseSize; ++y) {
      for (int x = 0; x < kNoiseSize; ++x) {
        const Eigen::Vector3f place = vector_of(x, y, z) / kNoiseSize;
        heights.push_back(broad(place) + 0.5f * fine(place));
      }
    }
  }
  const auto height = [&](int x, int y, int z) { return heights[cell_index(x, y, z, kNoiseSize)]; };
  // per cell; halved, so that all but the steepest slopes fit
  constexpr float kSlope = 0.5f * kNoiseSize / (2 * kNoiseCells);
  return fill([&](int x, int y, int z) -> Eigen::Vector4f {
    return {kSlope * (height(x + 1, y, z) - height(x - 1, y, z)),
            kSlope * (height(x, y + 1, z) - height(x, y - 1, z)),
            kSlope * (height(x, y, z + 1) - height(x, y, z - 1)), 1.4f * height(x, y, z)};
  });
}

std::vector<std::uint8_t> make_cell_noise() {
  const std::vector<Eigen::Vector3f> seeds = random_vectors(kCellSeed, kNoiseCells);
  return fill([&](int texel_x, int texel_y, int texel_z) -> Eigen::Vector4f {
    const Eigen::Vector3f p =
        static_cast<float>(kNoiseCells) / kNoiseSize * vector_of(texel_x, texel_y, texel_z);
    const Eigen::Vector3i base = p.cast<int>();
    Eigen::Vector3f nearest = Eigen::Vector3f::Constant(8);
    float second = 8;
    for (int z = base[2] - 1; z <= base[2] + 1; ++z) {
      for (int y = base[1] - 1; y <= base[1] + 1; ++y) {
        for (int x = base[0] - 1; x <= base[0] + 1; ++x) {
          const Eigen::Vector3f seed = vector_of(x, y, z) + Eigen::Vector3f::Constant(0.5f) +
                                       0.42f * seeds[cell_index(x, y, z)];
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
