// SPDX-License-Identifier: Apache-2.0
#include "tests/support/random_touches.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_data.h"
#include "tests/support/inspect.h"

namespace pbdsurg::testing {
namespace {

constexpr std::size_t kMostTools = 3;
constexpr float kReach = 3e-3F;  // m, less than an edge

template <class Call>
void both(Solver& solver, Solver* twin, const Call& call) {
  call(solver);
  if (twin != nullptr) {
    call(*twin);
  }
}

std::vector<Index> vertices_with_tissue_of(const Solver& solver) {
  return find_all(static_cast<std::size_t>(solver.vertex_count()),
                  [&](Index v) { return solver.tissue().has_tissue(v); });
}

Eigen::Vector3f some_way(Choices& choices) {
  Eigen::Vector3f way;
  for (float& along : way) {
    along = kReach * static_cast<float>(2 * choices.share() - 1);
  }
  return way;
}

ToolPose at(const Eigen::Vector3f& place) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = place;
  return pose;
}

}  // namespace

void RandomTouches::change(Choices& choices, Solver& solver, Solver* twin) {
  switch (choices.below(9)) {
    case 0:
    case 1:
      add_tool(choices, solver, twin);
      break;
    case 2:
    case 3:
      let_bodies_meet(choices, solver, twin);
      break;
    case 4:
      grasp(choices, solver, twin);
      break;
    case 5:
      change_tool(choices, solver, twin);
      break;
    default:
      move_tools(choices, solver, twin);
      break;
  }
}

void RandomTouches::add_tool(Choices& choices, Solver& solver, Solver* twin) {
  const std::vector<Index> vertices = vertices_with_tissue_of(solver);
  if (tools_.size() >= kMostTools || vertices.empty()) {
    return;
  }
  const ToolPose pose = at(solver.positions()[choices.one_of(vertices)] + some_way(choices));
  const ToolSurface surface{
      choices.below(4) == 0 ? ContactFeatures::vertices : ContactFeatures::all,
      choices.one_of(std::array{0.0F, 0.1F, 0.6F})};
  ToolId added{};
  if (choices.below(4) == 0) {
    const HalfSpace below{.normal = Eigen::Vector3f::UnitY()};
    both(solver, twin,
         [&](Solver& each) { added = each.add_half_space(below, surface.friction, pose); });
  } else {
    const Capsule capsule{-some_way(choices), some_way(choices), 1e-3F};
    both(solver, twin, [&](Solver& each) { added = each.add_tool({&capsule, 1}, pose, surface); });
  }
  tools_.push_back(added);
}

// Takes one out, or ties it by a spring, or ties it no more.
void RandomTouches::change_tool(Choices& choices, Solver& solver, Solver* twin) {
  if (tools_.empty()) {
    return;
  }
  const ToolId tool = tools_.back();
  if (choices.below(2) == 0) {
    both(solver, twin, [&](Solver& each) { each.remove_tool(tool); });
    tools_.pop_back();
  } else {
    const float stiffness =
        choices.one_of(std::array{0.5F, 500.0F, std::numeric_limits<float>::infinity()});
    both(solver, twin, [&](Solver& each) {
      try {
        each.couple_tool(tool, {stiffness});
      } catch (const InvalidArgument&) {  // it meets vertices alone, without friction
      }
    });
  }
}

void RandomTouches::move_tools(Choices& choices, Solver& solver, Solver* twin) const {
  for (const std::vector<ToolId>& some : {tools_, grippers_}) {
    for (const ToolId tool : some) {
      ToolPose pose = solver.tool_pose(tool);
      pose.translation() += 0.5F * some_way(choices);
      both(solver, twin, [&](Solver& each) { each.move_tool(tool, pose); });
    }
  }
}

