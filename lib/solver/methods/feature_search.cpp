// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/feature_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "lib/base/segment.h"
#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;
using Eigen::Vector3f;

// An edge's ends are its vertices' business: shares of its length.
constexpr float kEnd = 0.02F;
// Of the radius, that tool and tissue may move against each other between two looks.
constexpr float kStride = 0.5F;
constexpr int kMostLooks = 64;
constexpr float kPlaneMargin = 1e-3F;  // m, beside what a vertex moves in the substep

Vector between(const Vector& from, const Vector& to, float share) {
  return from + share * (to - from);
}

float length(const Vector& v) {
  return std::sqrt(dot(v, v));
}

// Corners of a feature through the substep.
struct Corners {
  int count = 0;
  std::array<Index, 3> places{kInvalidIndex, kInvalidIndex, kInvalidIndex};
  std::array<Vector, 3> start{}, end{};  // m

  [[nodiscard]] std::array<Vector, 3> at(float share) const {
    std::array<Vector, 3> x{};
    for (int k = 0; k < count; ++k) {
      x[k] = share < 1 ? between(start[k], end[k], share) : end[k];
    }
    return x;
  }
  [[nodiscard]] float travel() const {
    float most = 0;
    for (int k = 0; k < count; ++k) {
      most = std::max(most, length(end[k] - start[k]));
    }
    return most;
  }
};

// Where a feature is nearest to an axis.
struct Meeting {
  std::array<float, 3> weights{};
  float share = 0;  // of the axis, from start to end
  Vector away;      // m, from the axis to the feature
  float distance = kInfinity;
};

Meeting meet_vertex(const Vector& x, const Vector& a, const Vector& b) {
  const float share = closest_of_segments(a, b, x, x).first;
  const Vector away = x - between(a, b, share);
  return {{1, 0, 0}, share, away, length(away)};
}

Meeting meet_edge(const std::array<Vector, 3>& x, const Vector& a, const Vector& b) {
  const SegmentPair pair = closest_of_segments(a, b, x[0], x[1]);
  if (pair.second < kEnd || pair.second > 1 - kEnd) {
    return {};
  }
  const Vector away = between(x[0], x[1], pair.second) - between(a, b, pair.first);
  return {{1 - pair.second, pair.second, 0}, pair.first, away, length(away)};
}

// Weights of the point of a triangle's plane below p.
std::array<float, 3> weights_below(const std::array<Vector, 3>& x, const Vector& p) {
  const Vector first = x[1] - x[0], second = x[2] - x[0];
  const Vector normal = cross(first, second);
  const float square = dot(normal, normal);
  const Vector d = p - x[0];
  const float b = dot(cross(d, second), normal) / square;
  const float c = dot(cross(first, d), normal) / square;
  return {1 - b - c, b, c};
}

bool is_inside(const std::array<float, 3>& weights) {
  return std::ranges::all_of(weights, [](float w) { return w > kEnd; });
}

Meeting meet_triangle(const std::array<Vector, 3>& x, const Vector& a, const Vector& b) {
  Meeting best;
  const auto consider = [&](float share) {
    const Vector p = between(a, b, share);
    const std::array<float, 3> weights = weights_below(x, p);
    if (!is_inside(weights)) {
      return;
    }
    const Vector away = weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2] - p;
    const float distance = length(away);
    if (distance < best.distance) {
      best = {weights, share, away, distance};
    }
  };
  consider(0);
  const Vector axis = b - a;
  if (dot(axis, axis) > 0) {
    consider(1);
    const Vector normal = cross(x[1] - x[0], x[2] - x[0]);
    const float rise = dot(axis, normal);
    const float share = dot(x[0] - a, normal) / rise;
    if (share > 0 && share < 1) {
      consider(share);
    }
  }
  return best;
}

Meeting meet(int count, const std::array<Vector, 3>& x, const Vector& a, const Vector& b) {
  switch (count) {
    case 1:
      return meet_vertex(x[0], a, b);
    case 2:
      return meet_edge(x, a, b);
    default:
      return meet_triangle(x, a, b);
  }
}

struct Box {
  Vector low{kInfinity, kInfinity, kInfinity};
  Vector high{-kInfinity, -kInfinity, -kInfinity};

  void add(const Vector& x, float reach) {
    low = {std::min(low.x, x.x - reach), std::min(low.y, x.y - reach),
           std::min(low.z, x.z - reach)};
    high = {std::max(high.x, x.x + reach), std::max(high.y, x.y + reach),
            std::max(high.z, x.z + reach)};
  }
  [[nodiscard]] bool meets(const Box& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
};

// The search of one tool.
class FeatureSearch {
 public:
  FeatureSearch(const StepContext& step, ToolState& tool, const Substep<float>& lengths,
                StepReport& report)
      : step_(step),
        vertices_(moving_vertices(step)),
        tool_(tool),
        inverse_dt_squared_(lengths.inverse_dt_squared),
        report_(report) {
    for (std::size_t c = 0; c < tool.placed_capsules.size(); ++c) {
      for (const Capsule* const capsule : {&tool.placed_capsules[c], &tool.capsules_before[c]}) {
        const float reach = (1 + kContactMargin) * capsule->radius;
        box_.add(load(capsule->start), reach);
        box_.add(load(capsule->end), reach);
      }
    }
  }

