// SPDX-License-Identifier: Apache-2.0
// The residual that a substep leaves, in double precision and apart from the sweeps: on a copy of
// the state, element by element.
#include "pbdsurg/solver/convergence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/vertex_block.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/host/serial_step.h"
#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/momentum.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/sets/constraint_kinds.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vec3d = Vec3<double>;

double norm(const Vec3d& v) {
  return std::sqrt(dot(v, v));
}

/// A substep whose end is known, and the forces there.
struct Ending {
  std::vector<Vec3d> start, end;  ///< [place] m
  double h;                       ///< s
  std::vector<Vec3d> forces;      ///< [place] N
  std::vector<bool> counts;       ///< [place]

  template <std::size_t kCount>
  void leave_out(const std::array<Index, kCount>& places) {
    for (const Index place : places) {
      counts[place] = false;
    }
  }

  /// A dashpot or a spring along an edge.
  /// @param pull  N, that brings the ends together
  void add_pull(Index a, Index b, double pull) {
    const Vec3d d = end[b] - end[a];
    const double length = norm(d);
    if (length > 0) {
      const Vec3d force = (pull / length) * d;
      forces[a] = forces[a] + force;
      forces[b] = forces[b] - force;
    }
  }
  [[nodiscard]] double length(Index a, Index b) const { return norm(end[b] - end[a]); }
  [[nodiscard]] double lengthened(Index a, Index b) const {
    return length(a, b) - norm(start[b] - start[a]);
  }
};

double volume_of(const std::vector<Vec3d>& x, const Tet& tet) {
  return dot(x[tet[1]] - x[tet[0]], cross(x[tet[2]] - x[tet[0]], x[tet[3]] - x[tet[0]])) / 6;
}

// The energy of vertex blocks, see constraints/vertex_block.h and VertexBlocks.
void add_tet(const VertexTet& tet, Ending& ending) {
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const Index a = tet.vertices[kTetEdges[e][0]];
    const Index b = tet.vertices[kTetEdges[e][1]];
    ending.add_pull(a, b,
                    tet.weights[e] * ending.length(a, b) +
                        tet.edge_damping[e] / ending.h * ending.lengthened(a, b));
  }
  const double volume = volume_of(ending.end, tet.vertices);
  const double pressure =
      tet.stiffness * (volume - tet.target) +
      tet.volume_damping / ending.h * (volume - volume_of(ending.start, tet.vertices));
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto& face = kTetTriangles[corner];
    const auto& x = ending.end;
    const Vec3d& a = x[tet.vertices[face[0]]];
    const Vec3d outward = cross(x[tet.vertices[face[1]]] - a, x[tet.vertices[face[2]]] - a);
    Vec3d& force = ending.forces[tet.vertices[corner]];
    force = force + (pressure / 6) * outward;  // against the gradient of the volume
  }
}

void add_fibre(const VertexTet& tet, Ending& ending) {
  const auto& x = ending.end;
  Vec3d stretched;
  for (std::size_t k = 0; k < 3; ++k) {
    stretched =
        stretched + double{tet.fibre_shares[k]} * (x[tet.vertices[k + 1]] - x[tet.vertices[0]]);
  }
  const double length = norm(stretched);
  if (length <= 1) {
    return;
  }
  const Vec3d pull = (tet.fibre_stiffness * (length - 1) / length) * stretched;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d force = double{tet.fibre_shares[k]} * pull;
    Vec3d &end = ending.forces[tet.vertices[k + 1]], &start = ending.forces[tet.vertices[0]];
    end = end - force;
    start = start + force;
  }
}

void add_triangle(const VertexTriangle& triangle, Ending& ending) {
  const auto& v = triangle.vertices;
  const auto pull_in = [&](const std::vector<Vec3d>& x, std::size_t corner) {
    const Vec3d& own = x[v[corner]];
    return AreaPull<double>(x[v[(corner + 1) % 3]] - own, x[v[(corner + 2) % 3]] - own);
  };
  const double area = pull_in(ending.end, 0).area;
  const double tension = triangle.stiffness * (area - triangle.target) +
                         triangle.area_damping / ending.h * (area - pull_in(ending.start, 0).area);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const Index a = v[(corner + 1) % 3], b = v[(corner + 2) % 3];
    ending.add_pull(a, b,
                    triangle.weights[corner] * ending.length(a, b) +
                        triangle.edge_damping[corner] / ending.h * ending.lengthened(a, b));
    Vec3d& force = ending.forces[v[corner]];
    force = force - tension * pull_in(ending.end, corner).gradient;
  }
}

