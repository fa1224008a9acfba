// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Two slabs with strands between them, and all that follows their tissue, for tests.

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_boundary.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr double kSlabEdge = 2e-3;      // m
inline constexpr float kSlabTimeStep = 5e-3F;  // s

// Two slabs with strands between them.
struct Slabs {
  explicit Slabs(const Material& material = {}) : lower(make_box({6, 6, 2}, kSlabEdge)) {
    std::vector<Eigen::Vector3d> points(lower.positions().begin(), lower.positions().end());
    for (Eigen::Vector3d& point : points) {
      point.z() += 7e-3;
    }
    upper = TetMesh(points, {lower.tets().begin(), lower.tets().end()});
    scene.add_body("lower", lower, material);
    scene.add_body("upper", upper, material);
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kSlabEdge; });
    strands.join(scene, 0, 1, scattered_links(lower, upper, {.max_distance = 6e-3, .density = 2e6}),
                 {.segments = 3, .tear_stretch = 1.2});
  }

  TetMesh lower, upper;
  Scene scene;
  ConnectiveTissue strands;
};

// A solver and all that follows its tissue.
struct World {
  explicit World(const Slabs& slabs, const SolverOptions& options = {.damping = 20},
                 const CauteryOptions& burning = {.link_energy = 0.05})
      : solver(slabs.scene, options),
        cautery(
            solver.tissue(),
            std::array{ThermalBody{0, tissues::fat().heat}, ThermalBody{1, tissues::fat().heat}},
            burning),
        strands(slabs.strands),
        surfaces{LiveSurface(solver.tissue(), 0), LiveSurface(solver.tissue(), 1)},
        pieces(solver.tissue()) {
    solver.tissue().add_follower(strands, FollowerRank::surgery);
  }

  void burn_and_tear(const Eigen::Vector3f& tip) {
    cautery.update(solver, {tip, tip}, cut_settings(8), kSlabTimeStep);
    strands.separate(solver);
  }

  Solver solver;
  Cautery cautery;
  ConnectiveTissue strands;
  std::array<LiveSurface, 2> surfaces;
  LivePieces pieces;
};

inline std::vector<std::pair<Index, Triangle>> shown_by(const LiveSurface& surface) {
  std::vector<std::pair<Index, Triangle>> shown;
  for (Index slot = 0; slot < surface.slot_count(); ++slot) {
    if (surface.origins()[slot].tet != kInvalidIndex) {
      shown.emplace_back(surface.origins()[slot].tet, surface.triangles()[slot]);
    }
  }
  std::ranges::sort(shown);
  return shown;
}

// Surface and pieces against those found afresh.
inline void check_views(const World& world) {
  std::vector<Tet> live;
  std::vector<Index> ids;
  for (Index t = 0; t < static_cast<Index>(world.solver.tissue().tets().size()); ++t) {
    if (world.solver.tissue().is_tet_alive(t)) {
      live.push_back(world.solver.tissue().tets()[t]);
      ids.push_back(t);
    }
  }
  const Components components = find_components(world.solver.vertex_count(), live);
  std::vector<Index> piece_of(static_cast<std::size_t>(components.count), kInvalidIndex);
  Index wrong = 0, most = 0;
  for (std::size_t i = 0; i < live.size(); ++i) {
    Index& piece = piece_of[components.of_vertex[live[i][0]]];
    const Index actual = world.pieces.piece_of(ids[i]);
    piece = piece == kInvalidIndex ? actual : piece;
    wrong += actual != piece;
    wrong += world.pieces.body(actual) != world.solver.tissue().body_of_tet(ids[i]);
  }
  std::ranges::sort(piece_of);
  most = static_cast<Index>(std::unique(piece_of.begin(), piece_of.end()) - piece_of.begin());
  REQUIRE(wrong == 0);
  REQUIRE(most == components.count);  // no piece has two ids, no id two pieces

  for (Index body = 0; body < 2; ++body) {
    std::vector<std::pair<Index, Triangle>> expected;
    for (const BoundaryTriangle& triangle : find_live_boundary(world.solver.tissue(), body)) {
      expected.emplace_back(triangle.tet, triangle.vertices);
    }
    std::ranges::sort(expected);
    REQUIRE(shown_by(world.surfaces[body]) == expected);
    REQUIRE(shown_by(LiveSurface(world.solver.tissue(), body)) == expected);
  }
}

// A cut through both slabs, and strands, at some place.
inline CutSurface random_cut(std::uint64_t seed, Index round) {
  const auto random = [&](int what) {
    return static_cast<float>(
        random_unit(seed, static_cast<std::uint64_t>(round), static_cast<std::uint64_t>(what)));
  };
  const float x = 12e-3F * random(0), lean = 4e-3F * (random(1) - 0.5F);
  const float depth = 12e-3F * random(2);
  const std::array edges{
      BladeEdge{{x, -1e-3F, 12e-3F}, {x + lean, 13e-3F, 12e-3F}},
      BladeEdge{{x + lean, -1e-3F, 12e-3F - depth}, {x, 13e-3F, 12e-3F - depth}}};
  return sweep_blade(edges);
}

}  // namespace pbdsurg::testing