  void run() {
    tool_.surface_contacts.clear();
    const auto count = static_cast<Index>(step_.copy.particles.size());
    for (Index place = 0; place < count && !tool_.placed_capsules.empty(); ++place) {
      consider(std::array{place});
    }
    for (const HalfSpace& half_space : tool_.half_spaces) {
      for (Index place = 0; place < count; ++place) {
        consider(place, half_space);
      }
    }
    if (tool_.surface.features == ContactFeatures::all) {
      step_.data.surface.for_each_triangle([&](const auto& triangle) { consider_all(triangle); });
    }
    std::vector<SurfaceContact>& found = tool_.surface_contacts;
    std::ranges::sort(found, {}, &SurfaceContact::feature);
    const auto same = [](const SurfaceContact& a, const SurfaceContact& b) {
      return a.feature == b.feature;
    };
    found.erase(std::unique(found.begin(), found.end(), same), found.end());
  }

 private:
  [[nodiscard]] Vector start_of(Index place) const {
    return vertices_.bases == nullptr ? load(step_.scratch.previous[place])
                                      : load(vertices_.bases[place]);
  }

  template <std::size_t kCount>
  [[nodiscard]] std::optional<Corners> near_corners(const std::array<Index, kCount>& places) const {
    Corners corners{kCount};
    Box box;
    for (std::size_t k = 0; k < kCount; ++k) {
      corners.places[k] = places[k];
      corners.start[k] = start_of(places[k]);
      corners.end[k] = vertices_.position(places[k]);
      box.add(corners.start[k], 0);
      box.add(corners.end[k], 0);
    }
    return box.meets(box_) ? std::optional(corners) : std::nullopt;
  }

  // What is above a plane with all vertices is above it.
  void consider(Index place, const HalfSpace& half_space) {
    if (!(vertices_.moving[place].w > 0)) {
      return;
    }
    const Vector x = vertices_.position(place), before = start_of(place);
    const Vector normal = load(Vector3f(tool_.placed.linear() * half_space.normal));
    const Vector plane = load(Vector3f(tool_.placed * half_space.point));
    const float gap = dot(normal, x - plane);
    if (!(gap < kPlaneMargin + length(x - before))) {
      return;
    }
    SurfaceContact contact;
    contact.weights = {1, 0, 0};
    contact.normal = normal;
    contact.point = x - gap * normal;
    const Vector3f point(contact.point.x, contact.point.y, contact.point.z);
    const Vector then = load(Vector3f(tool_.placed_before * (tool_.placed.inverse() * point)));
    contact.drift = (contact.point - then) + own_start(place);
    contact.offset = dot(normal, plane) - dot(normal, vertices_.base(place));
    add({{place, kInvalidIndex, kInvalidIndex}}, contact);
  }

  void add(const ContactFeature& feature, SurfaceContact& contact) {
    if (tool_.surface_contacts.size() >=
        static_cast<std::size_t>(step_.data.options.contact_capacity)) {
      ++report_.dropped_contacts;
      return;
    }
    contact.feature = feature;
    if (const RememberedContact* const known = find_remembered(feature)) {
      recall(*known, contact);
    }
    tool_.surface_contacts.push_back(contact);
  }

  // Edges of a closed surface run from smaller to larger places in one of two triangles.
  void consider_all(const std::array<Index, 3>& triangle) {
    if (!near_corners(triangle)) {
      return;
    }
    for (int k = 0; k < 3; ++k) {
      const Index first = triangle[k], second = triangle[(k + 1) % 3];
      if (first < second) {
        consider(std::array{first, second});
      }
    }
    std::array<Index, 3> places = triangle;
    std::ranges::sort(places);
    consider(places);
  }

  template <std::size_t kCount>
  void consider(const std::array<Index, kCount>& places) {
    const std::optional<Corners> corners = near_corners(places);
    if (!corners ||
        std::ranges::none_of(places, [&](Index p) { return vertices_.moving[p].w > 0; })) {
      return;
    }
    const ContactFeature feature{corners->places};
    const RememberedContact* const known = find_remembered(feature);
    std::optional<SurfaceContact> deepest;
    float depth = kInfinity;
    for (std::size_t c = 0; c < tool_.placed_capsules.size(); ++c) {
      consider(*corners, tool_.capsules_before[c], tool_.placed_capsules[c], known, deepest, depth);
    }
    if (deepest) {
      add(feature, *deepest);
    }
  }

