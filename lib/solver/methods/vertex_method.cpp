// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_method.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ranges>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "lib/base/describe.h"
#include "lib/solver/host/lane_access.h"
#include "lib/solver/methods/held_vertex.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Dashpots of c = this share of mu V0 / l^2 along the edges of tetrahedra that lie in all
// directions alike resist shear with the modulus mu, and a change of volume as if both Lame
// parameters were mu. A lattice of cubes is not that isotropic: up to a third more along its axes,
// and less in shear.
constexpr double kEdgeDampingShare = 2.5;

struct Moduli {
  double mu, lambda;  // Pa, as NeoHookeanTerms takes them
};

Moduli moduli_of(const Material& material) {
  const double youngs_modulus = material.youngs_modulus;
  const double ratio = material.poissons_ratio;
  const double mu = youngs_modulus / (2 * (1 + ratio));
  return {mu, 2 * mu * ratio / (1 - 2 * ratio) + mu};
}

bool is_used(const SolverData& data) {
  return moves_vertices(data.options);
}

VertexTet make_neo_hookean(const std::array<Vec3<double>, 4>& rest, const Material& material) {
  const auto [mu, lambda] = moduli_of(material);
  const Vec3<double> x[4] = {rest[0], rest[1], rest[2], rest[3]};
  const NeoHookeanTerms<double> terms = NeoHookeanTerms<double>::at_rest(x, mu, lambda);
  VertexTet tet;
  std::copy(std::begin(terms.weights), std::end(terms.weights), tet.weights.begin());
  tet.stiffness = static_cast<float>(terms.stiffness);
  tet.target = static_cast<float>(terms.target);
  const double volume = terms.target / (1 + mu / lambda);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const Vec3<double> side = x[kTetEdges[e][0]] - x[kTetEdges[e][1]];
    tet.edge_damping[e] =
        static_cast<float>(kEdgeDampingShare * material.damping * mu * volume / dot(side, side));
  }
  tet.volume_damping =
      material.damping * std::max(0.0F, static_cast<float>(1 - 2 * mu / lambda)) * tet.stiffness;
  return tet;
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

VertexTet make_volume(const ConstraintRecord<VolumeConstraint>& record) {
  VertexTet tet;
  tet.stiffness = 1 / record.parameters[VolumeConstraint::kStiffness];
  tet.target = record.parameters[VolumeConstraint::kRest];
  tet.volume_damping = record.parameters[VolumeConstraint::kDamping] * tet.stiffness;
  return tet;
}

VertexTet make_neo_hookean(const ConstraintRecord<NeoHookeanConstraint>& record,
                           const Material& material) {
  const Eigen::Matrix3d sides = rest_sides(record);
  std::array<Vec3<double>, 4> rest{};
  for (int k = 0; k < 3; ++k) {
    rest[k + 1] = {sides(0, k), sides(1, k), sides(2, k)};
  }
  return make_neo_hookean(rest, material);
}

struct StretchLimit {
  float stiffness = 0;  // N/m; zero for none
  float length = 0;     // m
};

// Beyond its limit, an edge is as stiff as a bar of its tissue that is as wide as the edge is long.
StretchLimit limit_of(const Tissue& tissue, const ConstraintData& sets, Index edge) {
  const auto& limits = sets.of<StrainLimitConstraint>();
  if (!limits.is_alive(edge)) {
    return {};
  }
  const float length = limits.record(edge).parameters[StrainLimitConstraint::kLimit];
  const Material& material =
      tissue.bodies()[tissue.body_of_vertex(tissue.edges()[edge][0])].material;
  return {material.model == ElasticModel::neo_hookean
              ? material.youngs_modulus * (length / material.max_stretch)
              : 1 / material.stretch.compliance,
          length};
}

VertexSpring spring_of(const SolverData& data, Index distance, const Edge& ends) {
  VertexSpring spring{.vertices = data.places_of(ends)};
  if (data.sets.of<DistanceConstraint>().is_alive(distance)) {
    const auto& numbers = data.sets.of<DistanceConstraint>().record(distance).parameters;
    spring.stiffness = 1 / numbers[DistanceConstraint::kStiffness];
    spring.rest = numbers[DistanceConstraint::kRest];
    spring.damping = numbers[DistanceConstraint::kDamping] * spring.stiffness;
  }
  return spring;
}

VertexSpring edge_spring(const SolverData& data, const Tissue& tissue, Index edge) {
  VertexSpring spring = spring_of(data, data.sets.distance_ids.of_edge(edge), tissue.edges()[edge]);
  const StretchLimit limit = limit_of(tissue, data.sets, edge);
  spring.limit_stiffness = limit.stiffness;
  spring.limit = limit.length;
  return spring;
}

