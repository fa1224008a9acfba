// SPDX-License-Identifier: Apache-2.0
#include "bench/edits/blade.h"

#include <algorithm>
#include <array>

namespace pbdsurg::bench {
namespace {

constexpr float kTetsPerFrame = 20;

// 1/2, 1/4, 3/4, 1/8, 5/8 ...: each far from those before.
float spread(int i) {
  float value = 0;
  float digit = 0.5F;
  for (int rest = i + 1; rest > 0; rest /= 2, digit /= 2) {
    value += digit * static_cast<float>(rest % 2);
  }
  return value;
}

}  // namespace

Blade::Blade(const TetMesh& mesh, std::span<const Eigen::Vector3f> positions) {
  for (const Eigen::Vector3f& x : positions) {
    box_.extend(x);
  }
  for (const Tet& tet : mesh.tets()) {
    const auto height = [&](Index v) { return positions[v].y(); };
    const auto [least, most] = std::ranges::minmax(tet, {}, height);
    tet_extents_.push_back({height(least), height(most)});
  }
  front_ = box_.max().x();
}

void Blade::begin_pass() {
  height_ = box_.min().y() + spread(pass_++) * box_.sizes().y();
  const auto crossed = std::ranges::count_if(tet_extents_, [&](const std::array<float, 2>& extent) {
    return extent[0] < height_ && height_ < extent[1];
  });
  front_ = box_.min().x();
  speed_ = box_.sizes().x() * std::min(1.0F, kTetsPerFrame / static_cast<float>(crossed));
}

Blade::Way Blade::next() {
  const bool begins = front_ >= box_.max().x();
  if (begins) {
    begin_pass();
  }
  const auto edge = [&](float x) {
    const float reach = box_.sizes().z();
    return BladeEdge{{x, height_, box_.min().z() - reach}, {x, height_, box_.max().z() + reach}};
  };
  const BladeEdge before = edge(front_);
  front_ += speed_;
  return {sweep_blade(std::array{before, edge(front_)}), begins};
}

}  // namespace pbdsurg::bench