void RandomTouches::let_bodies_meet(Choices& choices, Solver& solver, Solver* twin) {
  const std::vector<Index> bodies = find_all(solver.tissue().bodies().size(), [&](Index body) {
    return solver.tissue().is_body_alive(body);
  });
  if (bodies.empty()) {
    return;
  }
  const Index first = choices.one_of(bodies), second = choices.one_of(bodies);
  const TissueContact contact{.thickness = choices.one_of(std::array{0.4e-3F, 1.5e-3F}),
                              .friction = choices.one_of(std::array{0.0F, 0.3F})};
  const bool are_apart = choices.below(4) == 0;
  both(solver, twin, [&](Solver& each) {
    if (are_apart) {
      each.clear_body_contact(first, second);
    } else {
      each.set_body_contact(first, second, contact);
    }
  });
}

// Or lets go. Points may be on a line, which holds nothing.
void RandomTouches::grasp(Choices& choices, Solver& solver, Solver* twin) {
  const std::vector<Index> vertices = pick_some(vertices_with_tissue_of(solver), 6, choices);
  if (vertices.empty()) {
    return;
  }
  if (!grippers_.empty()) {
    both(solver, twin, [&](Solver& each) { each.release(grippers_[0]); });
    if (choices.below(2) == 0) {
      return;
    }
  } else {
    ToolId added{};
    both(solver, twin, [&](Solver& each) { added = each.add_tool({}, ToolPose::Identity()); });
    grippers_.push_back(added);
  }
  std::vector<TissuePoint> points;
  for (const Index v : vertices) {
    points.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
  }
  Grip grip;
  grip.pad.center = solver.tool_pose(grippers_[0]).inverse() * solver.positions()[vertices[0]];
  grip.pad.half_length = grip.pad.half_width = 0.1F;
  grip.clamp_force = choices.one_of(std::array{0.0F, 1e-4F, 0.1F});
  grip.tear_strength = choices.one_of(std::array{0.01F, 100.0F});
  both(solver, twin, [&](Solver& each) {
    try {
      each.grasp(grippers_[0], points, grip);
    } catch (const InvalidArgument&) {  // both refuse alike, or differ from then on
    }
  });
}

std::string RandomTouches::difference(const Solver& solver, const Solver& twin) const {
  for (const ToolId tool : tools_) {
    if (solver.tool_force(tool) != twin.tool_force(tool) ||
        solver.tool_torque(tool) != twin.tool_torque(tool) ||
        solver.tool_pose(tool).matrix() != twin.tool_pose(tool).matrix()) {
      return "a tool feels something else";
    }
    if (solver.tool_contacts(tool).size() != twin.tool_contacts(tool).size()) {
      return "a tool touches something else";
    }
  }
  for (const ToolId tool : grippers_) {
    const GripReport grip = solver.tool_grip(tool), other = twin.tool_grip(tool);
    if (grip.state != other.state || grip.pull != other.pull ||
        grip.points.size() != other.points.size()) {
      return "jaws hold something else";
    }
  }
  return solver.body_contacts().size() == twin.body_contacts().size() ? ""
                                                                      : "bodies meet elsewhere";
}

std::string surface_difference(const Solver& solver, std::span<const LiveSurface> surfaces) {
  const SolverData& data = inspect(solver);
  for (const LiveSurface& live : surfaces) {
    if (!data.surface.has_begun()) {
      break;
    }
    std::vector<TissueSurface::PlaceTriangle> wanted, listed;
    for (Index slot = 0; slot < live.slot_count(); ++slot) {
      if (live.origins()[slot].tet != kInvalidIndex) {
        const Triangle& corners = live.triangles()[slot];
        wanted.push_back({data.place_of_vertex[corners[0]], data.place_of_vertex[corners[1]],
                          data.place_of_vertex[corners[2]]});
      }
    }
    for (const TissueSurface::PlaceTriangle& triangle : data.surface.slots(live.body())) {
      if (triangle[0] != kInvalidIndex) {
        listed.push_back(triangle);
      }
    }
    std::ranges::sort(wanted);
    std::ranges::sort(listed);
    if (wanted != listed) {
      return "tools meet another surface than that of body " + std::to_string(live.body());
    }
  }
  return "";
}

}  // namespace pbdsurg::testing