VertexSpring link_spring(const SolverData& data, const Tissue& tissue, Index link) {
  const Link& ends = tissue.links()[link];
  VertexSpring spring =
      spring_of(data, data.sets.distance_ids.of_link(link), {ends.first, ends.second});
  if (data.sets.of<StiffLinkConstraint>().is_alive(link)) {
    spring.stiffness = spring.damping = 0;  // it has phases of its own
  }
  return spring;
}

VertexHinge vertex_hinge(const SolverData& data, const Tissue& tissue, Index id) {
  VertexHinge hinge{.vertices = data.places_of(tissue.hinges()[id].vertices)};
  const auto& bendings = data.sets.of<BendingConstraint>();
  if (bendings.is_alive(id)) {
    const auto& numbers = bendings.record(id).parameters;
    hinge.stiffness = 1 / numbers[BendingConstraint::kStiffness];
    hinge.rest = numbers[BendingConstraint::kRest];
    hinge.damping = numbers[BendingConstraint::kDamping] * hinge.stiffness;
  }
  return hinge;
}

// m, about that of a tetrahedron of such a volume.
double edge_of(double volume) {
  return 2 * std::cbrt(volume);
}

// Neighbours may be apart by so many of the longest edges or links, along each axis: beyond, fixed
// points wrap around and forces are wrong. An edge's length is then as exact as a float.
constexpr double kMostStretch = 128;

// Such that they may: a power of two.
float choose_unit(const Tissue& tissue, std::span<const VertexTet> tets,
                  std::span<const VertexSpring> springs) {
  const std::span<const Eigen::Vector3d> x = tissue.rest_positions();
  double longest = 0;
  for (Index e = 0; e < static_cast<Index>(tissue.edges().size()); ++e) {
    const Edge& edge = tissue.edges()[e];
    longest = std::max(longest, tissue.is_edge_alive(e) ? (x[edge[0]] - x[edge[1]]).norm() : 0);
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    const Link& link = tissue.links()[l];
    longest =
        std::max(longest, tissue.is_link_alive(l) ? (x[link.first] - x[link.second]).norm() : 0);
  }
  for (const VertexSpring& spring : springs) {
    longest = std::max(longest, static_cast<double>(spring.rest));
  }
  for (const VertexTet& tet : tets) {
    longest = std::max(longest, edge_of(tet.target));
  }
  return longest > 0
             ? static_cast<float>(std::exp2(std::ceil(std::log2(kMostStretch * longest)) - 31))
             : kUsualUnit;
}

// At least, for what an edit makes this long: a power of two times what it was.
float wide_enough(float unit, double length) {
  while (kMostStretch * length > 0x1p31 * unit) {
    unit *= 2;
  }
  return unit;
}

// Vertices that come in an edit, as a share of all: beyond, rows are laid out anew, in the colours
// of a fresh start.
constexpr double kMostNewVertices = 0.25;

// For what an edit brings.
float unit_for_new(const Tissue& tissue, const TissueChange& change, float unit,
                   std::span<const VertexTet> tets, std::span<const VertexSpring> springs) {
  const std::span<const Eigen::Vector3d> x = tissue.rest_positions();
  double longest = 0;
  for (auto e = static_cast<std::size_t>(change.first_new_edge); e < tissue.edges().size(); ++e) {
    const Edge& edge = tissue.edges()[e];
    longest = std::max(longest, (x[edge[0]] - x[edge[1]]).norm());
  }
  for (auto l = static_cast<std::size_t>(change.first_new_link); l < tissue.links().size(); ++l) {
    const Link& link = tissue.links()[l];
    longest = std::max(longest, (x[link.first] - x[link.second]).norm());
  }
  for (const VertexSpring& spring : springs) {
    longest = std::max(longest, double{spring.rest});
  }
  for (const VertexTet& tet : tets) {
    longest = std::max(longest, edge_of(tet.target));
  }
  return wide_enough(unit, longest);
}

