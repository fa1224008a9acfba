// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/between_jaws.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pbdsurg/views/live_surface.h"

#include "lib/base/check.h"
#include "lib/solver/grip_checks.h"

namespace pbdsurg {
namespace {

// Where a jaw meets tissue.
struct Meeting {
  Eigen::Vector3f place{0, 0, 0};  // m, along and across the pad, and above it
  TissuePoint point;
  bool exists = false;
};

// The places of a pad.
class PadGrid {
 public:
  PadGrid(const JawPad& pad, float spacing)
      : pad_(pad),
        counts_{count(pad.half_length, spacing), count(pad.half_width, spacing)},
        upper_(static_cast<std::size_t>(counts_[0]) * counts_[1]),
        lower_(upper_.size()) {}

  // @param x  m, in the tool's frame
  [[nodiscard]] Eigen::Vector3f on_pad(const Eigen::Vector3f& x) const {
    const Eigen::Vector3f from_center = x - pad_.center;
    return {from_center.dot(pad_.along), from_center.dot(pad_.normal.cross(pad_.along)),
            from_center.dot(pad_.normal)};
  }

  // @param corners  m, see on_pad()
  // @param reach    m, of each jaw above and below the pad
  void add(const Triangle& triangle, const std::array<Eigen::Vector3f, 3>& corners, float reach) {
    const Eigen::Vector3f low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Eigen::Vector3f high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    if (low.z() > reach || high.z() < -reach) {
      return;
    }
    Eigen::Matrix2f sides;
    sides << (corners[1] - corners[0]).head<2>(), (corners[2] - corners[0]).head<2>();
    if (!(std::abs(sides.determinant()) > 0)) {
      return;  // seen from its edge
    }
    const Eigen::Matrix2f to_weights = sides.inverse();
    for (int i = first(0, low.x()); i < last(0, high.x()); ++i) {
      for (int j = first(1, low.y()); j < last(1, high.y()); ++j) {
        const Eigen::Vector2f place(place_of(0, i), place_of(1, j));
        const Eigen::Vector2f weights = to_weights * (place - corners[0].head<2>());
        const std::array<float, 3> all{1 - weights.sum(), weights.x(), weights.y()};
        const float height =
            all[0] * corners[0].z() + all[1] * corners[1].z() + all[2] * corners[2].z();
        if (std::ranges::min(all) >= 0 && std::abs(height) <= reach) {
          const Meeting met{{place.x(), place.y(), height}, {triangle, all}, true};
          const auto at = static_cast<std::size_t>(i) * counts_[1] + j;
          take(met, upper_[at], 1);
          take(met, lower_[at], -1);
        }
      }
    }
  }

  // Of the upper jaw, then of the lower one.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const auto* const side : {&upper_, &lower_}) {
      for (const Meeting& met : *side) {
        if (met.exists) {
          visit(met);
        }
      }
    }
  }

 private:
  static int count(float half, float spacing) {
    constexpr float kMost = 1000;
    return static_cast<int>(std::clamp(std::ceil(2 * half / spacing), 1.0F, kMost));
  }
  static void take(const Meeting& met, Meeting& first, float side) {
    if (!first.exists || side * met.place.z() > side * first.place.z()) {
      first = met;
    }
  }

  [[nodiscard]] float half(int axis) const {
    return axis == 0 ? pad_.half_length : pad_.half_width;
  }
  [[nodiscard]] float step(int axis) const {
    return 2 * half(axis) / static_cast<float>(counts_[axis]);
  }
  [[nodiscard]] float place_of(int axis, int i) const {
    return (static_cast<float>(i) + 0.5F) * step(axis) - half(axis);
  }
  // Places from `first` to before `last` are all between two coordinates, and a few more.
  [[nodiscard]] int first(int axis, float low) const {
    const float cell = std::floor((low + half(axis)) / step(axis)) - 1;
    return static_cast<int>(std::clamp(cell, 0.0F, static_cast<float>(counts_[axis])));
  }
  [[nodiscard]] int last(int axis, float high) const {
    const float cell = std::ceil((high + half(axis)) / step(axis)) + 1;
    return static_cast<int>(std::clamp(cell, 0.0F, static_cast<float>(counts_[axis])));
  }

  const JawPad& pad_;
  std::array<int, 2> counts_;
  std::vector<Meeting> upper_, lower_;  // [place along the jaws][across them]
};

}  // namespace

std::vector<TissuePoint> find_points_between(const Solver& solver, Index body, ToolId tool,
                                             const JawPad& pad, float opening, float spacing,
                                             Index copy) {
  check_pad(pad);
  check_positive("the jaws' opening", opening, " m");
  check_positive("the spacing of points", spacing, " m");
  const ToolPose to_tool = solver.tool_pose(tool, copy).inverse();
  const LiveSurface surface(solver.tissue(), body);
  const std::vector<Eigen::Vector3f> positions = solver.positions(copy);
  PadGrid grid(pad, spacing);
  for (const Triangle& triangle : surface.triangles()) {
    std::array<Eigen::Vector3f, 3> corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      corners[k] = grid.on_pad(to_tool * positions[triangle[k]]);
    }
    grid.add(triangle, corners, opening / 2);
  }
  std::vector<TissuePoint> points;
  std::vector<Eigen::Vector3f> places;
  grid.for_each([&](const Meeting& met) {
    points.push_back(met.point);
    places.push_back(met.place);
  });
  return can_be_held(places) ? points : std::vector<TissuePoint>{};
}

}  // namespace pbdsurg
