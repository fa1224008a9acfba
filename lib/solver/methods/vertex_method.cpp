// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_method.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/base/describe.h"
#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/vertex_elements.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

VertexEnergy<float> energy_of(const EnergyBlock& block, Index lane) {
  VertexEnergy<float> energy;
  energy.force = {block.force[0][lane], block.force[1][lane], block.force[2][lane]};
  energy.isotropic = block.isotropic[lane];
  energy.xx = block.squares[0][lane];
  energy.yy = block.squares[1][lane];
  energy.zz = block.squares[2][lane];
  energy.xy = block.squares[3][lane];
  energy.xz = block.squares[4][lane];
  energy.yz = block.squares[5][lane];
  return energy;
}

bool has_stiffness(float compliance) noexcept {
  return compliance > 0 && std::isfinite(1 / compliance);
}

std::string compliance_problem(const Body& body, const char* which, float compliance) {
  return "body '" + body.name + "': " + which + " compliance is " + std::to_string(compliance) +
         "; the vertex-block method needs > 0";
}

// Why the method cannot step bodies as options ask.
std::optional<std::string> problem_of(std::span<const Body> bodies, const SolverOptions& options) {
  if (options.mode == ProjectionMode::fraction) {
    return is_explicit(options)
               ? "explicit steps follow forces; fraction mode has none"
               : "the vertex-block method minimises an energy; fraction mode has none";
  }
  if (options.coloring.max_colors != 0) {
    return "max_colors is " + std::to_string(options.coloring.max_colors) +
           "; the vertex-block method needs all its colours: 0";
  }
  if (options.composition == PlanComposition::joint) {
    return "a joint composition is of constraints; the vertex-block method has none";
  }
  if (options.device_strategy == DeviceStrategy::cluster) {
    return "device_strategy is cluster, which sweeps constraints; the vertex-block method takes "
           "automatic, stream, graph and cooperative";
  }
  for (const Body& body : bodies) {
    const Material& material = body.material;
    if (is_explicit(options) && material.damping > 0) {
      return "body '" + body.name + "': damping is " + describe(material.damping) +
             " s; explicit steps have no inner friction: 0";
    }
    if (is_explicit(options) && is_sheet(body)) {
      return "body '" + body.name +
             "' is a sheet, whose frequencies explicit steps do not know: vertex blocks and "
             "projections take it";
    }
    if (body.tet_count == 0 || material.model != ElasticModel::springs) {
      continue;
    }
    if (!has_stiffness(material.stretch.compliance)) {
      return compliance_problem(body, "stretch", material.stretch.compliance);
    }
    if (material.has_volume_constraints && !has_stiffness(material.volume.compliance)) {
      return compliance_problem(body, "volume", material.volume.compliance);
    }
  }
  return std::nullopt;
}

// With those that the worker has of its own.
template <class Rows>
Rows of_worker(Rows rows, StepScratch& scratch) noexcept {
  if (scratch.has_own_rows) {
    rows.springs = scratch.springs.data();
    rows.volumes = scratch.volumes.data();
    rows.hinges = scratch.hinges.data();
    rows.strips = scratch.strips.data();
    rows.triangles = scratch.triangles.data();
  }
  return rows;
}

}  // namespace

SolverMethod method_for(std::span<const Body> bodies, const SolverOptions& options) {
  if (options.method != SolverMethod::automatic) {
    return options.method;
  }
  return problem_of(bodies, options) ? SolverMethod::projection : SolverMethod::vertex_block;
}

void check_vertex_method(std::span<const Body> bodies, const SolverOptions& options) {
  if (!moves_vertices(options)) {
    return;
  }
  if (const std::optional<std::string> problem = problem_of(bodies, options)) {
    throw InvalidArgument(*problem);
  }
}

ColoringOptions vertex_coloring(const SolverOptions& options) {
  ColoringOptions coloring = options.coloring;
  if (coloring.algorithm == ColoringAlgorithm::greedy && coloring.order == GreedyOrder::natural) {
    coloring.order = GreedyOrder::saturation;
  }
  return coloring;
}

VertexBlocks make_vertex_blocks(const SolverData& data, std::vector<VertexTet> tets) {
  if (!moves_vertices(data.options)) {
    return {};
  }
  const Tissue& tissue = *data.tissue;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    tets[t].vertices = data.places_of(tissue.tets()[t]);
    set_fibre(data, static_cast<Index>(t), tets[t]);
  }
  std::vector<VertexSpring> springs(static_cast<std::size_t>(data.sets.distance_ids.count()));
  for (Index e = 0; e < static_cast<Index>(tissue.edges().size()); ++e) {
    springs[data.sets.distance_ids.of_edge(e)] = edge_spring(data, tissue, e);
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    springs[data.sets.distance_ids.of_link(l)] = link_spring(data, tissue, l);
  }
  std::vector<VertexHinge> hinges;
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    hinges.push_back(vertex_hinge(data, tissue, h));
  }
  std::vector<VertexTriangle> triangles;
  for (Index t = 0; t < static_cast<Index>(tissue.triangles().size()); ++t) {
    triangles.push_back(vertex_triangle(data, tissue, t));
  }
  const float unit = choose_unit(tissue, tets, springs);
  std::vector<bool> moves;
  for (const Particle& p : data.particles) {
    moves.push_back(p.w > 0);
  }
  VertexBlocks blocks(moves, std::move(tets), std::move(springs), std::move(hinges),
                      vertex_coloring(data.options), unit, is_explicit(data.options),
                      std::move(triangles));
  blocks.reserve(data.options.spare);
  return blocks;
}