// With those that the worker has of its own.
template <class Rows>
Rows of_worker(Rows rows, StepScratch& scratch) noexcept {
  if (scratch.has_own_rows) {
    rows.springs = scratch.springs.data();
    rows.volumes = scratch.volumes.data();
    rows.hinges = scratch.hinges.data();
    rows.strips = scratch.strips.data();
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

std::vector<VertexTet> vertex_tets_at_rest(const Tissue& tissue) {
  const std::span<const Eigen::Vector3d> positions = tissue.rest_positions();
  std::vector<VertexTet> tets(tissue.tets().size());
  for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
    if (!tissue.is_tet_alive(t)) {
      continue;
    }
    const Material& material = tissue.bodies()[tissue.body_of_tet(t)].material;
    if (material.model == ElasticModel::neo_hookean) {
      std::array<Vec3<double>, 4> rest;
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d& x = positions[tissue.tets()[t][k]];
        rest[k] = {x.x(), x.y(), x.z()};
      }
      tets[t] = make_neo_hookean(rest, material);
    } else if (material.has_volume_constraints) {
      tets[t].stiffness = 1 / material.volume.compliance;
      tets[t].target = static_cast<float>(tet_volume(positions, tissue.tets()[t]));
      tets[t].volume_damping = material.damping * tets[t].stiffness;
    }
  }
  return tets;
}

VertexBlocks make_vertex_blocks(const SolverData& data, std::vector<VertexTet> tets) {
  if (!is_used(data)) {
    return {};
  }
  const Tissue& tissue = *data.tissue;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    tets[t].vertices = data.places_of(tissue.tets()[t]);
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
  const float unit = choose_unit(tissue, tets, springs);
  std::vector<bool> moves;
  for (const Particle& p : data.particles) {
    moves.push_back(p.w > 0);
  }
  VertexBlocks blocks(moves, std::move(tets), std::move(springs), std::move(hinges),
                      vertex_coloring(data.options), unit, is_explicit(data.options));
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
}

void gather_holds(const StepContext& step) {
  drop_holds(step);
  StepScratch& scratch = step.scratch;
  const VertexBlocks& blocks = step.data.vertex_blocks;
  const auto add = [&](Index place, std::size_t tool, std::size_t entry, bool is_contact) {
    const Index block = blocks.place_of(place).block;
    if (block == kInvalidIndex) {
      return;  // fixed, and so no tool's business
    }
    scratch.held[block] |= blocks.lanes_of(place);
    scratch.holds.push_back({place, scratch.first_holds[place], static_cast<Index>(tool),
                             static_cast<Index>(entry), is_contact});
    scratch.first_holds[place] = static_cast<Index>(scratch.holds.size()) - 1;
  };
  for (std::size_t t = 0; t < step.copy.tools.size(); ++t) {
    const ToolState& tool = step.copy.tools[t];
    for (std::size_t a = 0; a < tool.attachments.size(); ++a) {
      add(step.data.place_of_vertex[tool.attachments[a].vertex], t, a, false);
    }
    for (std::size_t c = 0; c < tool.contacts.size(); ++c) {
      add(tool.contacts[c].place, t, c, true);
    }
  }
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
  return {step.copy.particles.data(),  scratch.displacements.data(),
          scratch.fixed_points.data(), scratch.flights.data(),
          scratch.held.data(),         step.data.vertex_blocks.unit(),
          substep.inverse_dt_squared,  relaxation};
}

void solve_lanes(const StepContext& step, const VertexState& state, Index block_index,
                 LaneBits lanes) {
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
    const float relaxation = state.relaxation < flight.w ? state.relaxation : flight.w;
    const auto solve = [&](const VertexEnergy<float>& energy) {
      return first_holds[v] == kInvalidIndex
                 ? relaxation * VertexFactor<float>(energy).solve(energy.force)
                 : move_held(HeldVertex(step, {load(at(state.bases, corner)), u}, first_holds[v]),
                             energy, 1 / state.inverse_dt_squared);
    };
    const Vec3<float> moved =
        u + move_vertex(rows, is_lost(point) ? VertexBlock{} : block, access, start, solve);
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

bool has_holds_to_settle(const StepContext& step) noexcept {
  return !step.scratch.holds.empty() && has_stiff_links(step.data.plan);
}

void settle_holds(const StepContext& step, const VertexState& state) {
  const std::vector<LaneBits>& held = step.scratch.held;
  for (Index block = 0; block < step.data.vertex_blocks.block_count(); ++block) {
    if (held[block] != 0) {  // blocks lie in the order of colours
      solve_lanes(step, state, block, held[block]);
    }
  }
}

void solve_vertices(const StepContext& step, const VertexState& state, Index color) {
  const auto [first, count] = step.data.vertex_blocks.blocks(color);
  for (Index block = first; block < first + count; ++block) {
    solve_lanes(step, state, block, ~LaneBits{0});
  }
}

void VertexFollower::validate(const Tissue&, const TopologyEdit& edit) const {
  check_vertex_method(edit.new_bodies.bodies(), data_.options);
}

void VertexFollower::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  if (!is_used(data_)) {
    return;
  }
  VertexBlocks& blocks = data_.vertex_blocks;
  blocks.begin_edit();
  before_growth_.reset();
  has_grown_ = change.adds();
  double longest = 0;  // m, of what is there now
  for (const RestLengthChange& rest : change.edit.rest_lengths) {
    blocks.set_spring_rest(data_.sets.distance_ids.of_edge(rest.edge), rest.rest_length);
    set_limit(tissue, rest.edge);
    longest = std::max(longest, double{rest.rest_length});
  }
  for (const RestVolumeChange& rest : change.edit.rest_volumes) {
    set_rest_volume(tissue, rest);
    for (const Index edge : tissue.tet_edges()[rest.tet]) {
      set_limit(tissue, edge);
    }
    longest = std::max(longest, edge_of(rest.rest_volume));
  }
  remove(change);
  if (has_grown_ && !grow(tissue, change)) {
    regrow(tissue, change);
  }
  blocks.set_unit(wide_enough(blocks.unit(), longest));
  refresh();
}

