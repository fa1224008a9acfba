// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cut.h"

#include <array>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/surgery/cut_planner.h"
#include "lib/surgery/cut_surface.h"

namespace pbdsurg {
namespace {

// Cosine of 150 degrees, between the normals of neighbours.
constexpr double kTurningBack = -0.866;

}  // namespace

CutSurface sweep_blade(std::span<const BladeEdge> instants) {
  CutSurface surface;
  std::array<Index, 2> last{kInvalidIndex, kInvalidIndex};  // where the ends were
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();         // of the last triangle
  for (std::size_t i = 0; i < instants.size(); ++i) {
    if (!instants[i].first.allFinite() || !instants[i].second.allFinite()) {
      throw InvalidArgument("instant " + std::to_string(i) + " of the blade is not finite");
    }
    // an end that stays where it was is one point, which keeps the surface in one piece
    const auto point_at = [&](const Eigen::Vector3f& x, Index before) {
      if (i > 0 && surface.points[before] == x) {
        return before;
      }
      surface.points.push_back(x);
      return static_cast<Index>(surface.points.size()) - 1;
    };
    const Index first = point_at(instants[i].first, last[0]);
    const Index second = point_at(instants[i].second, last[1]);
    for (const Triangle& triangle :
         {Triangle{last[0], last[1], second}, Triangle{last[0], second, first}}) {
      if (i == 0) {
        continue;
      }
      const Eigen::Vector3d triangle_normal = unit_normal(surface, triangle);
      if (!triangle_normal.isZero(0) && triangle_normal.dot(normal) > kTurningBack) {
        surface.triangles.push_back(triangle);
        normal = triangle_normal;
      }
    }
    last = {first, second};
  }
  return surface;
}

CutPlan plan_cut(const Solver& solver, const CutSurface& surface, const CutOptions& options,
                 Index copy) {
  const std::vector<Eigen::Vector3f> positions = solver.positions(copy);
  return plan_cut({positions, solver.tissue()}, surface, options);
}

}  // namespace pbdsurg
