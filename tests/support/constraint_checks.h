// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What every constraint on several vertices must satisfy, whatever it measures.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

template <class Constraint>
struct Sample {
  static constexpr int kCount = Constraint::kVertexCount;

  Vec3<double> x[kCount];
  double w[kCount];

  Sample(double edge, std::uint64_t seed) {
    const auto corners = random_tet(edge, seed);
    for (int i = 0; i < kCount; ++i) {
      x[i] = {corners[i].x(), corners[i].y(), corners[i].z()};
      // inverse masses over two decades, those of tissue with this edge length
      w[i] = std::pow(10.0, 2 * random_unit(seed, 100 + i)) / (1000 * edge * edge * edge);
    }
  }

  [[nodiscard]] double measure(double rest = 0) const { return Constraint::value(x, rest); }

  template <ProjectionMode kMode>
  double project(double rest, double stiffness, double multiplier = 0) {
    const double parameters[] = {rest, stiffness, 0};
    double multipliers[] = {multiplier};
    Constraint::template project<kMode>(x, w, parameters, Substep<double>{1, 1}, multipliers);
    return multipliers[0];
  }
};

/// Would catch a wrong gradient or a scale factor in it: the correction of vertex i must be w_i
/// times the gradient of the value, taken by central differences, times the multiplier.
template <class Constraint>
void check_gradient(double edge, std::uint64_t seed) {
  const Sample<Constraint> before(edge, seed);
  Sample<Constraint> after = before;
  const double rest = 0.99 * before.measure();
  const double multiplier = after.template project<ProjectionMode::compliance>(rest, 0.0);

  const double step = 1e-5 * edge;
  for (int i = 0; i < Constraint::kVertexCount; ++i) {
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Sample<Constraint> low = before, high = before;
      low.x[i].*axis -= step;
      high.x[i].*axis += step;
      const double gradient = (high.measure(rest) - low.measure(rest)) / (2 * step);
      const double moved = after.x[i].*axis - before.x[i].*axis;
      const double scale = std::abs(before.w[i] * multiplier * before.measure() / edge);
      INFO("vertex " << i << " gradient " << gradient);
      CHECK(std::abs(moved - before.w[i] * gradient * multiplier) < 1e-6 * scale);
    }
  }
}

/// Would catch an absolute tolerance that switches the constraint off on small tissue: of a small
/// violation, one rigid projection leaves second order at any scale.
template <class Constraint>
void check_first_order(double edge, std::uint64_t seed) {
  Sample<Constraint> sample(edge, seed);
  const double rest = 0.999 * sample.measure();
  const double before = sample.measure(rest);
  sample.template project<ProjectionMode::fraction>(rest, 1.0);

  CHECK(std::abs(sample.measure(rest)) < 1e-2 * std::abs(before));
}

/// Would catch forces that do not cancel: with all vertices free, a projection keeps the centre of
/// mass and the angular momentum.
template <class Constraint>
void check_momentum(double edge, std::uint64_t seed) {
  const Sample<Constraint> before(edge, seed);
  Sample<Constraint> after = before;
  after.template project<ProjectionMode::fraction>(0.8 * before.measure(), 1.0);

  Vec3<double> linear, angular;
  double scale = 0;
  for (int i = 0; i < Constraint::kVertexCount; ++i) {
    const Vec3<double> impulse = (1 / before.w[i]) * (after.x[i] - before.x[i]);
    linear = linear + impulse;
    angular = angular + cross(before.x[i], impulse);
    scale += std::sqrt(dot(impulse, impulse));
  }
  REQUIRE(scale > 0);
  CHECK(std::sqrt(dot(linear, linear)) < 1e-12 * scale);
  CHECK(std::sqrt(dot(angular, angular)) < 1e-12 * scale * edge);
}

/// Would catch a dependence on the frame: projecting a moved copy gives the moved result.
template <class Constraint>
void check_rigid_motion(double edge, std::uint64_t seed) {
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift = edge * Eigen::Vector3d(3, -2, 5);
  const auto moved = [&](const Vec3<double>& v) {
    const Eigen::Vector3d p = rotation * Eigen::Vector3d(v.x, v.y, v.z) + shift;
    return Vec3<double>{p.x(), p.y(), p.z()};
  };
  Sample<Constraint> here(edge, seed);
  Sample<Constraint> there = here;
  for (auto& x : there.x) {
    x = moved(x);
  }
  const double rest = 0.7 * here.measure();
  here.template project<ProjectionMode::fraction>(rest, 0.5);
  there.template project<ProjectionMode::fraction>(rest, 0.5);

  for (int i = 0; i < Constraint::kVertexCount; ++i) {
    const Vec3<double> difference = there.x[i] - moved(here.x[i]);
    CHECK(std::sqrt(dot(difference, difference)) < 1e-12 * edge);
  }
}

/// Would catch a compliance without its unit: at rest under its own multiplier, C = -a lambda, so a
/// second projection changes nothing.
template <class Constraint>
void check_compliance(double edge, std::uint64_t seed) {
  Sample<Constraint> sample(edge, seed);
  const double rest = 0.9999 * sample.measure();
  // softness of half the mobility, which the multiplier of a rigid projection tells
  Sample<Constraint> rigid = sample;
  const double rigid_multiplier = rigid.template project<ProjectionMode::compliance>(rest, 0.0);
  const double softness = -0.5 * sample.measure(rest) / rigid_multiplier;
  double multiplier = 0;
  for (int i = 0; i < 5; ++i) {
    multiplier = sample.template project<ProjectionMode::compliance>(rest, softness, multiplier);
  }
  CHECK(sample.measure(rest) == Approx(-softness * multiplier).epsilon(1e-6));
}

template <class Constraint>
void check_all() {
  const double edge = GENERATE(1.0, 1e-2, 1e-3, 1e-4);
  const std::uint64_t seed = GENERATE(1, 2, 3);
  check_gradient<Constraint>(edge, seed);
  check_first_order<Constraint>(edge, seed);
  check_momentum<Constraint>(edge, seed);
  check_rigid_motion<Constraint>(edge, seed);
  check_compliance<Constraint>(edge, seed);
}

}  // namespace pbdsurg::testing