VertexRows vertex_rows(const StepContext& step) noexcept {
  return of_worker(step.data.vertex_blocks.rows(), step.scratch);
}

DampedRows damped_rows(const StepContext& step) noexcept {
  return of_worker(step.data.vertex_blocks.damped_rows(), step.scratch);
}

void drop_holds(const StepContext& step) noexcept {
  StepScratch& scratch = step.scratch;
  for (const VertexHold& hold : scratch.holds) {
    scratch.first_holds[hold.place] = kInvalidIndex;
    scratch.held[step.data.vertex_blocks.place_of(hold.place).block] = 0;
  }
  scratch.holds.clear();
  scratch.gives.clear();
}

void gather_holds(const StepContext& step) {
  drop_holds(step);
  StepScratch& scratch = step.scratch;
  const VertexBlocks& blocks = step.data.vertex_blocks;
  const auto add = [&](Index place, Index tool, std::size_t entry, HoldKind kind, int corner = 0) {
    const Index block = blocks.place_of(place).block;
    if (block == kInvalidIndex) {
      return;  // fixed, and so no tool's business
    }
    scratch.held[block] |= blocks.lanes_of(place);
    scratch.holds.push_back(
        {place, scratch.first_holds[place], tool, static_cast<Index>(entry), kind, corner});
    scratch.first_holds[place] = static_cast<Index>(scratch.holds.size()) - 1;
  };
  for (Index t = 0; t < static_cast<Index>(step.copy.tools.size()); ++t) {
    const ToolState& tool = step.copy.tools[t];
    for (std::size_t a = 0; a < tool.attachments.size(); ++a) {
      add(step.data.place_of_vertex[tool.attachments[a].vertex], t, a, HoldKind::grasp);
    }
    for (std::size_t p = 0; p < tool.grip.points.size(); ++p) {
      const TissuePoint& point = tool.grip.points[p].at;
      for (int corner = 0; corner < corner_count(point); ++corner) {
        if (point.weights[corner] > 0) {
          add(step.data.place_of_vertex[point.vertices[corner]], t, p, HoldKind::grip, corner);
        }
      }
    }
    for (std::size_t c = 0; c < tool.contacts.size(); ++c) {
      add(tool.contacts[c].place, t, c, HoldKind::contact);
    }
    for (std::size_t c = 0; c < tool.surface_contacts.size(); ++c) {
      const ContactFeature& feature = tool.surface_contacts[c].feature;
      for (int corner = 0; corner < feature.count(); ++corner) {
        add(feature.places[corner], t, c, HoldKind::surface_contact, corner);
      }
    }
  }
  const std::vector<TissueTouch>& touches = step.copy.touches.contacts;
  for (std::size_t c = 0; c < touches.size(); ++c) {
    for (int corner = 0; corner < TissueTouch::kCorners; ++corner) {
      if (touches[c].weights[corner] != 0) {
        add(touches[c].places[corner], kInvalidIndex, c, HoldKind::touch, corner);
      }
    }
  }
  scratch.gives.resize(scratch.holds.size());
  begin_grips(step);
}

void damp_rows(const StepContext& step, float inverse_dt) {
  if (!step.data.vertex_blocks.has_damping()) {
    return;
  }
  add_damping(damped_rows(step), step.data.vertex_blocks.block_count(), step.copy.particles,
              step.copy.carries, inverse_dt);
}

float relaxation_of(float over_relaxation, int sweep, int sweep_count) noexcept {
  return sweep + 1 < sweep_count ? over_relaxation : 1.0F;
}

VertexState vertex_state(const StepContext& step, const Substep<float>& substep,
                         float relaxation) noexcept {
  StepScratch& scratch = step.scratch;
  return {step.copy.particles.data(),
          scratch.displacements.data(),
          scratch.fixed_points.data(),
          scratch.flights.data(),
          scratch.held.data(),
          step.data.vertex_blocks.unit(),
          substep.inverse_dt_squared,
          relaxation,
          has_custom(step) ? scratch.guards.data() : nullptr};
}

