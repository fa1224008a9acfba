// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/vertex_block.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/eigen_vectors.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::to_eigen;
using testing::to_vec3;

constexpr double kMu = 1700;       // Pa
constexpr double kLambda = 17000;  // Pa, Lame's + mu

using Points = std::array<Eigen::Vector3d, 4>;

NeoHookeanTerms<double> terms_of(const Points& rest, double mu = kMu, double lambda = kLambda) {
  const Vec3<double> x[4] = {to_vec3(rest[0]), to_vec3(rest[1]), to_vec3(rest[2]),
                             to_vec3(rest[3])};
  return NeoHookeanTerms<double>::at_rest(x, mu, lambda);
}

double volume_of(const Points& x) {
  return (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6;
}

Eigen::Matrix3d shape_of(const Points& x) {
  Eigen::Matrix3d shape;
  shape << x[1] - x[0], x[2] - x[0], x[3] - x[0];
  return shape;
}

// The density of the paper times the rest volume, from the deformation gradient.
double paper_energy(const Points& rest, const Points& x) {
  const Eigen::Matrix3d f = shape_of(x) * shape_of(rest).inverse();
  const double offset = f.determinant() - 1 - kMu / kLambda;
  return volume_of(rest) *
         (kMu / 2 * ((f.transpose() * f).trace() - 3) + kLambda / 2 * offset * offset);
}

struct Spring {
  double stiffness, rest;
  Eigen::Vector3d end;
};

// A vertex of a tetrahedron in flight, tied to a point.
struct Sample {
  Points rest;
  Points x;
  int vertex;
  double inertia;  // N/m
  Eigen::Vector3d flight;
  Spring spring;

  Sample(double edge, std::uint64_t seed)
      : rest(testing::random_tet(edge, seed)),
        x(testing::random_tet(1.3 * edge, seed + 100)),
        vertex(static_cast<int>(seed % 4)),
        inertia(0.3 * kMu * edge),
        flight(x[vertex] + 0.2 * edge * Eigen::Vector3d(1, -2, 1.5)),
        spring{kMu * edge, 0.7 * edge, x[vertex] + edge * Eigen::Vector3d(0.3, 1, -0.6)} {}

  [[nodiscard]] double value(bool with_spring) const {
    const double stretch = (x[vertex] - spring.end).norm() - spring.rest;
    return inertia / 2 * (x[vertex] - flight).squaredNorm() + paper_energy(rest, x) +
           (with_spring ? spring.stiffness / 2 * stretch * stretch : 0);
  }

  [[nodiscard]] VertexEnergy<double> energy(bool with_spring) const {
    VertexEnergy<double> energy;
    energy.add_pull(inertia, to_vec3(flight - x[vertex]));
    const NeoHookeanTerms<double> terms = terms_of(rest);
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = kTetEdges[e];
      if (a == vertex || b == vertex) {
        energy.add_pull(terms.weights[e], to_vec3(x[a + b - vertex] - x[vertex]));
      }
    }
    const auto& face = kTetTriangles[vertex];
    energy.add_volume(terms.stiffness / 36, 6 * terms.target, to_vec3(x[face[0]] - x[vertex]),
                      to_vec3(x[face[1]] - x[vertex]), to_vec3(x[face[2]] - x[vertex]));
    if (with_spring) {
      energy.add_spring(spring.stiffness, spring.rest, to_vec3(spring.end - x[vertex]));
    }
    return energy;
  }
};

Eigen::Matrix3d hessian_of(const VertexEnergy<double>& energy) {
  Eigen::Matrix3d hessian;
  for (int axis = 0; axis < 3; ++axis) {
    hessian.col(axis) = to_eigen(energy * to_vec3(Eigen::Vector3d::Unit(axis)));
  }
  return hessian;
}

}  // namespace

