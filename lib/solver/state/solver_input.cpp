// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/solver_input.h"

#include <sstream>
#include <string>
#include <utility>

#include "lib/solver/methods/vertex_elements.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/sets/build_constraints.h"
#include "lib/solver/sets/nested_domains.h"
#include "lib/solver/sets/stiff_links.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/substep_rule.h"

namespace pbdsurg {
namespace {

void place_vertices(const Tissue& tissue, std::span<const Eigen::Vector3d> positions,
                    SolverData& data) {
  data.place_of_vertex = order_vertices(positions);
  data.particles.resize(positions.size());
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    const Eigen::Vector3f x = positions[v].cast<float>();
    const double mass = tissue.masses()[v];
    const bool moves = mass > 0 && !tissue.is_fixed(v);
    data.particle(v) = {x.x(), x.y(), x.z(), moves ? static_cast<float>(1 / mass) : 0.0F};
  }
  data.velocities.assign(positions.size(), {});
  if (has_displacements(data.options)) {
    data.carries.assign(positions.size(), {});
  }
  if (has_past(data.options)) {
    data.ways.assign(positions.size(), {});
    data.velocities_before.assign(positions.size(), {});
  }
}

std::string phases_name(const SolverOptions& options) {
  if (is_explicit(options)) {
    return "explicit, vertices";
  }
  const bool by_vertices = options.method == SolverMethod::vertex_block;
  const ColoringOptions coloring = by_vertices ? vertex_coloring(options) : options.coloring;
  std::string name = name_of(coloring.algorithm);
  if (coloring.algorithm == ColoringAlgorithm::greedy && coloring.order != GreedyOrder::natural) {
    name += std::string(" by ") + name_of(coloring.order);
  }
  if (coloring.algorithm == ColoringAlgorithm::random_disc &&
      coloring.disc.palette == Palette::conflicts) {
    name += " by conflicts";
  }
  name += coloring.repair ? by_vertices ? "+repair+search" : "+repair" : "";
  name += coloring.max_colors > 0 ? "+limit " + std::to_string(coloring.max_colors) : "";
  name += coloring.balance ? "+balance" : "";
  if (by_vertices) {
    return name + ", vertices" + (has_coarse_correction(options) ? ", coarse correction" : "");
  }
  switch (options.composition) {
    case PlanComposition::automatic:
      break;
    case PlanComposition::separate:
      return name + ", distances then volumes";
    case PlanComposition::joint:
      return name + ", joint";
    case PlanComposition::nested:
      return name + ", nested";
  }
  return name;
}

// Whether the longest step can be taken.
void check_stable(const SolverData& data) {
  const double longest = data.stable_substep.longest();
  const SolverOptions& options = data.options;
  if (longest > 0 && (options.substeps != kAutomatic ||
                      double{options.longest_step} <= kMostAutomatic * longest)) {
    return;
  }
  const auto place = std::ranges::find(data.place_of_vertex, data.stable_substep.stiffest());
  const auto vertex = static_cast<Index>(place - data.place_of_vertex.begin());
  std::ostringstream text;
  text << "vertex " << vertex << " of body '"
       << data.tissue->bodies()[data.tissue->body_of_vertex(vertex)].name
       << "' needs explicit substeps of " << longest << " s or less";
  if (longest > 0) {
    text << ": more than " << kMostAutomatic << " in the longest step, " << options.longest_step
         << " s; a coarser mesh, softer material or shorter step needs fewer";
  } else {
    text << "; a compliance of 0 has none that is short enough: vertex blocks take it";
  }
  throw InvalidArgument(text.str());
}

}  // namespace

SubstepRule explicit_rule(const SolverData& data) noexcept {
  return {static_cast<float>(data.stable_substep.longest()), 0};
}

void set_substep_rule(const SubstepRule& of_scene, SolverData& data) {
  const SolverOptions& options = data.options;
  data.substep_rule = of_scene;
  const SubstepRule rule = data.rule_of_copies();
  data.plan.longest_substep =
      options.substeps == kAutomatic || is_explicit(options) ? rule.longest : 0;
  data.plan.name = phases_name(options);
  if (options.substeps == kAutomatic || options.iterations == kAutomatic) {
    const auto [substeps, sweeps] = divide_step(options.longest_step, rule, options);
    std::ostringstream name;
    if (options.substeps == kAutomatic) {
      name << ", substeps of " << 1e3 * double{rule.longest} << " ms at most";
    }
    name << ": " << substeps;
    if (!is_explicit(options)) {
      name << " of " << sweeps << (sweeps == 1 ? " sweep" : " sweeps");
    }
    name << " in a step of " << 1e3 * double{options.longest_step} << " ms";
    data.plan.name += name.str();
  }
}

SolverInput input_at_rest(const Tissue& tissue, const SolverOptions& options) {
  SolverInput input;
  input.options = options;
  input.positions.assign(tissue.rest_positions().begin(), tissue.rest_positions().end());
  input.numbers = numbers_at_rest(tissue, options.mode);
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    input.numbers.stiff_links.push_back(
        tissue.is_link_alive(l) ? stiff_link_numbers(tissue, l, options) : std::nullopt);
  }
  input.substep_rule = substep_rule(tissue, options);
  if (moves_vertices(options)) {
    input.vertex_tets = vertex_tets_at_rest(tissue);
  }
  return input;
}

std::unique_ptr<SolverData> build_solver_data(const Tissue& tissue, SolverInput input) {
  auto made = std::make_unique<SolverData>();
  SolverData& data = *made;
  data.tissue = &tissue;
  data.options = input.options;
  data.gravity = tissue.gravity();
  place_vertices(tissue, input.positions, data);
  build_constraints(input.numbers, data);
  data.sets.has_damping = has_damping(tissue.bodies());
  data.vertex_blocks = make_vertex_blocks(data, std::move(input.vertex_tets));
  if (has_coarse_correction(data.options)) {
    data.coarse_space = CoarseSpace(data);
    data.coarse_space.reserve(static_cast<std::size_t>(data.options.spare.vertices));
  }
  data.others.assign(static_cast<std::size_t>(data.options.copies) - 1, data);
  data.reserve_spare_room();
  data.changes.state.assign(static_cast<std::size_t>(data.options.copies), true);
  if (is_explicit(data.options)) {
    data.stable_substep.measure(data);
    check_stable(data);
    input.substep_rule = explicit_rule(data);
  }
  set_substep_rule(input.substep_rule, data);
  data.rebuild_plan();
  return made;
}

void reserve_spare_room(Tissue& tissue, const SpareRoom& spare) {
  tissue.reserve(static_cast<std::size_t>(spare.vertices), static_cast<std::size_t>(spare.tets),
                 static_cast<std::size_t>(spare.edges), static_cast<std::size_t>(spare.links));
}

}  // namespace pbdsurg
