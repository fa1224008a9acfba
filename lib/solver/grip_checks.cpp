// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/grip_checks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"
#include "lib/base/describe.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg {
namespace {

constexpr float kRounding = 1e-3F;  // of units and of sums

void check_unit(const char* what, const Eigen::Vector3f& direction) {
  if (!(std::abs(direction.norm() - 1) < kRounding)) {
    throw InvalidArgument(std::string(what) + " has length " + describe(direction.norm()) +
                          "; it must be a unit");
  }
}

[[noreturn]] void refuse(std::size_t point, const std::string& why) {
  throw InvalidArgument("point " + std::to_string(point) + " " + why);
}

void check_vertices(const Tissue& tissue, std::size_t index, const TissuePoint& point) {
  const int count = corner_count(point);
  for (std::size_t k = 0; k < point.vertices.size(); ++k) {
    const Index v = point.vertices[k];
    const bool is_behind = static_cast<int>(k) >= count;
    if (is_behind ? v != kInvalidIndex : v < 0 || v >= tissue.vertex_count()) {
      refuse(index, "has vertex " + std::to_string(v) +
                        (is_behind ? " behind one that there is not"
                                   : "; ids must be in [0, " +
                                         std::to_string(tissue.vertex_count()) + ")"));
    }
    if (std::count(point.vertices.begin(), point.vertices.begin() + count, v) > 1) {
      refuse(index, "has vertex " + std::to_string(v) + " twice");
    }
  }
  if (count == 0) {
    refuse(index, "has no vertex");
  }
  if (!is_on_tissue(tissue, point)) {
    refuse(index, "is on no vertex, edge or face of living tissue: its first vertex is " +
                      std::to_string(point.vertices[0]));
  }
}

void check_weights(std::size_t index, const TissuePoint& point) {
  float sum = 0;
  for (std::size_t k = 0; k < point.weights.size(); ++k) {
    const float weight = point.weights[k];
    const bool is_behind = point.vertices[k] == kInvalidIndex;
    if (!(weight >= 0) || (is_behind && weight > 0)) {
      refuse(index, "has weight " + describe(weight) +
                        (is_behind ? " of no vertex" : "; weights must be >= 0"));
    }
    sum += weight;
  }
  if (!(std::abs(sum - 1) < kRounding)) {
    refuse(index, "has weights whose sum is " + describe(sum) + "; it must be 1");
  }
}

}  // namespace

void check_takes_grips(const SolverData& data) {
  if (is_explicit(data.options)) {
    throw InvalidArgument(
        "in explicit steps tools hold without a limit: grasp() takes vertices alone");
  }
}

void check_pad(const JawPad& pad) {
  if (!pad.center.allFinite()) {
    throw InvalidArgument("the pad's center is not finite");
  }
  check_unit("the pad's normal", pad.normal);
  check_unit("the pad's direction along the jaws", pad.along);
  const float cosine = pad.normal.dot(pad.along);
  if (!(std::abs(cosine) < kRounding)) {
    throw InvalidArgument("the pad's normal and its direction along the jaws have a cosine of " +
                          describe(cosine) + "; they must be at a right angle");
  }
  check_positive("the pad's half length", pad.half_length, " m");
  check_positive("the pad's half width", pad.half_width, " m");
}

void check_grip(const Grip& grip) {
  check_pad(grip.pad);
  check_clamp_force(grip.clamp_force);
  check_not_negative("a grip's friction", grip.friction);
  check(grip.tear_strength > 0, "a grip's tear strength", grip.tear_strength, "positive, in N/m");
  check(grip.compliance > 0 && grip.compliance <= kLargestCompliance, "a grip's compliance",
        grip.compliance, "in (0, 1e12] m/N");
}

void check_clamp_force(float force) {
  check_not_negative("a grip's clamp force", force);
}

void check_points(const Tissue& tissue, std::span<const TissuePoint> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    check_vertices(tissue, i, points[i]);
    check_weights(i, points[i]);
  }
}

void check_holds_nothing(const ToolState& tool, ToolId id) {
  if (tool.holds()) {
    throw InvalidArgument("tool " + std::to_string(id.value) +
                          " holds something already: release() comes first");
  }
}

bool can_be_held(std::span<const Eigen::Vector3f> places) {
  if (places.size() < kLeastGripPoints) {
    return false;
  }
  const auto far_from = [&](const Eigen::Vector3f& place) {
    return *std::ranges::max_element(
        places, {}, [&](const Eigen::Vector3f& other) { return (other - place).squaredNorm(); });
  };
  const Eigen::Vector3f one = far_from(places[0]), line = far_from(one) - one;
  return std::ranges::any_of(places, [&](const Eigen::Vector3f& place) {
    return line.cross(place - one).norm() > kRounding * line.squaredNorm();
  });
}

void check_grip_state(const SolverData& data, const ToolGrip& grip, std::size_t tool_count) {
  check_grip(grip.limits);
  if (grip.is_shut()) {
    check_takes_grips(data);
  }
  for (const Index jaw : grip.jaws) {
    if (jaw != kInvalidIndex) {
      check_id("tool", jaw, tool_count);
    }
  }
  if (!grip.is_shut() && !grip.points.empty()) {
    throw InvalidArgument("a grip that is open or has let go holds points; it must have none");
  }
  for (std::size_t i = 0; i < grip.points.size(); ++i) {
    const GripPoint& point = grip.points[i];
    check_points(*data.tissue, {&point.at, 1});
    if (!point.anchor.allFinite() || !point.force.allFinite()) {
      refuse(i, "of a grip is held at a place or with a force that is not finite");
    }
  }
  for (const Index v : grip.torn) {
    check_id("vertex", v, static_cast<std::size_t>(data.tissue->vertex_count()));
  }
}

}  // namespace pbdsurg
