// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A scene of tissue with fibres, and what can be done to it, for comparing backends.

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/cuts.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg::testing {

/// Of two directions; a third of tetrahedra has none.
inline Fibre fibre_of(Index tet) {
  const Eigen::Vector3f direction =
      tet % 2 == 0 ? Eigen::Vector3f(1, 0, 0) : Eigen::Vector3f(0.8F, 0, 0.6F);
  return {direction, tet % 3 == 0 ? 0 : 20e3F * static_cast<float>(1 + tet % 4)};
}

inline void give_fibres(Scene& scene, Index body) {
  std::vector<Fibre> fibres;
  for (Index t = 0; t < scene.body(body).tet_count; ++t) {
    fibres.push_back(fibre_of(t));
  }
  scene.set_fibres(body, fibres);
}

/// A bar, held at its start, and a block that hangs on it by links, soft enough for all kernels.
/// @param damping  s
inline Scene make_fibreless_scene(float damping) {
  Material material = neo_hookean(10e3F, 0.4F);
  material.damping = damping;
  Scene scene = make_bar(material, {6, 3, 2});
  scene.add_body("block", make_box({3, 2, 2}, kSoftEdge, 0.1, 2), material);
  for (Index i = 0; i < 4; ++i) {
    scene.add_link({20 + i, scene.body(1).first_vertex + i, 1e-3F, {0.5F, 2e-2F}});
  }
  return scene;
}

/// The same, whose bar has fibres.
inline Scene make_fibred_scene(float damping) {
  Scene scene = make_fibreless_scene(damping);
  give_fibres(scene, 0);
  return scene;
}

/// What a program does to such a scene, on two solvers alike: a tool pushes, another holds, edits
/// come and are taken back. Choices follow from the round and the state.
class FibreProgram {
 public:
  static constexpr float kStep = 1e-3F;  // s

  /// Before the first round. The bar is longer than at rest, in each copy by more.
  static void begin(Solver& solver, const Scene& scene) {
    constexpr auto kRadius = static_cast<float>(kSoftEdge);
    const Capsule capsule{{0.012F, 0.014F, 0}, {0.02F, 0.014F, 0.006F}, kRadius};
    solver.add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver.grasp(solver.add_tool({}, ToolPose::Identity()), std::array<Index, 2>{40, 55}, 1e-3F);
    for (Index copy = 0; copy < solver.options().copies; ++copy) {
      solver.write_positions(stretched(scene, 1.1F + 0.05F * static_cast<float>(copy)), copy);
    }
  }

  /// Before each step.
  static void act(Solver& solver, Index round) {
    switch (round % 8) {
      case 0:
        if (round > 0) {
          solver.tissue().apply(other_fibres(solver, round));
          solver.step(kStep);
          solver.tissue().undo();
        }
        break;
      case 1:
      case 5:
        solver.tissue().apply(other_fibres(solver, round));
        break;
      case 2:
      case 4:
        solver.tissue().apply(cut(solver, round));
        break;
      case 3:
        solver.tissue().undo();
        break;
      case 6:
        solver.tissue().apply(other_numbers(solver, round));
        solver.tissue().apply({.remove_tets = some_tets(solver, round + 1, 2)});
        break;
      default:
        solver.tissue().apply(guest(round));
        if (round % 16 == 7) {
          solver.step(kStep);
          solver.tissue().undo();
        }
        break;
    }
  }

  /// A body that comes with fibres.
  static TopologyEdit guest(Index round) {
    TopologyEdit edit;
    edit.new_bodies.add_body("guest " + std::to_string(round),
                             make_box({2, 1, 1}, kSoftEdge, 0.1, 3), neo_hookean(10e3F, 0.4F));
    give_fibres(edit.new_bodies, 0);
    return edit;
  }

 private:
  // That live.
  static std::vector<Index> some_tets(const Solver& solver, Index round, std::size_t count) {
    const auto all = static_cast<Index>(solver.tissue().tets().size());
    std::vector<Index> found;
    for (Index i = 0; found.size() < count; ++i) {
      const Index t = (31 * round + 17 * i) % all;
      if (solver.tissue().is_tet_alive(t) && std::ranges::count(found, t) == 0) {
        found.push_back(t);
      }
    }
    return found;
  }

  static TopologyEdit other_fibres(const Solver& solver, Index round) {
    TopologyEdit edit;
    for (const Index t : some_tets(solver, round, 6)) {
      edit.fibres.push_back({t, fibre_of(t + round)});
    }
    return edit;
  }

  static TopologyEdit cut(const Solver& solver, Index round) {
    if (round / 2 % 2 == 0) {
      Index edge = 13 * round;
      while (!solver.tissue().is_edge_alive(edge)) {
        ++edge;
      }
      return split_edge(solver, edge, 0.4F);
    }
    return part_vertex(solver, 10 + 2 * round, static_cast<std::uint64_t>(round));
  }

  static TopologyEdit other_numbers(const Solver& solver, Index round) {
    TopologyEdit edit;
    const std::vector<Index> tets = some_tets(solver, round, 4);
    edit.stiffnesses = {{tets[0], 1.5F}, {tets[1], 0.5F}};
    for (const Index t : {tets[2], tets[3]}) {
      const double volume = tet_volume(solver.tissue().rest_positions(), solver.tissue().tets()[t]);
      edit.rest_volumes.push_back({t, static_cast<float>(0.9 * volume)});
    }
    return edit;
  }
};

}  // namespace pbdsurg::testing
