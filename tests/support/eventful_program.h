// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A program that does to a solver all that can be done, for comparing backends.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/cuts.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr double kEventfulEdge = 4e-3;      // m
inline constexpr float kEventfulTimeStep = 2e-3F;  // s

/// Bodies of springs with and without volumes, and in compliance mode a Neo-Hookean one, with links
/// between them and limits of stretch.
/// @param cells          of the first body; 4, 4, 3 at least
/// @param vertices_only  without stiff links, which have phases of their own beside vertex blocks
inline Scene make_eventful_scene(ProjectionMode mode, float damping,
                                 std::array<Index, 3> cells = {4, 4, 3},
                                 bool vertices_only = false) {
  Scene scene;
  const TetMesh block = make_box(cells, kEventfulEdge, 0.1);
  const TetMesh tube = make_box({6, 1, 1}, kEventfulEdge, 0.1, 2);
  Material soft = elastic_material(block, 1000, 20e3);
  soft.max_stretch = 1.05F;
  soft.damping = damping;
  Material walls = elastic_material(tube, 1000, 20e3);
  walls.has_volume_constraints = false;
  const Material solid{
      .model = ElasticModel::neo_hookean, .damping = damping, .max_stretch = soft.max_stretch};
  scene.add_body("block", block, soft);
  scene.add_body("tube", tube, walls);
  scene.add_body("solid", make_box({3, 3, 2}, kEventfulEdge, 0.1, 3),
                 mode == ProjectionMode::compliance ? solid : soft);
  const float soft_link = vertices_only ? 2e-2F : 1e-3F;  // m/N; the latter is a stiff link to some
  for (Index v = 0; v < 12; ++v) {
    scene.add_link({v,
                    scene.body(1).first_vertex + v,
                    0,
                    {0.5F, v % 3 == 0 && !vertices_only ? 0 : soft_link}});
    scene.add_link({v, scene.body(2).first_vertex + 3 * v, 0, {0.5F, soft_link}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEventfulEdge; });
  return scene;
}

/// Gives the Neo-Hookean body of such a scene fibres.
inline void give_solid_fibres(Scene& scene) {
  constexpr Index kSolid = 2;
  const auto count = static_cast<std::size_t>(scene.body(kSolid).tet_count);
  scene.set_fibres(kSolid, std::vector<Fibre>(count, {{0.6F, 0, 0.8F}, 30e3F}));
}

/// What a program does, on two solvers alike: writes, edits, grasps, moves. Choices follow from the
/// seed and the state.
class EventfulProgram {
 public:
  /// @param surface  of its tools
  EventfulProgram(const Scene& scene, std::uint64_t seed,
                  const ToolSurface& surface = {ContactFeatures::vertices})
      : seed_(seed), surface_(surface) {
    for (const Eigen::Vector3d& x : scene.positions()) {
      rest_.push_back(x.cast<float>());
      speeds_.push_back(0.01F * x.cast<float>().normalized());
    }
    pose_.translation() = Eigen::Vector3f(0, 0.018F, 0.006F);
  }

  /// Before the first round.
  void begin(Solver& solver) const {
    solver.add_tool({&capsule_, 1}, pose_, surface_);
    // pushes, too, once it holds nothing: vertices around it, or what comes down upon it
    ToolPose below = ToolPose::Identity();
    below.translation().y() = surface_.features == ContactFeatures::all ? -0.0045F : 0;
    solver.add_tool({&capsule_, 1}, below, surface_);
    solver.watch(std::array<Index, 3>{5, 1, 40});
  }

  /// Before each step.
  void act(Solver& solver, int round) const {
    constexpr int kActions = 22;
    ToolPose pose = pose_;
    pose.translation().y() -= 4e-4F * static_cast<float>(round % 10);
    solver.move_tool(ToolId{0}, pose);
    switch (random(round, 0) % kActions) {
      case 0:
        break;
      case 1:
        solver.tissue().apply({.remove_tets = some_tets(solver, round, 5)});
        break;
      case 2:
        resize(solver, round);
        break;
      case 3:
        grasp_some(solver, round);
        break;
      case 4:
        solver.write_velocities(follow(speeds_, solver.velocities()));
        break;
      case 5: {
        std::vector<Eigen::Vector3f> positions = follow(rest_, solver.positions());
        for (Eigen::Vector3f& x : positions) {
          x *= 1.02F;
        }
        solver.write_positions(positions);
        solver.tissue().apply({.remove_tets = some_tets(solver, round, 3)});
        break;
      }
      case 6:
        solver.tissue().apply({.remove_links = some_link(solver, round)});
        break;
      case 7: {
        const Snapshot snapshot = solver.snapshot();
        solver.step(kEventfulTimeStep);
        solver.restore(snapshot);
        break;
      }
      case 8:
        remove_vertex(solver, round);
        break;
      case 9:
        solver.release(ToolId{1});
        break;
      case 10:
        resize(solver, round);
        solver.tissue().apply({.remove_tets = some_tets(solver, round, 5)});
        pose.translation().z() += 5e-3F;
        solver.add_tool({&capsule_, 1}, pose, surface_);
        break;
      case 11:
        undo_removal(solver, round, false);
        break;
      case 12:
        undo_removal(solver, round, true);
        break;
      case 13:
        solver.tissue().apply({.new_links = some_new_links(solver, round)});
        break;
      case 14: {
        const TopologyEdit edit{.remove_tets = some_tets(solver, round, 2),
                                .remove_links = some_link(solver, round),
                                .new_links = some_new_links(solver, round)};
        solver.tissue().apply(edit);
        if (round % 2 == 0) {
          solver.step(kEventfulTimeStep);
        }
        solver.tissue().undo();
        break;
      }
      case 15:
        solver.tissue().apply(part_vertex(solver, some_vertex(solver, round), seed_));
        break;
      case 16:
        solver.tissue().apply(split_edge(solver, some_edge(solver, round), 0.5F));
        break;
      case 17: {
        const TopologyEdit edit = round % 3 == 0
                                      ? split_edge(solver, some_edge(solver, round), 0.25F)
                                      : part_vertex(solver, some_vertex(solver, round), seed_ + 1);
        solver.tissue().apply(edit);
        if (round % 2 == 0) {
          solver.step(kEventfulTimeStep);
        }
        solver.tissue().undo();
        break;
      }
      case 18:
        solver.tissue().apply({.new_bodies = guest(round)});
        break;
      case 19: {
        const TopologyEdit edit{.remove_bodies = guests_in(solver), .new_bodies = guest(round)};
        solver.tissue().apply(edit);
        if (round % 2 == 0) {
          solver.step(kEventfulTimeStep);
        }
        solver.tissue().undo();
        break;
      }
      case 20:
        solver.tissue().apply({.remove_bodies = guests_in(solver)});
        break;
      default:
        solver.watch(std::array{some_vertex(solver, round), Index{7}});
        break;
    }
  }

  /// Before a step, beside act(): vertices stop and others move again, links are drawn in.
  void fix(Solver& solver, int round) const {
    switch (random(round, 70) % 8) {
      case 0:
        solver.tissue().apply(fixing(solver, round));
        break;
      case 1:
        solver.tissue().apply(fixing(solver, round));
        if (round % 2 == 0) {
          solver.step(kEventfulTimeStep);
        }
        solver.tissue().undo();
        break;
      default:
        break;
    }
  }

  /// Before a step, beside act(): forces and gravity come, change and go.
  void load(Solver& solver, int round) const {
    const float size = 1e-4F * static_cast<float>(random(round, 60) % 8);
    switch (random(round, 61) % 12) {
      case 0:
      case 1:
        solver.set_forces(std::array{some_vertex(solver, round)},
                          std::array{Eigen::Vector3f(size, 1e-4F, -size)});
        break;
      case 2:
        solver.set_forces([&](Index v, const Eigen::Vector3f& x) -> Eigen::Vector3f {
          return v % 3 == 0 ? Eigen::Vector3f::Zero() : Eigen::Vector3f(1e-2F * x);
        });
        break;
      case 3:
        solver.clear_forces();
        break;
      case 4:
        solver.set_gravity(static_cast<Index>(random(round, 62) % solver.tissue().bodies().size()),
                           Eigen::Vector3f(0, -5, 1e4F * size));
        break;
      case 5:
        solver.set_gravity(Eigen::Vector3f(-1e4F * size, -9.81F, 0));
        break;
      default:
        break;
    }
  }

 private:
  [[nodiscard]] std::uint64_t random(int round, std::uint64_t what) const {
    return random_bits(seed_, static_cast<std::uint64_t>(round), what) >> 8;
  }

  [[nodiscard]] std::vector<Index> some_tets(const Solver& solver, int round, int count) const {
    std::vector<Index> tets;
    for (int i = 0; i < count; ++i) {
      const auto tet = static_cast<Index>(random(round, 10 + i) % solver.tissue().tets().size());
      if (solver.tissue().is_tet_alive(tet) && std::ranges::find(tets, tet) == tets.end()) {
        tets.push_back(tet);
      }
    }
    return tets;
  }

  [[nodiscard]] std::vector<Index> some_link(const Solver& solver, int round) const {
    const auto link = static_cast<Index>(random(round, 20) % solver.tissue().links().size());
    return solver.tissue().is_link_alive(link) ? std::vector{link} : std::vector<Index>{};
  }

  // What is wanted of the scene's vertices, and the rest as it is.
  static std::vector<Eigen::Vector3f> follow(const std::vector<Eigen::Vector3f>& wanted,
                                             std::vector<Eigen::Vector3f> now) {
    std::ranges::copy(wanted, now.begin());
    return now;
  }

  [[nodiscard]] Index some_edge(const Solver& solver, int round) const {
    auto edge = static_cast<Index>(random(round, 40) % solver.tissue().edges().size());
    while (!solver.tissue().is_edge_alive(edge)) {
      edge = (edge + 1) % static_cast<Index>(solver.tissue().edges().size());
    }
    return edge;
  }

  [[nodiscard]] std::vector<Link> some_new_links(const Solver& solver, int round) const {
    std::vector<Link> links;
    for (int i = 0; i < 4; ++i) {
      const Index first = some_vertex(solver, round + 100 * i);
      const Index second = some_vertex(solver, round + 100 * i + 50);
      if (first != second) {
        links.push_back({first, second, 0.01F, {0.1F, 1e-2F}});
      }
    }
    return links;
  }

  [[nodiscard]] Index some_vertex(const Solver& solver, int round) const {
    Index v = static_cast<Index>(random(round, 30) % rest_.size());
    while (!solver.tissue().has_tissue(v)) {
      v = (v + 1) % static_cast<Index>(rest_.size());
    }
    return v;
  }

  // A body with damping where the scene may have none, and a particle that hangs from it.
  [[nodiscard]] static Scene guest(int round) {
    const TetMesh mesh = make_box({2, 2, 2}, kEventfulEdge, 0.1, 9);
    Material soft = elastic_material(mesh, 900, 20e3);
    soft.max_stretch = 1.1F;
    soft.damping = 1e-3F;
    Scene bodies;
    bodies.add_body("guest " + std::to_string(round), mesh, soft);
    bodies.add_particles("bead " + std::to_string(round),
                         std::vector<Eigen::Vector3d>{{0.01, 0.012, 0}}, 1e-5);
    bodies.add_link({0, mesh.vertex_count(), 0.012F, {0.5F, 1e-3F}});
    return bodies;
  }

  [[nodiscard]] static std::vector<Index> guests_in(const Solver& solver) {
    std::vector<Index> guests;
    for (Index b = 0; b < static_cast<Index>(solver.tissue().bodies().size()); ++b) {
      const std::string& name = solver.tissue().body(b).name;
      if (solver.tissue().is_body_alive(b) &&
          (name.starts_with("guest") || name.starts_with("bead"))) {
        guests.push_back(b);
      }
    }
    return guests;
  }

  // Of what has a rest length or a rest volume.
  void resize(Solver& solver, int round) const {
    TopologyEdit edit;
    for (const Index t : some_tets(solver, round, 6)) {
      const bool is_of_tube = solver.tissue().body_of_tet(t) == 1;
      if (!is_of_tube) {
        edit.rest_volumes.push_back({t, 0.9F * solver.rest_volume(t)});
      }
      const Index edge = solver.tissue().tet_edges(t)[0];
      const bool is_new = std::ranges::none_of(
          edit.rest_lengths, [&](const RestLengthChange& change) { return change.edge == edge; });
      if (solver.tissue().body_of_tet(t) < 2 && is_new) {
        edit.rest_lengths.push_back({edge, 0.95F * solver.rest_length(edge)});
      }
    }
    solver.tissue().apply(edit);
  }

  // Stops some vertices, lets others go, makes tissue stiffer or softer, and draws a link in.
  [[nodiscard]] TopologyEdit fixing(const Solver& solver, int round) const {
    TopologyEdit edit;
    for (Index v = round % 7; v < static_cast<Index>(rest_.size()); v += 13) {
      if (solver.tissue().has_tissue(v)) {
        (solver.tissue().is_fixed(v) ? edit.unfix_vertices : edit.fix_vertices).push_back(v);
      }
    }
    for (const Index t : some_tets(solver, round, 4)) {
      const Body& body = solver.tissue().body(solver.tissue().body_of_tet(t));
      if (body.material.model == ElasticModel::neo_hookean) {
        edit.stiffnesses.push_back({t, 0.5F + 0.5F * static_cast<float>(round % 4)});
      }
    }
    for (const Index link : some_link(solver, round)) {
      edit.link_lengths.push_back({link, 0.8F * solver.tissue().links()[link].rest_length});
    }
    return edit;
  }

  void grasp_some(Solver& solver, int round) const {
    solver.release(ToolId{1});
    solver.grasp(ToolId{1}, std::array{some_vertex(solver, round)}, 1e-4F);
  }

  // With all that is around it, while a tool holds it.
  void remove_vertex(Solver& solver, int round) const {
    grasp_some(solver, round);
    solver.step(kEventfulTimeStep);
    solver.tissue().apply(all_around(solver, some_vertex(solver, round)));
  }

  // Vertices, links and what a tool holds come back, while the solver steps or before.
  void undo_removal(Solver& solver, int round, bool steps) const {
    grasp_some(solver, round);
    solver.step(kEventfulTimeStep);
    TopologyEdit edit = all_around(solver, some_vertex(solver, round));
    edit.remove_links = some_link(solver, round);
    solver.tissue().apply(edit);
    if (steps) {
      solver.step(kEventfulTimeStep);
    }
    solver.tissue().undo();
  }

  static TopologyEdit all_around(const Solver& solver, Index gone) {
    TopologyEdit edit;
    for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
      if (solver.tissue().is_tet_alive(t) &&
          std::ranges::find(solver.tissue().tets()[t], gone) != solver.tissue().tets()[t].end()) {
        edit.remove_tets.push_back(t);
      }
    }
    return edit;
  }

  std::uint64_t seed_;
  ToolSurface surface_;
  std::vector<Eigen::Vector3f> rest_, speeds_;
  Capsule capsule_{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose_ = ToolPose::Identity();
};

/// A way of solving in which backends, strategies or copies are compared.
struct Variant {
  SolverMethod method = SolverMethod::projection;
  ProjectionMode mode = ProjectionMode::compliance;
  PlanComposition composition = PlanComposition::separate;
  int max_colors = 0;
  float damping = 0;  // s, of materials
  int iterations = 2;
  float over_relaxation = 1;
  Index contact_capacity = 4096;
  TimeIntegration integration = TimeIntegration::implicit_euler;
  CoarseCorrection coarse_correction = CoarseCorrection::automatic;
};

inline SolverOptions options_of(const Variant& variant) {
  SolverOptions options{.method = variant.method,
                        .mode = variant.mode,
                        .substeps = 2,
                        .iterations = variant.iterations,
                        .damping = 2,
                        .over_relaxation = variant.over_relaxation,
                        .coarse_correction = variant.coarse_correction,
                        .integration = variant.integration,
                        .contact_capacity = variant.contact_capacity,
                        .math = MathMode::strict,
                        .composition = variant.composition};
  options.coloring.max_colors = variant.max_colors;
  options.coloring.repair = variant.max_colors == 0;
  return options;
}

/// Changes some tetrahedra of an eventful scene: by turns it removes them, or changes rest values.
inline TopologyEdit eventful_edit(const Solver& solver, Index round) {
  constexpr Index kStride = 97;
  TopologyEdit edit;
  for (Index t = round; t < static_cast<Index>(solver.tissue().tets().size()); t += kStride) {
    if (!solver.tissue().is_tet_alive(t)) {
      continue;
    }
    const Material& material = solver.tissue().body(solver.tissue().body_of_tet(t)).material;
    const bool is_of_tube = solver.tissue().body_of_tet(t) == 1;
    const bool is_of_solid = material.model == ElasticModel::neo_hookean;
    if (round % 3 != 0) {
      edit.remove_tets.push_back(t);
    } else if (!is_of_tube) {
      edit.rest_volumes.push_back({t, 0.9F * solver.rest_volume(t)});
      if (!is_of_solid) {
        const Index edge = solver.tissue().tet_edges(t)[round % 6];
        edit.rest_lengths.push_back({edge, 0.9F * solver.rest_length(edge)});
      }
    }
  }
  return edit;
}

inline SolverOptions serial_options(const Variant& variant, Index copies = 1) {
  SolverOptions options = options_of(variant);
  options.executor = executor::serial();
  options.copies = copies;
  return options;
}

inline bool equal(const StepReport& a, const StepReport& b) {
  return a.inverted_tets == b.inverted_tets && a.non_finite_vertices == b.non_finite_vertices &&
         a.first_non_finite == b.first_non_finite &&
         a.first_non_finite_copy == b.first_non_finite_copy && a.contacts == b.contacts &&
         a.dropped_contacts == b.dropped_contacts && a.distance_residual == b.distance_residual &&
         a.volume_residual == b.volume_residual;
}

}  // namespace pbdsurg::testing
