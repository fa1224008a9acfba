// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/stop_passing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/passing.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

// m, the longest of a vertex of sheets and threads.
float farthest_way(const StepContext& step) {
  const MovingVertices vertices = moving_vertices(step);
  float square = 0;
  step.data.surface.for_each_thin([&](const TissueSurface::PlaceTriangle& triangle) {
    for (const Index place : triangle) {
      const Vector way = vertices.position(place) - start_of(step, vertices, place);
      square = std::max(square, dot(way, way));
    }
  });
  return std::sqrt(square);
}

// What one tool takes along.
class ToolPassing {
 public:
  // @param farthest  m, of a vertex
  ToolPassing(const StepContext& step, Index tool, float farthest)
      : step_(step),
        index_(tool),
        tool_(step.copy.tools[tool]),
        stopped_(step.scratch.stopped),
        farthest_(farthest) {}

  void stop() {
    if (!may_pass()) {
      return;
    }
    const std::size_t first = stopped_.size();
    bool stays = false;
    for (int pass = 0; pass < kStopPasses; ++pass) {
      const std::size_t known = stopped_.size();
      meets_wall_ = false;
      step_.data.surface.for_each_thin([&](const auto& triangle) { look_at(triangle); });
      if (meets_wall_ && !stays) {
        stays = true;
        stopped_.resize(known);
        stay();
        continue;
      }
      keep_new(first, known);
      if (stopped_.size() == known) {
        return;
      }
      for (std::size_t i = known; i < stopped_.size(); ++i) {
        take_along(stopped_[i]);
      }
    }
  }

 private:
  [[nodiscard]] SweptCapsule swept(Index capsule) const {
    const auto& [displacement, shift, yield] = tool_.spring;
    const SweptCapsule own = swept_capsule(tool_, static_cast<std::size_t>(capsule));
    return {own.before.moved(displacement), own.now.moved(displacement + shift)};
  }
  [[nodiscard]] Index capsule_count() const {
    return static_cast<Index>(tool_.placed_capsules.size());
  }

  // Whether anything has gone far enough, or may not have been met for want of room.
  [[nodiscard]] bool may_pass() const {
    const auto capacity = static_cast<std::size_t>(step_.data.options.contact_capacity);
    if (tool_.surface_contacts.size() >= capacity) {
      return true;
    }
    for (Index c = 0; c < capsule_count(); ++c) {
      const SweptCapsule capsule = swept(c);
      const float way = farthest_ + capsule.way();
      const auto may_come_through = [&](const SurfaceContact& contact) {
        const std::span<const Index> places(contact.feature.places);
        const auto count = static_cast<std::size_t>(contact.feature.count());
        return contact.capsule == c &&
               !(way < way_through(capsule.before, corners_of(step_, places.first(count))));
      };
      if (!(way < way_through(capsule.before)) ||
          std::ranges::any_of(tool_.surface_contacts, may_come_through)) {
        return true;
      }
    }
    return false;
  }

  void look_at(const TissueSurface::PlaceTriangle& triangle) {
    const FeatureCorners corners = corners_of(step_, triangle);
    const ContactBox box = box_of(corners);
    for (Index c = 0; c < capsule_count(); ++c) {
      const SweptCapsule capsule = swept(c);
      if (!box.meets(core_box(capsule))) {
        continue;
      }
      const Passing passing(capsule, corners);
      corners.for_each([&](int k) {
        if (!passing.has(k)) {
          return;
        }
        if (corners.is_fixed[k]) {
          meets_wall_ = meets_wall_ || tool_.is_coupled();
        } else {
          stopped_.push_back({index_, corners.places[k], c, {}, {}});
        }
      });
    }
  }

  // Each vertex once, by the first capsule that it has come through.
  void keep_new(std::size_t first, std::size_t known) {
    const std::span<const StoppedVertex> old = std::span(stopped_).subspan(first, known - first);
    const auto found = stopped_.begin() + static_cast<std::ptrdiff_t>(known);
    const auto is_old = [&](const StoppedVertex& vertex) {
      return std::ranges::find(old, vertex.place, &StoppedVertex::place) != old.end();
    };
    stopped_.erase(std::remove_if(found, stopped_.end(), is_old), stopped_.end());
    std::sort(found, stopped_.end(), [](const StoppedVertex& a, const StoppedVertex& b) {
      return std::pair(a.place, a.capsule) < std::pair(b.place, b.capsule);
    });
    const auto same = [](const StoppedVertex& a, const StoppedVertex& b) {
      return a.place == b.place;
    };
    stopped_.erase(std::unique(found, stopped_.end(), same), stopped_.end());
  }

  // What its contacts say of sides may be what took it there.
  void stay() {
    tool_.spring.shift = -1.0F * told_way(tool_);
    for (SurfaceContact& contact : tool_.surface_contacts) {
      if (contact.capsule != kInvalidIndex) {
        const std::span<const Index> places(contact.feature.places);
        const auto count = static_cast<std::size_t>(contact.feature.count());
        take_side(corners_of(step_, places.first(count)), swept(contact.capsule), contact);
      }
    }
  }

  void take_along(StoppedVertex& vertex) const {
    const MovingVertices vertices = moving_vertices(step_);
    const Vector before = vertices.position(vertex.place);
    const Vector along =
        taken_along(swept(vertex.capsule), start_of(step_, vertices, vertex.place));
    go_on(step_, vertices, vertex.place, along - before);
    vertex.point = vertices.position(vertex.place);
    vertex.push = (1 / vertices.moving[vertex.place].w) * (vertex.point - before);
  }

  const StepContext& step_;
  Index index_;
  ToolState& tool_;
  std::vector<StoppedVertex>& stopped_;
  float farthest_;
  bool meets_wall_ = false;  // in this pass
};

}  // namespace

bool may_stop(const StepContext& step) noexcept {
  return meets_surfaces(step) && step.data.surface.has_thin();
}

void stop_passing(const StepContext& step) {
  if (!may_stop(step)) {
    return;
  }
  const float farthest = farthest_way(step);
  for (Index tool = 0; tool < static_cast<Index>(step.copy.tools.size()); ++tool) {
    if (step.copy.tools[tool].meets_triangles() && step.copy.pushes(tool)) {
      ToolPassing(step, tool, farthest).stop();
    }
  }
}

}  // namespace pbdsurg