// Would catch a wrong weight, orientation or scale factor, at any size of tissue.
TEST_CASE("vertex block: the force is minus the gradient of the energy", "[property]") {
  const double edge = GENERATE(1.0, 1e-2, 1e-3, 1e-4);
  const std::uint64_t seed = GENERATE(1, 2, 3, 4, 5);
  const bool with_spring = GENERATE(false, true);
  const Sample sample(edge, seed);
  const Eigen::Vector3d force = to_eigen(sample.energy(with_spring).force);

  const double step = 1e-5 * edge;
  for (int axis = 0; axis < 3; ++axis) {
    Sample low = sample, high = sample;
    low.x[sample.vertex][axis] -= step;
    high.x[sample.vertex][axis] += step;
    const double gradient = (high.value(with_spring) - low.value(with_spring)) / (2 * step);
    CHECK(force[axis] == Approx(-gradient).margin(1e-6 * kLambda * edge * edge));
  }
}

TEST_CASE("vertex block: the Hessian is that of the energy, without what is negative",
          "[property]") {
  const std::uint64_t seed = GENERATE(1, 2, 3, 4, 5);
  const double edge = 2e-3;
  Sample sample(edge, seed);
  const double rest_factor = GENERATE(0.5, 2.0);  // pulled and pushed together
  sample.spring.rest = rest_factor * (sample.x[sample.vertex] - sample.spring.end).norm();
  const double step = 1e-5 * edge;

  Eigen::Matrix3d numeric;
  for (int axis = 0; axis < 3; ++axis) {
    Sample low = sample, high = sample;
    low.x[sample.vertex][axis] -= step;
    high.x[sample.vertex][axis] += step;
    numeric.col(axis) = to_eigen(low.energy(true).force - high.energy(true).force) / (2 * step);
  }
  if (rest_factor > 1) {
    const Eigen::Vector3d n = (sample.spring.end - sample.x[sample.vertex]).normalized();
    numeric += sample.spring.stiffness * (rest_factor - 1) *
               (Eigen::Matrix3d::Identity() - n * n.transpose());
  }

  CHECK((hessian_of(sample.energy(true)) - numeric).norm() < 1e-6 * numeric.norm());
}

TEST_CASE("vertex block: one step reaches the least energy, from inverted tetrahedra too",
          "[property]") {
  const double edge = GENERATE(1.0, 1e-3, 1e-4);
  const std::uint64_t seed = GENERATE(1, 2, 3, 4, 5, 6, 7, 8);
  const bool inverted = GENERATE(false, true);
  Sample sample(edge, seed);
  if (inverted) {  // through the opposite face
    const auto& face = kTetTriangles[sample.vertex];
    const Eigen::Vector3d centre = (sample.x[face[0]] + sample.x[face[1]] + sample.x[face[2]]) / 3;
    sample.x[sample.vertex] = centre - 0.8 * (sample.x[sample.vertex] - centre);
    REQUIRE(volume_of(sample.x) < 0);
  }
  const double before = sample.value(false);
  const VertexEnergy<double> energy = sample.energy(false);
  const Eigen::Vector3d move = to_eigen(VertexFactor<double>(energy).solve(energy.force));
  Sample after = sample;
  after.x[sample.vertex] += move;

  CHECK(after.value(false) < before);
  CHECK(to_eigen(after.energy(false).force).norm() < 1e-9 * to_eigen(energy.force).norm());
  // quadratic: over-relaxed by any factor below two, the energy still falls
  Sample beyond = sample;
  beyond.x[sample.vertex] += 1.95 * move;
  CHECK(beyond.value(false) < before);
}

TEST_CASE("vertex block: nothing pulls at a Neo-Hookean tetrahedron at rest", "[unit]") {
  const double edge = GENERATE(1.0, 1e-4);
  Sample sample(edge, 3);
  sample.x = sample.rest;
  sample.flight = sample.x[sample.vertex];

  CHECK(to_eigen(sample.energy(false).force).norm() < 1e-9 * kLambda * edge * edge);
}

