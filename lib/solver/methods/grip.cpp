// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/grip.h"

#include <algorithm>
#include <cmath>

#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/contact_stage.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

Vector along_pad(const ToolGrip& grip, const Vector& v) {
  return pbdsurg::along_pad(load(grip.normal), v);
}

// Draws points to their anchors by the masses of their vertices, then takes off what of the pull is
// beyond the limit: from each point as much as it feels of anchors that slide, so that all are
// where they would be drawn to. Those of fixed vertices feel most.
class Projection {
 public:
  Projection(const StepContext& step, ToolGrip& grip, const Substep<float>& lengths)
      : step_(step),
        grip_(grip),
        vertices_(moving_vertices(step)),
        alpha_(compliance_of(step.copy, grip) * lengths.inverse_dt_squared),
        limit_(limit_of(step.copy, grip) / lengths.inverse_dt_squared) {}

  void run() {
    for (GripPoint& point : grip_.points) {
      draw(point);
    }
    slide();
  }

 private:
  [[nodiscard]] Index place_of(Index vertex) const { return step_.data.place_of_vertex[vertex]; }

  // 1/kg, to what draws it.
  [[nodiscard]] float yield_of(const GripPoint& point) const {
    float yield = 0;
    for (int k = 0; k < corner_count(point.at); ++k) {
      const float weight = point.at.weights[k];
      yield += weight * weight * vertices_.moving[place_of(point.at.vertices[k])].w;
    }
    return yield + alpha_;
  }

  void draw(GripPoint& point) {
    push(point, draw_of(way_to_jaws(step_, grip_, point), load(point.multiplier), yield_of(point),
                        alpha_));
  }

  void push(GripPoint& point, const Vector& change) {
    if (!is_finite_way(change)) {
      return;
    }
    point.multiplier = vector_of(load(point.multiplier) + change);
    for (int k = 0; k < corner_count(point.at); ++k) {
      const Index place = place_of(point.at.vertices[k]);
      go_on(step_, vertices_, place, (point.at.weights[k] * vertices_.moving[place].w) * change);
    }
  }

  void slide() {
    float stiffness = 0;  // kg
    Vector pull;
    for (const GripPoint& point : grip_.points) {
      stiffness += 1 / yield_of(point);
      pull = pull + load(point.multiplier);
    }
    const GripSlide next(along_pad(grip_, pull), load(grip_.slide), stiffness, limit_);
    if (!next.moves()) {
      return;
    }
    grip_.slide = vector_of(next.slide);
    for (GripPoint& point : grip_.points) {
      push(point, (1 / yield_of(point)) * next.way);
    }
  }

  const StepContext& step_;
  ToolGrip& grip_;
  MovingVertices vertices_;
  float alpha_;  // 1/kg
  float limit_;  // kg m
};

// The patch of points in vertex blocks.
class Patch {
 public:
  Patch(const StepContext& step, Index tool, ToolGrip& grip)
      : step_(step),
        tool_(tool),
        grip_(grip),
        limit_(limit_of(step.copy, grip)),
        reach_(limit_ * compliance_of(step.copy, grip) / static_cast<float>(grip.points.size())) {}

  // Anchors slide to where the pull is at the limit, if it is beyond.
  void slide() { grip_.slide = vector_of(slide_within(mean_way(), reach_)); }

  // Vertices follow while anchors slide.
  void push(const Substep<float>& lengths) {
    const Vector mean = mean_way();
    const float size = length_of(mean);
    if (!(excess_of(size, reach_) > 0)) {
      return;
    }
    const VertexState state = vertex_state(step_, lengths, 1);
    const Vector direction = (1 / size) * mean;
    float force = 0, stiffness = 0;
    for (const GripCorner& corner : grip_.corners) {
      const Index place = step_.data.place_of_vertex[corner.vertex];
      if (!moves(state, place)) {
        continue;
      }
      if (is_held_elsewhere(place)) {
        return;
      }
      const VertexEnergy<float> energy = energy_at(state, place);
      force += corner.share * limit_ + dot(direction, energy.force);
      stiffness += dot(direction, energy * direction);
    }
    const float way = std::min(force / stiffness, size - reach_);
    if (!std::isfinite(way)) {
      return;
    }
    const MovingVertices vertices = moving_vertices(step_);
    for (const GripCorner& corner : grip_.corners) {
      const Index place = step_.data.place_of_vertex[corner.vertex];
      if (moves(state, place)) {
        go_on(step_, vertices, place, way * direction);
      }
    }
    slide();
  }

