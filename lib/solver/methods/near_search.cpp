// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/near_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

bool is_farther(const Vector& a, const Vector& b, float distance) {
  const Vector way = a - b;
  return !(dot(way, way) <= distance * distance);  // also where one is not finite
}

// Where a vertex is at the start of the substep and at its end.
struct Ends {
  Vector start, end;
};

Ends ends_of(const StepContext& step, const MovingVertices& vertices, Index place) {
  const Vector end = vertices.position(place);
  return {vertices.bases == nullptr ? load(step.scratch.previous[place]) : vertices.base(place),
          end};
}

bool has_list(const CopyState& copy, std::size_t tool) {
  return copy.tools[tool].has_surface() && !copy.tools[tool].capsules.empty() &&
         copy.pushes(static_cast<Index>(tool));
}

bool serves(const NearFeatures& near, const ToolState& tool, float slack) {
  if (near.capsules.size() != tool.placed_capsules.size()) {
    return false;
  }
  for (std::size_t c = 0; c < near.capsules.size(); ++c) {
    const SweptCapsule swept = swept_capsule(tool, c).moved(tool.spring.displacement);
    for (const PlacedCapsule& now : {swept.before, swept.now}) {
      const PlacedCapsule& then = near.capsules[c];
      bool stays = now.radius == then.radius && now.is_plate() == then.is_plate();
      now.for_each_corner([&](const CorePlace& place) {
        stays = stays && !is_farther(now.corner(place), then.corner(place), slack);
      });
      if (!stays) {
        return false;
      }
    }
  }
  return true;
}

bool serve(const StepContext& step, const NearLists& lists) {
  const CopyState& copy = step.copy;
  if (!(lists.slack > 0) || lists.surface_revision != step.data.surface.revision() ||
      lists.positions.size() != copy.particles.size() || lists.tools.size() != copy.tools.size()) {
    return false;
  }
  for (std::size_t t = 0; t < copy.tools.size(); ++t) {
    if (has_list(copy, t) && !serves(lists.tools[t], copy.tools[t], lists.slack)) {
      return false;
    }
  }
  const MovingVertices vertices = moving_vertices(step);
  for (Index place = 0; place < static_cast<Index>(copy.particles.size()); ++place) {
    const auto [start, end] = ends_of(step, vertices, place);
    if (is_farther(start, lists.positions[place], lists.slack) ||
        is_farther(end, lists.positions[place], lists.slack)) {
      return false;
    }
  }
  return true;
}

// Lists what is within reach of a tool where it is now.
void list(const StepContext& step, const ToolState& tool, const NearLists& lists,
          NearFeatures& near) {
  near.capsules.clear();
  near.vertices.clear();
  near.triangles.clear();
  for (std::size_t c = 0; c < tool.placed_capsules.size(); ++c) {
    near.capsules.push_back(swept_capsule(tool, c).now.moved(tool.spring.displacement));
  }
  const auto is_near = [&](const Vector& x, float radius) {
    return std::ranges::any_of(near.capsules, [&](const PlacedCapsule& capsule) {
      const float reach = (1 + kContactMargin) * capsule.radius + 2 * lists.slack + radius;
      return !is_farther(x, capsule.at(capsule.closest(x)), reach);
    });
  };
  near.vertices.reserve(lists.positions.size());
  for (Index place = 0; place < static_cast<Index>(lists.positions.size()); ++place) {
    if (is_near(lists.positions[place], 0)) {
      near.vertices.push_back(place);
    }
  }
  if (!tool.meets_triangles()) {
    return;
  }
  near.triangles.reserve(static_cast<std::size_t>(step.data.surface.triangle_count()));
  step.data.surface.for_each_triangle([&](const TissueSurface::PlaceTriangle& triangle) {
    const Vector a = lists.positions[triangle[0]], b = lists.positions[triangle[1]],
                 c = lists.positions[triangle[2]];
    const Vector centre = (1.0F / 3) * (a + b + c);
    const Vector to_a = a - centre, to_b = b - centre, to_c = c - centre;
    const float square = std::max({dot(to_a, to_a), dot(to_b, to_b), dot(to_c, to_c)});
    constexpr float kRounding = 1.001F;
    if (is_near(centre, kRounding * std::sqrt(square))) {
      near.triangles.push_back(triangle);
    }
  });
}

}  // namespace

void refresh_near_lists(const StepContext& step) {
  CopyState& copy = step.copy;
  NearLists& lists = copy.near;
  float slack = 0;
  for (std::size_t t = 0; t < copy.tools.size(); ++t) {
    for (const Capsule& capsule : copy.tools[t].capsules) {
      slack = has_list(copy, t) ? std::max(slack, capsule.radius) : slack;
    }
  }
  if (slack == 0 || serve(step, lists)) {
    return;
  }
  lists.slack = slack;
  lists.surface_revision = step.data.surface.revision();
  lists.positions.resize(copy.particles.size());
  lists.tools.resize(copy.tools.size());
  const MovingVertices vertices = moving_vertices(step);
  for (Index place = 0; place < static_cast<Index>(copy.particles.size()); ++place) {
    const auto [start, end] = ends_of(step, vertices, place);
    lists.positions[place] = end;
    if (is_farther(start, end, lists.slack)) {
      lists.slack = 0;  // nothing holds for as fast a motion
      return;
    }
  }
  for (std::size_t t = 0; t < copy.tools.size(); ++t) {
    if (has_list(copy, t)) {
      list(step, copy.tools[t], lists, lists.tools[t]);
    } else {
      lists.tools[t].capsules.clear();  // what it has is of another time
    }
  }
}

const NearFeatures* near_features(const StepContext& step, Index tool) {
  const NearLists& lists = step.copy.near;
  return lists.slack > 0 && serves(lists.tools[tool], step.copy.tools[tool], lists.slack)
             ? &lists.tools[tool]
             : nullptr;
}

}  // namespace pbdsurg
