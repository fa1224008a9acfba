// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bodies for custom constraints, and the methods that can have these.

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "examples/tether/tethers.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg::testing {

inline Recipe any_recipe() {
  constexpr float kDrag = 30;  // 1/s
  return GENERATE_COPY(
      Recipe{"default", {.damping = kDrag}},
      Recipe{"default, BDF2", {.damping = kDrag, .integration = TimeIntegration::bdf2}},
      Recipe{"vertex blocks, 2 substeps of 10", vertex_options(2, 10, kDrag)},
      Recipe{"projections of compliances",
             {.method = SolverMethod::projection, .iterations = 10, .damping = kDrag}},
      Recipe{"projections, BDF2",
             {.method = SolverMethod::projection,
              .iterations = 10,
              .damping = kDrag,
              .integration = TimeIntegration::bdf2}},
      Recipe{"projections of fractions",
             {.method = SolverMethod::projection,
              .mode = ProjectionMode::fraction,
              .substeps = 5,
              .iterations = 10,
              .damping = kDrag}});
}

/// A free cube of 8 mm, and one above it.
/// @param holds  whether that one is fixed
inline Scene make_cubes(const Recipe& recipe, bool has_second, bool holds = true) {
  Material material = neo_hookean(20e3F, 0.3F);
  if (recipe.options.mode == ProjectionMode::fraction) {
    material.model = ElasticModel::springs;
    material.stretch.fraction = 0.5F;
    material.volume.fraction = 0.5F;
  }
  Scene scene;
  scene.add_body("cube", make_box({2, 2, 2}, kSoftEdge), material);
  if (has_second) {
    const TetMesh box = make_box({2, 2, 2}, kSoftEdge);
    std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& point : points) {
      point.y() += 0.03;
    }
    scene.add_body("above", TetMesh(std::move(points), {box.tets().begin(), box.tets().end()}),
                   material);
    if (holds) {
      scene.fix_where(1, [](const Eigen::Vector3d&) { return true; });
    }
  }
  return scene;
}

/// The first vertex of a body with the largest height, or the smallest.
inline Index end_of(const Scene& scene, Index body, double sign) {
  const Index first = scene.body(body).first_vertex;
  Index found = first;
  for (Index v = first; v < first + scene.body(body).vertex_count; ++v) {
    if (sign * (scene.positions()[v].y() - scene.positions()[found].y()) > 1e-9) {
      found = v;
    }
  }
  return found;
}
inline Index highest(const Scene& scene, Index body) {
  return end_of(scene, body, 1);
}
inline Index lowest(const Scene& scene, Index body) {
  return end_of(scene, body, -1);
}

/// kg
inline double mass_of(const Scene& scene, Index body) {
  double sum = 0;
  const Index first = scene.body(body).first_vertex;
  for (Index v = first; v < first + scene.body(body).vertex_count; ++v) {
    sum += scene.masses()[v];
  }
  return sum;
}

inline std::shared_ptr<Tethers> add_tethers(Solver& solver, std::vector<Tether> tethers) {
  auto set = std::make_shared<Tethers>(std::move(tethers));
  solver.add_constraints(set);
  return set;
}

struct Momenta {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(),  // kg m/s
      angular = Eigen::Vector3d::Zero();             // kg m^2/s, around the origin
  double size = 0, angular_size = 0;                 // sums of magnitudes
};

inline Momenta momenta(const Scene& scene, const Solver& solver) {
  Momenta sum;
  const auto x = solver.positions(), velocities = solver.velocities();
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Eigen::Vector3d own = scene.masses()[v] * velocities[v].cast<double>();
    const Eigen::Vector3d moment = x[v].cast<double>().cross(own);
    sum.linear += own;
    sum.angular += moment;
    sum.size += own.norm();
    sum.angular_size += moment.norm();
  }
  return sum;
}

/// m/s, of a body, by mass
inline Eigen::Vector3d mean_velocity(const Solver& solver, const Scene& scene, Index body) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto velocities = solver.velocities();
  const Index first = scene.body(body).first_vertex;
  for (Index v = first; v < first + scene.body(body).vertex_count; ++v) {
    sum += scene.masses()[v] * velocities[v].cast<double>();
  }
  return sum / mass_of(scene, body);
}

}  // namespace pbdsurg::testing
