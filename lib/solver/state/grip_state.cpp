// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/grip_state.h"

#include <algorithm>
#include <cmath>

namespace pbdsurg {
namespace {

constexpr float kLeastWidth = 0.25F;  // of the pad's

}  // namespace

void ToolGrip::find_corners() {
  corners.clear();
  const float share = 1 / static_cast<float>(points.size());
  for (const GripPoint& point : points) {
    for (int k = 0; k < corner_count(point.at); ++k) {
      corners.push_back({point.at.vertices[k], share * point.at.weights[k]});
    }
  }
  std::ranges::sort(corners);  // by shares, too: sums do not hang on the order of points
  auto last = corners.begin();
  for (auto next = corners.begin(); next != corners.end(); ++next) {
    if (next == last) {
      continue;
    }
    if (next->vertex == last->vertex) {
      last->share += next->share;
    } else {
      *++last = *next;
    }
  }
  corners.erase(last == corners.end() ? last : last + 1, corners.end());
}

void ToolGrip::let_go(GripState why) {
  state = why;
  let_go_now = true;
  points.clear();
  corners.clear();
  jaws.fill(kInvalidIndex);
}

float ToolGrip::width_across(const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f across = limits.pad.normal.cross(direction).stableNormalized();
  float low = 0, high = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float place = across.dot(points[i].anchor);
    low = i == 0 ? place : std::min(low, place);
    high = i == 0 ? place : std::max(high, place);
  }
  return std::max(high - low, kLeastWidth * 2 * limits.pad.half_width);  // of a single row, say
}

std::size_t ToolGrip::memory_bytes() const noexcept {
  return points.capacity() * sizeof(GripPoint) + corners.capacity() * sizeof(GripCorner) +
         torn.capacity() * sizeof(Index);
}

int corner_count(const TissuePoint& point) noexcept {
  const auto end = std::ranges::find(point.vertices, kInvalidIndex);
  return static_cast<int>(end - point.vertices.begin());
}

bool is_on_tissue(const Tissue& tissue, const TissuePoint& point) {
  const Index first = point.vertices[0];
  const int count = corner_count(point);
  const auto has_all = [&](const auto& cell) {
    return std::all_of(point.vertices.begin(), point.vertices.begin() + count,
                       [&](Index v) { return std::ranges::find(cell, v) != cell.end(); });
  };
  return count == 1 ? tissue.has_tissue(first)
                    : std::ranges::any_of(tissue.tets_at(first),
                                          [&](Index tet) { return has_all(tissue.tets()[tet]); }) ||
                          std::ranges::any_of(tissue.triangles_at(first), [&](Index triangle) {
                            return has_all(tissue.triangles()[triangle]);
                          });
}

bool is_on_pad(const JawPad& pad, const Eigen::Vector3f& place) {
  const Eigen::Vector3f from_center = place - pad.center;
  return std::abs(from_center.dot(pad.along)) <= pad.half_length &&
         std::abs(from_center.dot(pad.normal.cross(pad.along))) <= pad.half_width;
}

}  // namespace pbdsurg