void solve_lanes(const StepContext& step, const VertexState& state, Index block_index,
                 LaneBits lanes, const EnergyBlock* energies) {
  const VertexRows rows = vertex_rows(step);
  const VertexBlock& block = rows.blocks[block_index];
  const std::vector<Index>& first_holds = step.scratch.first_holds;
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    const ParticleOffset corner = block.corners[lane];
    Particle& p = at(state.displacements, corner);
    if ((lanes >> lane & 1) == 0 || !(p.w > 0)) {
      continue;  // not asked for, or without tissue
    }
    const Index v = place_at(corner);
    const Vec3<float> u = load(p);
    FixedPoint& point = at(state.fixed_points, corner);
    const LaneAccess access{state.fixed_points, point, lane};
    const Particle& flight = state.flights[v];
    VertexEnergy<float> start;
    start.add_pull(state.inverse_dt_squared / p.w, load(flight) - u);
    if (state.guards != nullptr) {
      start.isotropic = start.isotropic + state.guards[block_index].stiffness[lane];
    }
    const float relaxation = state.relaxation < flight.w ? state.relaxation : flight.w;
    const auto solve = [&](VertexEnergy<float> energy) {
      if (first_holds[v] == kInvalidIndex) {
        return relaxation * VertexFactor<float>(energy).solve(energy.force);
      }
      const HeldVertex held(step, {load(at(state.bases, corner)), u}, first_holds[v]);
      held.add_surface_contacts(state.inverse_dt_squared, energy);
      return move_held(held, energy, 1 / state.inverse_dt_squared);
    };
    const Vec3<float> moved =
        u + (is_lost(point) ? move_vertex(rows, VertexBlock{}, access, start, solve)
             : energies == nullptr
                 ? move_vertex(rows, block, access, start, solve)
                 : move_vertex(rows, block, access, start, energy_of(*energies, lane), solve));
    store(p, moved);
    point = moved_point(point, u, moved);
  }
}

void push_lanes(const StepContext& step, const VertexState& state, Index block_index,
                LaneBits lanes) {
  const VertexRows rows = vertex_rows(step);
  const VertexBlock& block = rows.blocks[block_index];
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    const ParticleOffset corner = block.corners[lane];
    Particle& p = at(state.displacements, corner);
    if ((lanes >> lane & 1) == 0 || !(p.w > 0)) {
      continue;  // not asked for, or without tissue
    }
    const FixedPoint& point = at(state.fixed_points, corner);
    const LaneAccess access{state.fixed_points, point, lane};
    const VertexBlock seen = is_lost(point) ? VertexBlock{} : block;
    VertexForce<float> sum;
    add_tree(rows, seen, access, sum);
    const Vec3<float> force = finite_force(rows, seen, access, sum);
    const Vec3<float> u = load(p);
    const Vec3<float> flight = load(at(state.flights, corner));
    const Index first_hold = step.scratch.first_holds[place_at(corner)];
    const Vec3<float> moved =
        first_hold == kInvalidIndex
            ? flight + pushed_flight(force, p.w, state.inverse_dt_squared)
            : u + move_held(HeldVertex(step, {load(at(state.bases, corner)), u}, first_hold),
                            pushed_energy(flight - u, force, state.inverse_dt_squared / p.w),
                            1 / state.inverse_dt_squared);
    if (is_finite_way(moved)) {
      store(p, moved);
    }
  }
}

void push_vertices(const StepContext& step, const VertexState& state) {
  for (Index block = 0; block < step.data.vertex_blocks.block_count(); ++block) {
    push_lanes(step, state, block, ~LaneBits{0});
  }
}

void find_residuals(const StepContext& step, const VertexState& state, Index block_index) {
  const VertexRows rows = vertex_rows(step);
  const VertexBlock& block = rows.blocks[block_index];
  for (Index lane = 0; lane < block.lane_count; ++lane) {
    const ParticleOffset corner = block.corners[lane];
    const Particle& p = at(state.displacements, corner);
    const FixedPoint& point = at(state.fixed_points, corner);
    VertexForce<float> sum;
    add_tree(rows, block, LaneAccess{state.fixed_points, point, lane}, sum);
    const Vec3<float> residual =
        (state.inverse_dt_squared / p.w) * (load(at(state.flights, corner)) - load(p)) + sum.force;
    const bool is_held = (state.left_out[block_index] >> lane & 1) != 0;
    at(step.scratch.coarse.residuals.data(), corner) =
        p.w > 0 && !is_held && !is_lost(point) && is_finite_way(residual)
            ? Particle{residual.x, residual.y, residual.z, 1}
            : Particle{};
  }
}

bool has_holds_to_settle(const StepContext& step) noexcept {
  return !step.scratch.holds.empty() && (has_stiff_links(step.data.plan) || has_custom(step));
}

void settle_holds(const StepContext& step, const VertexState& state,
                  const Substep<float>& lengths) {
  const std::vector<LaneBits>& held = step.scratch.held;
  for (Index block = 0; block < step.data.vertex_blocks.block_count(); ++block) {
    if (held[block] != 0) {  // blocks lie in the order of colours
      solve_lanes(step, state, block, held[block]);
    }
  }
  answer_grips(step, lengths);
}

void solve_vertices(const StepContext& step, const VertexState& state, Index color) {
  const auto [first, count] = step.data.vertex_blocks.blocks(color);
  for (Index block = first; block < first + count; ++block) {
    solve_lanes(step, state, block, ~LaneBits{0});
  }
}

}  // namespace pbdsurg
