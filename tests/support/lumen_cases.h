// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A hollow ball with a lumen, for tests.

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/lumen.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"

namespace pbdsurg::testing {

constexpr double kInner = 20e-3, kOuter = 26e-3;  ///< m, radii
constexpr float kLumenStep = 5e-3F;               ///< s

struct LumenRecipe {
  const char* name;
  SolverOptions options;
};

inline LumenRecipe any_lumen_recipe() {
  constexpr float kDrag = 30;  // 1/s
  return GENERATE_COPY(
      LumenRecipe{"default", {.damping = kDrag}},
      LumenRecipe{"default, BDF2", {.damping = kDrag, .integration = TimeIntegration::bdf2}},
      LumenRecipe{"projections",
                  {.method = SolverMethod::projection, .iterations = 10, .damping = kDrag}});
}

inline const TetMesh& hollow_ball() {
  static const TetMesh mesh = [] {
    TetrahedralizeOptions options;
    options.spacing = 4e-3;  // m
    const ImplicitShape ball = sphere_shape({0, 0, 0}, kOuter);
    return tetrahedralize(shell_shape(ball, kOuter - kInner), options).mesh;
  }();
  return mesh;
}

inline Scene ball_scene(float poissons_ratio = 0.3F, float youngs_modulus = 10e3F) {
  Scene scene;
  scene.add_body(
      "ball", hollow_ball(),
      {.density = 1000, .youngs_modulus = youngs_modulus, .poissons_ratio = poissons_ratio});
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

/// A solver with a lumen in the body.
struct LumenSolver {
  Solver solver;
  std::shared_ptr<Lumen> lumen;

  LumenSolver(const Scene& scene, const SolverOptions& options, const LumenOptions& contents)
      : solver(scene, options),
        lumen(std::make_shared<Lumen>(solver.tissue(), find_cavities(solver.tissue(), 0).at(0),
                                      contents)) {
    solver.add_constraints(lumen);
  }

  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      REQUIRE(solver.step(kLumenStep).non_finite_vertices == 0);
    }
  }
  /// m^3
  [[nodiscard]] double volume(Index copy = 0) const {
    return lumen->cavity().volume(solver.positions(copy));
  }
};

/// Takes tissue of the upper wall, through it or of its inner half.
/// @param outer  m, how far it reaches
inline TopologyEdit puncture(const Tissue& tissue, double outer) {
  const auto x = tissue.rest_positions();
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    const Tet& tet = tissue.tets()[t];
    const Eigen::Vector3d middle = (x[tet[0]] + x[tet[1]] + x[tet[2]] + x[tet[3]]) / 4;
    if (middle.y() > 0 && std::hypot(middle.x(), middle.z()) < 2.5e-3 && middle.y() < outer) {
      edit.remove_tets.push_back(t);
    }
  }
  return edit;
}

constexpr LumenOptions kWater{.contents = LumenContents::liquid, .density = 1000};

/// m^3/Pa, of a hollow ball under pressure: Lame's solution (Timoshenko and Goodier, "Theory of
/// Elasticity", article 142), of small strains.
inline double lame_compliance(double youngs_modulus, double poissons_ratio) {
  const double a = kInner, b = kOuter, a3 = a * a * a, b3 = b * b * b;
  const double way = a3 / (youngs_modulus * (b3 - a3)) *
                     ((1 - 2 * poissons_ratio) * a + (1 + poissons_ratio) * b3 / (2 * a * a));
  return 4 * std::numbers::pi * a * a * way;
}

}  // namespace pbdsurg::testing
