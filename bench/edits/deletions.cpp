// SPDX-License-Identifier: Apache-2.0
#include "bench/edits/deletions.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "pbdsurg/base/random.h"

namespace pbdsurg::bench {
namespace {

constexpr std::uint64_t kSeed = 6;
constexpr double kSpeed = 5e-3;  // m/s, of a hook that dissects

Eigen::Vector3d middle_of(const TetMesh& mesh, Index tet) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Index v : mesh.tets()[tet]) {
    sum += mesh.positions()[v];
  }
  return sum / 4;
}

}  // namespace

const char* name_of(Pattern pattern) noexcept {
  return pattern == Pattern::regional ? "regional" : "scattered";
}

Index deletions_in_frame(int per_second, int frame) noexcept {
  return per_second * (frame + 1) / kFramesPerSecond - per_second * frame / kFramesPerSecond;
}

Deletions::Deletions(const TetMesh& mesh, Pattern pattern)
    : mesh_(&mesh), pattern_(pattern), left_(static_cast<std::size_t>(mesh.tet_count())) {
  std::iota(left_.begin(), left_.end(), Index{0});
  if (pattern == Pattern::scattered) {
    std::sort(left_.begin(), left_.end(),
              [](Index a, Index b) { return random_bits(kSeed, a) < random_bits(kSeed, b); });
  }
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  point_ = box.center();
  velocity_ = kSpeed * Eigen::Vector3d::UnitX();
}

std::vector<Index> Deletions::next(Index count) {
  if (pattern_ == Pattern::regional && count > 0) {
    const auto distance = [&](Index t) {
      return std::pair((middle_of(*mesh_, t) - point_).squaredNorm(), t);
    };
    std::nth_element(left_.begin(), left_.end() - count, left_.end(),
                     [&](Index a, Index b) { return distance(a) > distance(b); });
  }
  point_ += velocity_ / kFramesPerSecond;
  std::vector<Index> tets(left_.end() - count, left_.end());
  left_.resize(left_.size() - tets.size());
  return tets;
}

}  // namespace pbdsurg::bench