// What came and went in one edit, it has never had.
void VertexFollower::remove(const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  const auto remove = [](const auto& ids, const auto& known, const auto& remove_one) {
    for (const Index id : ids) {
      if (id < static_cast<Index>(known.size())) {
        remove_one(id);
      }
    }
  };
  const auto remove_springs = [&](const std::vector<Index>& ids, const auto& id_of) {
    remove(ids | std::views::transform(id_of), blocks.springs(),
           [&](Index spring) { blocks.remove_spring(spring); });
  };
  remove(change.removed_tets, blocks.tets(), [&](Index tet) { blocks.remove_tet(tet); });
  remove_springs(change.removed_edges,
                 [&](Index edge) { return data_.sets.distance_ids.of_edge(edge); });
  remove_springs(change.removed_links,
                 [&](Index link) { return data_.sets.distance_ids.of_link(link); });
  remove(change.removed_hinges, blocks.hinges(), [&](Index hinge) { blocks.remove_hinge(hinge); });
}

void VertexFollower::set_limit(const Tissue& tissue, Index edge) {
  const StretchLimit limit = limit_of(tissue, data_.sets, edge);
  const Index distance = data_.sets.distance_ids.of_edge(edge);
  const auto known = static_cast<Index>(data_.vertex_blocks.springs().size());
  if (limit.stiffness > 0 && distance < known) {  // else it is new, and comes with others
    data_.vertex_blocks.set_limit(distance, limit.stiffness, limit.length);
  }
}

void VertexFollower::set_rest_volume(const Tissue& tissue, const RestVolumeChange& rest) {
  const Material& material = tissue.bodies()[tissue.body_of_tet(rest.tet)].material;
  VertexTet terms = data_.vertex_blocks.tet(rest.tet);
  if (material.model == ElasticModel::neo_hookean) {
    const auto [mu, lambda] = moduli_of(material);
    NeoHookeanTerms<double> before{};
    std::copy(terms.weights.begin(), terms.weights.end(), before.weights);
    before.stiffness = terms.stiffness;
    before.target = terms.target;
    const double ratio = rest.rest_volume * (1 + mu / lambda) / before.target;
    const NeoHookeanTerms<double> after = before.resized(ratio);
    std::copy(std::begin(after.weights), std::end(after.weights), terms.weights.begin());
    terms.stiffness = static_cast<float>(after.stiffness);
    terms.target = static_cast<float>(after.target);
    terms.volume_damping /= static_cast<float>(ratio);
    for (float& damping : terms.edge_damping) {
      damping *= static_cast<float>(std::cbrt(ratio));
    }
  } else {
    terms.target = rest.rest_volume;
  }
  data_.vertex_blocks.set_tet(rest.tet, terms);
}

VertexTet VertexFollower::new_tet(const Tissue& tissue, Index id) const {
  const auto& volumes = data_.sets.of<VolumeConstraint>();
  const auto& solids = data_.sets.of<NeoHookeanConstraint>();
  VertexTet tet;
  if (volumes.is_alive(id)) {
    tet = make_volume(volumes.record(id));
  } else if (solids.is_alive(id)) {
    tet = make_neo_hookean(solids.record(id), tissue.bodies()[tissue.body_of_tet(id)].material);
  }
  tet.vertices = data_.places_of(tissue.tets()[id]);
  return tet;
}