void add_hinge(const VertexHinge& hinge, Ending& ending) {
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const Index a = hinge.vertices[kTetEdges[e][0]], b = hinge.vertices[kTetEdges[e][1]];
    ending.add_pull(a, b, hinge.weights[e] * ending.length(a, b));
  }
  const Vec3d e = ending.end[hinge.vertices[1]] - ending.end[hinge.vertices[0]];
  const Vec3d left = ending.end[hinge.vertices[2]] - ending.end[hinge.vertices[0]];
  const Vec3d right = ending.end[hinge.vertices[3]] - ending.end[hinge.vertices[0]];
  const Vec3d gradients[4] = {{}, cross(left, right), cross(right, e), cross(e, left)};
  for (std::size_t k = 1; k < 4; ++k) {
    const Vec3d force = double{-hinge.moment} * gradients[k];
    Vec3d &own = ending.forces[hinge.vertices[k]], &first = ending.forces[hinge.vertices[0]];
    own = own + force;
    first = first - force;
  }
  const auto corners_in = [&](const std::vector<Vec3d>& x, Vec3d(&corners)[4]) {
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = x[hinge.vertices[k]];
    }
  };
  Vec3d corners[4];
  if (hinge.stiffness > 0) {
    corners_in(ending.end, corners);
    const auto turn = BendingConstraint::turn(corners, double{hinge.rest});
    for (std::size_t k = 0; k < 4; ++k) {
      Vec3d& force = ending.forces[hinge.vertices[k]];
      force = force - hinge.stiffness * turn.value * turn.gradient[k];
    }
  }
  if (hinge.damping > 0) {
    corners_in(ending.start, corners);
    const auto turning = BendingConstraint::turning(corners);
    double turn = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      turn += turning.shares[k] *
              dot(turning.across, ending.end[hinge.vertices[k]] - ending.start[hinge.vertices[k]]);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      Vec3d& force = ending.forces[hinge.vertices[k]];
      force = force - hinge.damping / ending.h * turn * turning.shares[k] * turning.across;
    }
  }
}

void add_vertex_blocks(const SolverData& data, Ending& ending) {
  for (const VertexTet& tet : data.vertex_blocks.tets()) {
    add_tet(tet, ending);
    if (tet.fibre_stiffness > 0) {
      add_fibre(tet, ending);
    }
  }
  for (const VertexSpring& spring : data.vertex_blocks.springs()) {
    const auto [a, b] = spring.vertices;
    ending.add_pull(a, b,
                    spring.stiffness * (ending.length(a, b) - spring.rest) +
                        spring.limit_stiffness * std::max(0.0, ending.length(a, b) - spring.limit) +
                        spring.damping / ending.h * ending.lengthened(a, b));
  }
  for (const VertexTriangle& triangle : data.vertex_blocks.triangles()) {
    if (triangle.stiffness > 0) {
      add_triangle(triangle, ending);
    }
  }
  for (const VertexHinge& hinge : data.vertex_blocks.hinges()) {
    add_hinge(hinge, ending);
  }
}

// What a projection gives of its whole multiplier where compliance leaves nothing for mobility to
// resist: its force.
template <class Constraint>
void add_projected(const ConstraintRecord<Constraint>& record, Ending& ending) {
  constexpr auto kCount = std::size_t{Constraint::kVertexCount};
  constexpr double kStiff = 1e24;  // 1/s^2
  Vec3d x[kCount];
  double w[kCount];
  Damped<double, Constraint::kVertexCount> damping;
  for (std::size_t k = 0; k < kCount; ++k) {
    x[k] = ending.end[record.places[k]];
    damping.start[k] = ending.start[record.places[k]];
    w[k] = 1;
  }
  double parameters[Constraint::kParameterCount];
  for (std::size_t k = 0; k < std::size(parameters); ++k) {
    parameters[k] = record.parameters[k];
  }
  double multipliers[Constraint::kMultiplierCount] = {};
  const auto moves = Constraint::template move<ProjectionMode::compliance>(
      x, w, parameters, Substep<double>{1 / ending.h, kStiff}, multipliers, damping);
  for (std::size_t k = 0; k < kCount; ++k) {
    Vec3d& force = ending.forces[record.places[k]];
    force = force + kStiff * moves.of[k];
  }
}

template <class Constraint>
inline constexpr bool kHasEnergy = !std::is_same_v<Constraint, StrainLimitConstraint> &&
                                   !std::is_same_v<Constraint, StiffLinkConstraint>;

// Calls visit(record) for those alive.
template <class Constraint, class Visit>
void for_each_record(const ConstraintSlots<Constraint>& slots, const Visit& visit) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    for (const Index id : slots.ids(group)) {
      visit(slots.record(id));
    }
  }
}

// Leaves out what is no spring.
void leave_out_rigid(const SolverData& data, Ending& ending) {
  data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
    for_each_record(slots, [&](const ConstraintRecord<Constraint>& record) {
      bool is_rigid = false;
      if constexpr (std::is_same_v<Constraint, StrainLimitConstraint>) {
        constexpr double kNear = 1 - 1e-5;
        is_rigid = !moves_vertices(data.options) &&
                   ending.length(record.places[0], record.places[1]) >
                       kNear * record.parameters[StrainLimitConstraint::kLimit];
      } else {
        is_rigid = std::is_same_v<Constraint, StiffLinkConstraint> ||
                   !(record.parameters[Constraint::kStiffness] > 0);
      }
      if (is_rigid) {
        ending.leave_out(record.places);
      }
    });
  });
}