  // Keeps the least gap.
  void consider(const Corners& corners, const Capsule& before, const Capsule& now,
                const RememberedContact* known, std::optional<SurfaceContact>& deepest,
                float& depth) const {
    const Vector a = load(now.start), b = load(now.end);
    const float radius = now.radius;
    const float reach = (1 + kContactMargin) * radius;
    const Meeting end = meet(corners.count, corners.end, a, b);
    bool has_side = known != nullptr;
    Vector side = has_side ? known->normal : Vector{};
    std::optional<Meeting> hit = end.distance < reach ? std::optional(end) : std::nullopt;
    const float travel =
        corners.travel() + std::max(length(a - load(before.start)), length(b - load(before.end)));
    const int looks =
        std::clamp(static_cast<int>(std::ceil(travel / (kStride * radius))), 1, kMostLooks);
    // the first look is at the start: what was near then, sweeps may bring back
    for (int look = 0; look < (has_side ? 1 : looks) && !(has_side && hit); ++look) {
      const float share = static_cast<float>(look) / static_cast<float>(looks);
      const Meeting early =
          meet(corners.count, corners.at(share), between(load(before.start), a, share),
               between(load(before.end), b, share));
      if (early.distance < reach && early.distance > 0) {
        side = has_side ? side : (1 / early.distance) * early.away;
        has_side = true;
        hit = hit ? hit : early;  // gone through, unless it only came by
      }
    }
    if (!hit) {
      return;
    }
    const std::array<float, 3>& weights = hit->weights;
    const Vector on_axis = between(a, b, hit->share);
    const Vector x =
        weights[0] * corners.end[0] + weights[1] * corners.end[1] + weights[2] * corners.end[2];
    const Vector away = x - on_axis;
    const float distance = length(away);
    Vector normal;
    if (distance > 0 && (!has_side || dot(away, side) > 0)) {
      normal = (1 / distance) * away;
    } else if (has_side) {
      const Vector back = -1.0F * away;
      normal = distance > 0 && end.distance < reach ? (1 / distance) * back : side;
    } else {
      return;  // on the axis: it has no side to be pushed to
    }
    const float gap = dot(normal, away) - radius;
    if (!(gap < depth)) {
      return;
    }
    depth = gap;
    deepest.emplace();
    deepest->weights = weights;
    deepest->normal = normal;
    deepest->point = on_axis + radius * normal;
    const Vector then = between(load(before.start), load(before.end), hit->share) + radius * normal;
    deepest->drift = deepest->point - then;
    deepest->offset = dot(normal, on_axis) + radius;
    for (int k = 0; k < corners.count; ++k) {
      deepest->offset -= weights[k] * dot(normal, vertices_.base(corners.places[k]));
      deepest->drift = deepest->drift + weights[k] * own_start(corners.places[k]);
    }
  }

  // Where a vertex that has not moved would be, as MovingVertices count.
  [[nodiscard]] Vector own_start(Index place) const {
    if (vertices_.bases == nullptr) {
      return start_of(place);
    }
    return has_past(step_.data.options) ? load(step_.copy.ways[place])  // see recall_past()
                                        : load(step_.copy.carries[place]);
  }

  [[nodiscard]] const RememberedContact* find_remembered(const ContactFeature& feature) const {
    const auto found =
        std::ranges::lower_bound(tool_.remembered, feature, {}, &RememberedContact::feature);
    return found != tool_.remembered.end() && found->feature == feature ? &*found : nullptr;
  }

  // Vertex blocks go on from the forces of the substep before; projections begin anew.
  void recall(const RememberedContact& known, SurfaceContact& contact) const {
    if (!moves_vertices(step_.data.options)) {
      return;
    }
    contact.multiplier = known.force / inverse_dt_squared_;
    const Vector along = known.friction - dot(known.friction, contact.normal) * contact.normal;
    contact.friction = (1 / inverse_dt_squared_) * along;
  }

  const StepContext& step_;
  MovingVertices vertices_;
  ToolState& tool_;
  float inverse_dt_squared_;
  StepReport& report_;
  Box box_;
};

}  // namespace

void find_surface_contacts(const StepContext& step, ToolState& tool, const Substep<float>& lengths,
                           StepReport& report) {
  FeatureSearch(step, tool, lengths, report).run();
}

void remember_contacts(ToolState& tool, float inverse_dt_squared) {
  tool.remembered.clear();
  for (const SurfaceContact& contact : tool.surface_contacts) {
    tool.remembered.push_back({contact.feature, contact.normal,
                               inverse_dt_squared * contact.multiplier,
                               inverse_dt_squared * contact.friction});
  }
}

}  // namespace pbdsurg