  void find_multipliers(const Substep<float>& lengths) {
    const float scale = 1 / (compliance_of(step_.copy, grip_) * lengths.inverse_dt_squared);
    for (GripPoint& point : grip_.points) {
      const Vector multiplier = scale * way_to_jaws(step_, grip_, point);
      point.multiplier = vector_of(is_finite_way(multiplier) ? multiplier : Vector{});
    }
  }

 private:
  // m, along the pad, as if nothing slid.
  [[nodiscard]] Vector mean_way() const {
    Vector sum;
    for (const GripPoint& point : grip_.points) {
      const Vector way = way_to_jaws(step_, grip_, point) - load(grip_.slide);
      sum = sum + (is_finite_way(way) ? way : Vector{});
    }
    return along_pad(grip_, (1 / static_cast<float>(grip_.points.size())) * sum);
  }

  [[nodiscard]] bool moves(const VertexState& state, Index place) const {
    return state.displacements[place].w > 0 && !is_lost(state.fixed_points[place]);
  }

  [[nodiscard]] bool is_held_elsewhere(Index place) const {
    const StepScratch& scratch = step_.scratch;
    for (Index h = scratch.first_holds[place]; h != kInvalidIndex; h = scratch.holds[h].next) {
      if (scratch.holds[h].kind != HoldKind::grip || scratch.holds[h].tool != tool_) {
        return true;
      }
    }
    return false;
  }

  // By its inertia and its neighbours.
  [[nodiscard]] VertexEnergy<float> energy_at(const VertexState& state, Index place) const {
    const auto [block_index, lane] = step_.data.vertex_blocks.place_of(place);
    const VertexRows rows = vertex_rows(step_);
    const VertexBlock& block = rows.blocks[block_index];
    const LaneAccess access{state.fixed_points, state.fixed_points[place], lane};
    const Particle& p = state.displacements[place];
    VertexEnergy<float> start;
    start.add_pull(state.inverse_dt_squared / p.w, load(state.flights[place]) - load(p));
    return finite_energy(rows, block, access, start);
  }

  const StepContext& step_;
  Index tool_;
  ToolGrip& grip_;
  float limit_;  // N
  float reach_;  // m, of the mean way at the limit
};

// Calls visit(tool's index, grip) for those that are shut.
template <class Visit>
void for_each_grip(CopyState& copy, const Visit& visit) {
  for (std::size_t t = 0; t < copy.tools.size(); ++t) {
    ToolGrip& grip = copy.tools[t].grip;
    if (!grip.points.empty()) {
      visit(static_cast<Index>(t), grip);
    }
  }
}

// Whether the grip holds other points than before.
bool end_grip(ToolState& tool) {
  ToolGrip& grip = tool.grip;
  const Eigen::Vector3f pull = tool.pose.linear().transpose() * grip.pull;
  if (pull.norm() > grip.limits.tear_strength * grip.width_across(pull)) {
    grip.torn.clear();
    std::ranges::transform(grip.corners, std::back_inserter(grip.torn), &GripCorner::vertex);
    grip.let_go(GripState::torn);
    return true;
  }
  const std::size_t before = grip.points.size();
  std::erase_if(grip.points,
                [&](const GripPoint& point) { return !is_on_pad(grip.limits.pad, point.anchor); });
  if (grip.points.size() < kLeastGripPoints) {
    grip.let_go(GripState::lost);
    return true;
  }
  grip.state = grip.slid > 0 ? GripState::slipping : GripState::holding;
  if (grip.points.size() == before) {
    return false;
  }
  grip.find_corners();
  return true;
}

}  // namespace