void leave_out_held(const SolverData& data, const CopyState& copy, Ending& ending) {
  for (const TissueTouch& touch : copy.touches.contacts) {
    for (const Index place : touch.places) {
      ending.counts[place] = false;
    }
  }
  for (const ToolState& tool : copy.tools) {
    for (const Attachment& attachment : tool.attachments) {
      ending.counts[data.place_of_vertex[attachment.vertex]] = false;
    }
    for (const GripCorner& corner : tool.grip.corners) {
      ending.counts[data.place_of_vertex[corner.vertex]] = false;
    }
    for (const Contact& contact : tool.contacts) {
      ending.counts[contact.place] = false;
    }
    for (const SurfaceContact& contact : tool.surface_contacts) {
      for (int k = 0; k < contact.feature.count(); ++k) {
        ending.counts[contact.feature.places[k]] = false;
      }
    }
  }
}

// A step for the time of a substep.
class OneSubstep {
 public:
  OneSubstep(SolverData& data, float h, int sweeps) : data_(data), before_(data.part) {
    data.part = whole_step(h, {1, sweeps});
  }
  ~OneSubstep() { data_.part = before_; }
  OneSubstep(const OneSubstep&) = delete;
  OneSubstep& operator=(const OneSubstep&) = delete;

 private:
  SolverData& data_;
  StepPart before_;
};

}  // namespace

std::vector<Convergence> Solver::convergence(float dt, Index copy) {
  SolverData& data = *data_;
  const CopyState& now = checked_copy(data, copy);
  if (data.options.mode == ProjectionMode::fraction) {
    throw InvalidArgument(
        "fraction mode has no elastic forces: what it solves depends on the sweeps");
  }
  if (is_explicit(data.options)) {
    throw InvalidArgument("explicit steps solve no system that could leave a residual");
  }
  check_step(dt);
  data.fetch_state(copy);
  const StepDivision division = divide_step(dt, data.rule_of_copies(), data.options);
  const float h = dt / static_cast<float>(division.substeps);

  data.custom.begin_step(data);
  data.refresh_surfaces();
  CopyState probe = now;
  for (ToolState& tool : probe.tools) {
    tool.stay();
  }
  StepScratch scratch;
  scratch.fit_beside(data);
  {
    const OneSubstep one(data, h, division.sweeps);
    StepReport report;
    step_serially({data, probe, scratch, copy, true}, report);
  }
  data.custom.rethrow();

  const std::size_t count = now.particles.size();
  const SubstepNumbers numbers = substep_numbers(data, now, h, 0);
  const auto departure_of = [&](Index place) {
    const Departure<float> departure{load(now.velocities[place]), load(now.carries[place])};
    return now.ways.empty()
               ? departure
               : departure_after(departure, now.particles[place].w, numbers.past_share,
                                 load(now.ways[place]), load(now.velocities_before[place]));
  };
  const double reach = numbers.motion.h;
  Ending ending{std::vector<Vec3d>(count), std::vector<Vec3d>(count), reach,
                std::vector<Vec3d>(count), std::vector<bool>(count)};
  for (std::size_t place = 0; place < count; ++place) {
    const Vec3d base = to_double(load(now.particles[place]));
    ending.start[place] = base + to_double(departure_of(static_cast<Index>(place)).rounding);
    ending.end[place] = base + to_double(load(scratch.displacements[place]));
    ending.counts[place] = now.particles[place].w > 0;
  }
  leave_out_held(data, probe, ending);
  for (const Index place : data.custom.places()) {
    ending.counts[place] = false;
  }
  leave_out_rigid(data, ending);
  if (data.options.method == SolverMethod::vertex_block) {
    add_vertex_blocks(data, ending);
  } else {
    data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
      if constexpr (kHasEnergy<Constraint>) {
        for_each_record(slots, [&](const auto& record) { add_projected(record, ending); });
      }
    });
  }

  // what drag adds to BDF2's inertia
  const double drag = has_past(data.options) ? 1 + double{data.options.damping} * reach : 1;
  const double inertia = drag * double{now.factors.density} / (ending.h * ending.h);
  const double stiffness = now.factors.stiffness;
  std::vector<Convergence> bodies(data.tissue->bodies().size());
  for (std::size_t v = 0; v < count; ++v) {
    const Index place = data.place_of_vertex[v];
    if (!ending.counts[place]) {
      continue;
    }
    const float w = now.particles[place].w;
    const Departure<float> departure = departure_of(place);
    const FreeMotion<float> motion =
        flying_motion(now, falling_motion(data, numbers.motion, place), place);
    const Vec3d flight = to_double(
        flight_of(motion, departure.rounding, flying_velocity(motion, departure.velocity, w)));
    const Vec3d way = to_double(load(scratch.displacements[place]));
    const Vec3d force = stiffness * ending.forces[place];
    const Vec3d residual = (inertia / double{w}) * (flight - way) + force;
    Convergence& body = bodies[data.tissue->body_of_vertex(static_cast<Index>(v))];
    body.residual += dot(residual, residual);
    body.elastic += dot(force, force);
    ++body.vertex_count;
  }
  for (Convergence& body : bodies) {
    body.residual = std::sqrt(body.residual);
    body.elastic = std::sqrt(body.elastic);
  }
  return bodies;
}

}  // namespace pbdsurg
