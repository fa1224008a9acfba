// SPDX-License-Identifier: Apache-2.0
#include "tests/support/body_spoiler.h"

#include <array>
#include <vector>

#include "tests/support/bad_ids.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {
namespace {

constexpr double kEdge = 4e-3;  // m
constexpr Stiffness kLink{0.5F, 1e-3F};

std::vector<Index> find_live_bodies(const Solver& solver) {
  return find_all(solver.tissue().bodies().size(),
                  [&](Index b) { return solver.tissue().is_body_alive(b); });
}

// Removes a body, and names tissue of it otherwise.
bool spoil_going_tissue(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  const std::vector<Index> tets = find_all(
      solver.tissue().tets().size(), [&](Index t) { return solver.tissue().is_tet_alive(t); });
  if (tets.empty()) {
    return false;
  }
  const Index tet = choices.one_of(tets);
  const Tet& vertices = solver.tissue().tets()[tet];
  const Index body = solver.tissue().body_of_tet(tet);
  const auto others = find_all(static_cast<std::size_t>(solver.vertex_count()), [&](Index v) {
    return solver.tissue().has_tissue(v) && solver.tissue().body_of_vertex(v) != body;
  });
  edit = {.remove_bodies = {body}};
  switch (choices.below(4)) {
    case 0:
      edit.remove_tets = {tet};
      return true;
    case 1:
      edit.new_vertices = {{vertices[0], vertices[0], 0}};
      edit.corner_moves = {{tet, vertices[0], solver.vertex_count()}};
      return true;
    case 2:
      edit.new_tets = {{tet, vertices}};  // fills its parent
      return true;
    default:
      if (others.empty()) {
        return false;
      }
      edit.new_links = {{choices.one_of(others), vertices[0], 1e-3F, kLink}};
      return true;
  }
}

// A name that was given, also to a body that has gone.
bool spoil_name(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  const std::array<Eigen::Vector3d, 1> place{Eigen::Vector3d::Zero()};
  edit.new_bodies = {};
  edit.new_bodies.add_particles(choices.one_of(solver.tissue().bodies()).name, place, 1e-5);
  return true;
}

// What the solver's way of solving cannot follow.
bool spoil_material(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  const TetMesh mesh = make_box({1, 1, 1}, kEdge);
  Material material = elastic_material(mesh, 1000, 20e3);
  if (solver.options().mode == ProjectionMode::fraction) {
    material.model = ElasticModel::neo_hookean;
  } else if (solver.options().method == SolverMethod::vertex_block) {
    choices.one_of(std::array{&material.stretch, &material.volume})->compliance = 0;
  } else {
    return false;
  }
  edit.new_bodies = {};
  edit.new_bodies.add_body("guest that does not fit", mesh, material);
  return true;
}

// To a vertex that no tetrahedron of a new body has, or beyond.
bool spoil_link(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  const auto corners = random_tet(kEdge, 1);
  std::vector<Eigen::Vector3d> points(corners.begin(), corners.end());
  points.emplace_back(0, 0, -kEdge);
  edit = {};
  edit.new_bodies.add_body("guest", {points, {{0, 1, 2, 3}}}, kSprings);
  const Index first = solver.vertex_count();
  edit.new_links = {{first, first + 4 + choices.below(2), 1e-3F, kLink}};
  return true;
}

}  // namespace

bool spoil_bodies(const Solver& solver, Choices& choices, TopologyEdit& edit) {
  switch (choices.below(8)) {
    case 0:
    case 1:
      spoil_ids(choices, edit.remove_bodies, solver.tissue().bodies().size(),
                find_live_bodies(solver), [](Index b) { return b; });
      return true;
    case 2:
    case 3:
      return spoil_going_tissue(solver, choices, edit);
    case 4:
      return spoil_name(solver, choices, edit);
    case 5:
    case 6:
      return spoil_material(solver, choices, edit);
    default:
      return spoil_link(solver, choices, edit);
  }
}

}  // namespace pbdsurg::testing