void begin_grip(ToolGrip& grip) {
  grip.pull.setZero();
  grip.slid = 0;
  grip.let_go_now = false;
  for (GripPoint& point : grip.points) {
    point.force.setZero();
  }
}

void place_grip(ToolGrip& grip, const ToolPose& pose) {
  grip.normal = pose.linear() * grip.limits.pad.normal;
  grip.slid_before = !grip.slide.isZero(0);
  grip.slide.setZero();
  const GripPose placed = grip_pose(grip, pose);
  for (GripPoint& point : grip.points) {
    point.target = vector_of(placed.place(load(point.anchor)));
    point.multiplier.setZero();
  }
}

GripPose grip_pose(const ToolGrip& grip, const ToolPose& pose) {
  const Eigen::Matrix3f& turn = pose.linear();
  return {{load(Eigen::Vector3f(turn.row(0))), load(Eigen::Vector3f(turn.row(1))),
           load(Eigen::Vector3f(turn.row(2)))},
          load(Eigen::Vector3f(pose.translation())),
          load(grip.normal)};
}

float limit_of(const CopyState& copy, const ToolGrip& grip) noexcept {
  return 2 * grip.limits.friction * grip.limits.clamp_force / copy.factors.stiffness;
}

float compliance_of(const CopyState& copy, const ToolGrip& grip) noexcept {
  return copy.factors.stiffness * grip.limits.compliance;
}

Vec3<float> way_to_jaws(const StepContext& step, const ToolGrip& grip, const GripPoint& point) {
  const MovingVertices vertices = moving_vertices(step);
  Vector from_base = load(point.target) + load(grip.slide);
  Vector displacement;
  for (int k = 0; k < corner_count(point.at); ++k) {
    const Index place = step.data.place_of_vertex[point.at.vertices[k]];
    from_base = from_base - point.at.weights[k] * vertices.base(place);
    displacement = displacement + point.at.weights[k] * load(vertices.moving[place]);
  }
  return from_base - displacement;
}

void project_grips(const StepContext& step, const Substep<float>& lengths) {
  for_each_grip(step.copy, [&](Index, ToolGrip& grip) { Projection(step, grip, lengths).run(); });
}

void begin_grips(const StepContext& step) {
  for_each_grip(step.copy, [&](Index tool, ToolGrip& grip) {
    if (grip.slid_before) {
      Patch(step, tool, grip).slide();
    }
  });
}

void answer_grips(const StepContext& step, const Substep<float>& lengths) {
  for_each_grip(step.copy, [&](Index tool, ToolGrip& grip) {
    Patch patch(step, tool, grip);
    patch.slide();
    patch.push(lengths);
    patch.find_multipliers(lengths);
  });
}

void collect_grip(ToolState& tool, float scale) {
  ToolGrip& grip = tool.grip;
  const Vector slid = grip_pose(grip, tool.placed).in_frame(load(grip.slide));
  Vector sum;
  for (GripPoint& point : grip.points) {
    const Eigen::Vector3f force = scale * point.multiplier;
    feel(force, point.target + grip.slide, tool);
    point.force += force;
    sum = sum + load(force);
    point.anchor += vector_of(slid);
  }
  grip.pull += vector_of(along_pad(grip, sum));
  grip.slid += length_of(load(grip.slide));
}

void end_grips(SolverData& data) {
  bool lets_go = false;
  for (Index i = 0; i < data.copy_count(); ++i) {
    for (std::size_t t = 0; t < data.copy(i).tools.size(); ++t) {
      ToolState& tool = data.copy(i).tools[t];
      if (tool.grip.is_shut() && end_grip(tool)) {
        data.forget_releases(i, static_cast<Index>(t));
        lets_go = true;
      }
    }
  }
  if (lets_go) {
    data.changes.tools = true;
    data.rebuild_plan();
  }
}

}  // namespace pbdsurg