// Small stretch along x and free sides: the stress must be Young's modulus times the strain.
TEST_CASE("vertex block: small strains feel the moduli asked for", "[property]") {
  const double youngs_modulus = 5000, ratio = 0.4;
  const double mu = youngs_modulus / (2 * (1 + ratio));
  const double lame = youngs_modulus * ratio / ((1 + ratio) * (1 - 2 * ratio));
  const Points rest = testing::random_tet(1e-3, 9);
  const NeoHookeanTerms<double> terms = terms_of(rest, mu, lame + mu);
  const double strain = 1e-6;
  const Eigen::Vector3d factors(1 + strain, 1 - ratio * strain, 1 - ratio * strain);

  // virial: the sum of the forces of the energy times positions is volume times stress
  Points x = rest;
  for (Eigen::Vector3d& p : x) {
    p = p.cwiseProduct(factors);
  }
  Eigen::Matrix3d virial = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 4; ++i) {
    VertexEnergy<double> energy;
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [a, b] = kTetEdges[e];
      if (a == i || b == i) {
        energy.add_pull(terms.weights[e], to_vec3(x[a + b - i] - x[i]));
      }
    }
    const auto& face = kTetTriangles[i];
    energy.add_volume(terms.stiffness / 36, 6 * terms.target, to_vec3(x[face[0]] - x[i]),
                      to_vec3(x[face[1]] - x[i]), to_vec3(x[face[2]] - x[i]));
    virial -= to_eigen(energy.force) * rest[i].transpose();
  }
  const Eigen::Matrix3d stress = virial / volume_of(rest);

  CHECK(stress(0, 0) == Approx(youngs_modulus * strain).epsilon(1e-4));
  CHECK(std::abs(stress(1, 1)) < 1e-4 * youngs_modulus * strain);
  CHECK(std::abs(stress(0, 1)) < 1e-4 * youngs_modulus * strain);
}

TEST_CASE("vertex block: a resized tetrahedron is one made at that size", "[unit]") {
  const Points rest = testing::random_tet(1e-3, 4);
  const double scale = 0.8;
  Points shrunk = rest;
  for (Eigen::Vector3d& p : shrunk) {
    p *= scale;
  }

  const NeoHookeanTerms<double> resized = terms_of(rest).resized(scale * scale * scale);
  const NeoHookeanTerms<double> made = terms_of(shrunk);

  for (int e = 0; e < 6; ++e) {
    CHECK(resized.weights[e] == Approx(made.weights[e]));
  }
  CHECK(resized.stiffness == Approx(made.stiffness));
  CHECK(resized.target == Approx(made.target));
}

TEST_CASE("vertex block: a moved and turned copy moves alike", "[property]") {
  const double edge = 1e-3;
  const std::uint64_t seed = GENERATE(1, 2, 3, 4);
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift = edge * Eigen::Vector3d(3, -2, 5);
  const Sample here(edge, seed);
  Sample there = here;
  for (Eigen::Vector3d& p : there.x) {
    p = rotation * p + shift;
  }
  there.flight = rotation * here.flight + shift;
  there.spring.end = rotation * here.spring.end + shift;

  const auto move = [](const Sample& sample) {
    const VertexEnergy<double> energy = sample.energy(true);
    return to_eigen(VertexFactor<double>(energy).solve(energy.force));
  };
  CHECK((move(there) - rotation * move(here)).norm() < 1e-9 * edge);
}

// Would catch a pivot that rounding makes zero or negative: sizes and stiffness ratios of tissue,
// and worse, in single precision.
TEST_CASE("vertex block: a step stays finite and downhill in single precision", "[property]") {
  const float edge = GENERATE(1e-2F, 1e-3F, 1e-4F);
  const float ratio = GENERATE(1.0F, 1e4F, 1e8F, 1e12F);  // volume against inertia
  VertexEnergy<float> energy;
  const Vec3<float> x{0.3F * edge, 0.2F * edge, 0.9F * edge};
  energy.add_pull(1e-3F, {0, 0, -edge});
  energy.add_volume(ratio * 1e-3F / (edge * edge * edge * edge), 0.1F * edge * edge * edge,
                    Vec3<float>{edge, 0, 0} - x, Vec3<float>{0, edge, 0} - x,
                    Vec3<float>{0, 0, 0.1F * edge} - x);

  const Vec3<float> move = VertexFactor<float>(energy).solve(energy.force);

  CHECK(std::isfinite(dot(move, move)));
  CHECK(dot(move, energy.force) > 0);
  CHECK(std::sqrt(dot(move, move)) < 100 * edge);
}

TEST_CASE("vertex block: a spring between two vertices at one point stays finite", "[unit]") {
  VertexEnergy<float> energy;
  energy.add_spring(10.0F, 1e-3F, {0, 0, 0});

  CHECK(energy.force.x == 0);
  CHECK(energy.isotropic == 10);
  CHECK(energy.xx == 0);
}

}  // namespace pbdsurg