bool VertexFollower::grow(const Tissue& tissue, const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  const auto place_count = static_cast<Index>(data_.particles.size());
  const Index new_places = place_count - blocks.vertex_count();
  if (new_places > kMostNewVertices * place_count ||
      (data_.sets.has_damping && !blocks.has_damping())) {
    return false;
  }
  blocks.add_vertices(place_count);
  for (Index place = place_count - new_places; place < place_count; ++place) {
    set_free(place);
  }
  // what has other vertices now
  for (const ReshapedTet& reshaped : change.reshaped_tets) {
    if (reshaped.tet < change.first_new_tet && tissue.is_tet_alive(reshaped.tet)) {
      VertexTet tet = blocks.tet(reshaped.tet);
      tet.vertices = data_.places_of(tissue.tets()[reshaped.tet]);
      if (tet.vertices != blocks.tet(reshaped.tet).vertices) {
        blocks.set_tet(reshaped.tet, tet);
      }
    }
  }
  const auto set_edge = [&](Index edge) {
    blocks.set_spring(data_.sets.distance_ids.of_edge(edge), edge_spring(data_, tissue, edge));
  };
  std::ranges::for_each(change.moved_edges, set_edge);
  for (const LinkMove& move : change.edit.link_moves) {
    blocks.set_spring(data_.sets.distance_ids.of_link(move.link),
                      link_spring(data_, tissue, move.link));
  }
  for (const Index hinge : change.moved_hinges) {
    blocks.set_hinge(hinge, vertex_hinge(data_, tissue, hinge));
  }
  // what is new
  std::vector<VertexTet> tets;
  for (Index t = change.first_new_tet; t < static_cast<Index>(tissue.tets().size()); ++t) {
    tets.push_back(new_tet(tissue, t));
    blocks.add_tet(tets.back());
  }
  const auto known = static_cast<Index>(blocks.springs().size());
  std::vector<VertexSpring> springs(
      static_cast<std::size_t>(data_.sets.distance_ids.count() - known));
  for (Index e = change.first_new_edge; e < static_cast<Index>(tissue.edges().size()); ++e) {
    springs[data_.sets.distance_ids.of_edge(e) - known] = edge_spring(data_, tissue, e);
  }
  for (Index l = change.first_new_link; l < static_cast<Index>(tissue.links().size()); ++l) {
    springs[data_.sets.distance_ids.of_link(l) - known] = link_spring(data_, tissue, l);
  }
  for (const VertexSpring& spring : springs) {
    blocks.add_spring(spring);
  }
  for (Index h = change.first_new_hinge; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    blocks.add_hinge(vertex_hinge(data_, tissue, h));
  }
  const auto free_ends = [&](const auto& elements) {
    for (const auto& element : elements) {
      std::ranges::for_each(element.vertices, [&](Index place) { set_free(place); });
    }
  };
  free_ends(tets);
  free_ends(springs);
  blocks.set_unit(unit_for_new(tissue, change, blocks.unit(), tets, springs));
  return true;
}

// Of a vertex that has tissue again, too.
void VertexFollower::set_free(Index place) {
  if (data_.particles[place].w > 0) {
    data_.vertex_blocks.set_free(place);
  }
}

void VertexFollower::regrow(const Tissue& tissue, const TissueChange& change) {
  VertexBlocks& blocks = data_.vertex_blocks;
  std::vector<VertexTet> tets(tissue.tets().size());
  for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
    if (tissue.is_tet_alive(t)) {
      tets[t] = t < change.first_new_tet ? blocks.tet(t) : new_tet(tissue, t);
    }
  }
  VertexBlocks grown = make_vertex_blocks(data_, std::move(tets));
  before_growth_ = std::move(blocks);
  blocks = std::move(grown);
}

void VertexFollower::undo(const Tissue&, const TissueChange&) noexcept {
  if (!is_used(data_)) {
    return;
  }
  if (before_growth_) {
    data_.vertex_blocks = std::move(*before_growth_);
  }
  data_.vertex_blocks.undo();
  refresh();
  before_growth_.reset();
}

void VertexFollower::refresh() {
  VertexBlocks& blocks = data_.vertex_blocks;
  blocks.refresh();
  for (const Index place : blocks.refreshed()) {
    if (!has_grown_) {  // else backends that keep them elsewhere take all anew
      data_.log_constraint(PhaseKind::vertex, place);
    }
  }
  if (is_explicit(data_.options)) {
    if (before_growth_) {
      data_.stable_substep.measure(data_);
      return;
    }
    if (has_grown_) {
      data_.stable_substep.fit(data_);
    }
    data_.stable_substep.measure(data_, blocks.refreshed());
  }
}

}  // namespace pbdsurg
