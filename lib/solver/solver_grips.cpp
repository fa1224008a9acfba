// SPDX-License-Identifier: Apache-2.0
// Grips of a solver: what jaws hold with a limit.
#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/base/describe.h"
#include "lib/solver/grip_checks.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// m, in a tool's frame.
std::vector<Eigen::Vector3f> places_of(SolverData& data, Index copy, const ToolState& tool,
                                       std::span<const TissuePoint> points) {
  std::vector<Index> vertices;
  for (const TissuePoint& point : points) {
    vertices.insert(vertices.end(), point.vertices.begin(),
                    point.vertices.begin() + corner_count(point));
  }
  std::vector<Eigen::Vector3f> positions(vertices.size());
  data.read_positions(copy, vertices, positions);
  const ToolPose to_tool = tool.pose.inverse();
  std::vector<Eigen::Vector3f> places;
  auto position = positions.begin();
  for (const TissuePoint& point : points) {
    Eigen::Vector3f x = Eigen::Vector3f::Zero();
    for (int k = 0; k < corner_count(point); ++k) {
      x += point.weights[k] * *position++;
    }
    places.push_back(to_tool * x);
  }
  return places;
}

// @param places  m, of the points in the tool's frame
void shut(SolverData& data, Index copy, ToolId tool, const Grip& limits,
          std::span<const TissuePoint> points, std::span<const Eigen::Vector3f> places,
          std::array<Index, 2> jaws) {
  ToolGrip grip;
  grip.limits = limits;
  grip.state = GripState::holding;
  grip.jaws = jaws;
  for (std::size_t i = 0; i < points.size(); ++i) {
    GripPoint& point = grip.points.emplace_back();
    point.at = points[i];
    point.anchor = places[i];
  }
  grip.find_corners();
  grip.torn.reserve(grip.corners.size());
  data.copy(copy).tools[tool].grip = std::move(grip);
  data.forget_releases(copy, tool);
  data.changes.tools = true;
  data.rebuild_plan();
}

// Live tetrahedra that join some vertices to others.
std::vector<Index> tets_at_rim(const Tissue& tissue, std::span<const Index> vertices) {
  std::vector<Index> tets;
  const auto is_among = [&](Index v) { return std::ranges::binary_search(vertices, v); };
  for (const Index v : vertices) {
    if (v >= tissue.vertex_count()) {
      continue;
    }
    for (const Index tet : tissue.tets_at(v)) {
      if (!std::ranges::all_of(tissue.tets()[tet], is_among)) {
        tets.push_back(tet);
      }
    }
  }
  std::ranges::sort(tets);
  tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
  return tets;
}

}  // namespace

void Solver::grasp(ToolId tool, std::span<const TissuePoint> points, const Grip& grip, Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  check_takes_grips(*data_);
  check_grip(grip);
  check_holds_nothing(state, tool);
  check_is_rigid(state, tool);
  check_points(tissue(), points);
  data_->finish_running_step();
  const std::vector<Eigen::Vector3f> places = places_of(*data_, copy, state, points);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!is_on_pad(grip.pad, places[i])) {
      throw InvalidArgument("point " + std::to_string(i) + " is at " +
                            describe(Eigen::Vector3d(places[i].cast<double>())) +
                            " m of the tool's frame; it must be on the pad");
    }
  }
  if (!can_be_held(places)) {
    throw InvalidArgument("a grip has " + std::to_string(points.size()) +
                          " points; it needs three that are not on a line");
  }
  shut(*data_, copy, tool, grip, points, places, {kInvalidIndex, kInvalidIndex});
}

std::size_t Solver::close_jaws(ToolId tool, std::array<ToolId, 2> jaws, const Grip& grip,
                               Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  check_takes_grips(*data_);
  check_grip(grip);
  check_holds_nothing(state, tool);
  check_is_rigid(state, tool);
  for (const ToolId jaw : jaws) {
    if (!checked_tool(owner, jaw).has_surface()) {
      throw InvalidArgument("tool " + std::to_string(jaw.value) +
                            " has no surface, so its contacts are not known: see ToolSurface");
    }
  }
  const bool is_one_tool = jaws[0] == jaws[1];
  if (is_one_tool && checked_tool(owner, jaws[0]).joints.empty()) {
    throw InvalidArgument("tool " + std::to_string(jaws[0].value) +
                          " is both jaws, and has no joint that closes them");
  }
  data_->finish_running_step();
  const Eigen::Vector3f normal = state.pose.linear() * grip.pad.normal;
  std::vector<TissuePoint> points;
  std::array<float, 2> forces{};  // N, on each jaw, across the pad
  for (std::size_t jaw = 0; jaw < (is_one_tool ? 1 : 2); ++jaw) {
    for (const ToolContact& contact : tool_contacts(jaws[jaw], copy)) {
      const TissuePoint point{contact.vertices, contact.weights};
      const Eigen::Vector3f place = places_of(*data_, copy, state, {&point, 1}).front();
      if (!(contact.force.squaredNorm() > 0) || !is_on_pad(grip.pad, place)) {
        continue;
      }
      const float force = contact.force.dot(normal);
      const float height = grip.pad.normal.dot(place - grip.pad.center);
      if (is_one_tool && !(force * height > 0)) {
        continue;  // its back
      }
      const std::size_t side = is_one_tool && height < 0 ? 1 : jaw;
      points.push_back(point);
      forces[side] += force;
    }
  }
  const float pinch = std::min(std::abs(forces[0]), std::abs(forces[1]));
  const std::vector<Eigen::Vector3f> places = places_of(*data_, copy, state, points);
  if (!(pinch >= kLeastPinch) || !can_be_held(places)) {
    return 0;
  }
  shut(*data_, copy, tool, grip, points, places, {jaws[0].value, jaws[1].value});
  return points.size();
}

void Solver::set_clamp_force(ToolId tool, float force, Index copy) {
  ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  check_clamp_force(force);
  if (!state.grip.is_shut()) {
    throw InvalidArgument("tool " + std::to_string(tool.value) +
                          " has no grip whose clamp force could be set");
  }
  data_->finish_running_step();
  state.grip.limits.clamp_force = force;
}

std::vector<ToolId> Solver::lost_grips(Index copy) const {
  const CopyState& owner = checked_copy(*data_, copy);
  data_->finish_running_step();
  std::vector<ToolId> lost;
  for (std::size_t t = 0; t < owner.tools.size(); ++t) {
    if (owner.tools[t].grip.let_go_now) {
      lost.emplace_back(static_cast<Index>(t));
    }
  }
  return lost;
}

float Solver::slip_limit(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  const ToolGrip& grip = state.grip;
  return grip.is_shut() ? 2 * grip.limits.friction * grip.limits.clamp_force
                        : std::numeric_limits<float>::infinity();
}

GripReport Solver::tool_grip(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  const ToolGrip& grip = state.grip;
  GripReport report;
  report.state = grip.state;
  report.pull = grip.pull;
  report.slid = grip.slid;
  if (grip.is_shut()) {
    report.clamp_force = grip.limits.clamp_force;
    report.slip_limit = slip_limit(tool, copy);
    report.tear_limit =
        grip.limits.tear_strength * grip.width_across(state.pose.linear().transpose() * grip.pull);
  }
  for (const GripPoint& point : grip.points) {
    report.points.push_back({point.at, point.anchor, point.force});
  }
  if (grip.state == GripState::torn) {
    report.torn_vertices = grip.torn;
    report.torn_tets = tets_at_rim(tissue(), grip.torn);
  }
  return report;
}

}  // namespace pbdsurg
