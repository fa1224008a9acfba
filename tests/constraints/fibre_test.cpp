// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/fibre.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "pbdsurg/constraints/vertex_block.h"

#include "tests/support/catch.h"
#include "tests/support/eigen_vectors.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::to_eigen;
using testing::to_vec3;

using Corners = std::array<Eigen::Vector3d, 4>;

constexpr double kModulus = 20e3;  // Pa

// A tetrahedron with fibres along a direction that is no axis of it.
struct Fibres {
  Corners rest;
  Eigen::Vector3d direction = Eigen::Vector3d(2, -1, 3).normalized();
  double parameters[FibreConstraint::kParameterCount];

  Fibres(double edge, std::uint64_t seed) : rest(testing::random_tet(edge, seed)) {
    Eigen::Matrix3d sides;
    for (int k = 0; k < 3; ++k) {
      sides.col(k) = rest[k + 1] - rest[0];
    }
    const Eigen::Vector3d shares = sides.inverse() * direction;
    for (int k = 0; k < 3; ++k) {
      parameters[FibreConstraint::kShares + k] = shares[k];
    }
    parameters[FibreConstraint::kStiffness] = kModulus * sides.determinant() / 6;
  }

  // At rest, longer along the fibres by a factor, sheared and turned.
  [[nodiscard]] Corners stretched(double factor) const {
    const Eigen::Matrix3d longer = Eigen::Matrix3d::Identity() +
                                   (factor - 1) * direction * direction.transpose() +
                                   0.2 * direction.unitOrthogonal() * direction.transpose();
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    Corners x;
    for (std::size_t k = 0; k < 4; ++k) {
      x[k] = turn * longer * rest[k];
    }
    return x;
  }

  // J, of the stretch alone: from the deformation gradient, not from shares
  [[nodiscard]] double energy(const Corners& x) const {
    Eigen::Matrix3d before, after;
    for (int k = 0; k < 3; ++k) {
      before.col(k) = rest[k + 1] - rest[0];
      after.col(k) = x[k + 1] - x[0];
    }
    const double stretch = (after * before.inverse() * direction).norm() - 1;
    return stretch > 0 ? kModulus * before.determinant() / 12 * stretch * stretch : 0;
  }

  // N, by central differences
  [[nodiscard]] Corners forces(const Corners& x) const {
    const double step = 1e-5 * (rest[1] - rest[0]).norm();
    Corners found;
    for (std::size_t k = 0; k < 4; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        Corners low = x, high = x;
        low[k][axis] -= step;
        high[k][axis] += step;
        found[k][axis] = (energy(low) - energy(high)) / (2 * step);
      }
    }
    return found;
  }
};

struct Projection {
  Vec3<double> x[4];
  double multiplier[1];

  explicit Projection(const Corners& corners, double given = 0) : multiplier{given} {
    for (std::size_t k = 0; k < 4; ++k) {
      x[k] = to_vec3(corners[k]);
    }
  }

  Moves<double, 4> project(const Fibres& fibres, const std::array<double, 4>& masses,
                           double inverse_dt_squared) {
    double w[4];
    for (std::size_t k = 0; k < 4; ++k) {
      w[k] = masses[k] > 0 ? 1 / masses[k] : 0;
    }
    const auto moves = FibreConstraint::move<ProjectionMode::compliance>(
        x, w, fibres.parameters, Substep<double>{std::sqrt(inverse_dt_squared), inverse_dt_squared},
        multiplier);
    for (std::size_t k = 0; k < 4; ++k) {
      x[k] = x[k] + moves.of[k];
    }
    return moves;
  }
};

// What the vertex-block method makes of the fibres at one corner.
template <class Energy>
Energy energy_at(const Fibres& fibres, const Corners& x, std::size_t corner) {
  const double* const s = fibres.parameters + FibreConstraint::kShares;
  const std::array<double, 4> shares{-(s[0] + s[1] + s[2]), s[0], s[1], s[2]};
  Eigen::Vector3d stretched = Eigen::Vector3d::Zero();
  double share = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (k != corner) {
      stretched += shares[k] * (x[k] - x[corner]);
      share += shares[k];
    }
  }
  Energy energy;
  energy.add_fibre(fibres.parameters[FibreConstraint::kStiffness], share, to_vec3(stretched));
  return energy;
}

Eigen::Matrix3d matrix_of(const VertexEnergy<double>& energy) {
  Eigen::Matrix3d h;
  h << energy.xx, energy.xy, energy.xz, energy.xy, energy.yy, energy.yz, energy.xz, energy.yz,
      energy.zz;
  return h + energy.isotropic * Eigen::Matrix3d::Identity();
}

}  // namespace

// Would catch a wrong gradient of the projection or of a vertex, a factor in the stiffness, or a
// share of the first corner that is not minus the others'.
TEST_CASE("fibres: forces are minus the gradient of their energy, by every method", "[property]") {
  const double edge = GENERATE(1.0, 1e-2, 1e-4);
  const auto seed = GENERATE(range(std::uint64_t{1}, std::uint64_t{6}));
  const Fibres fibres(edge, seed);
  const Corners x = fibres.stretched(1.3);
  const Corners expected = fibres.forces(x);
  const double scale = expected[0].norm() + expected[1].norm();
  REQUIRE(scale > 0);

  constexpr double kShort = 1e24;  // 1/s^2: a substep so short that what moves resists nothing
  const auto moves = Projection(x).project(fibres, {1, 1, 1, 1}, kShort);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK((kShort * to_eigen(moves.of[k]) - expected[k]).norm() < 1e-5 * scale);
    const auto whole = energy_at<VertexEnergy<double>>(fibres, x, k);
    CHECK((to_eigen(whole.force) - expected[k]).norm() < 1e-5 * scale);
    const auto force = energy_at<VertexForce<double>>(fibres, x, k);
    CHECK((to_eigen(force.force) - expected[k]).norm() < 1e-5 * scale);
  }
}

// Would catch a Hessian of the wrong direction or size; taut fibres are convex, so it is exact.
TEST_CASE("fibres: a vertex's Hessian is the second derivative where they are taut", "[property]") {
  const Fibres fibres(1e-2, GENERATE(range(std::uint64_t{1}, std::uint64_t{6})));
  const Corners x = fibres.stretched(1.3);
  const auto corner = GENERATE(range(std::size_t{0}, std::size_t{4}));
  const Eigen::Matrix3d found = matrix_of(energy_at<VertexEnergy<double>>(fibres, x, corner));
  const double step = 1e-6;
  Eigen::Matrix3d expected;
  for (int axis = 0; axis < 3; ++axis) {
    Corners low = x, high = x;
    low[corner][axis] -= step;
    high[corner][axis] += step;
    const auto before = energy_at<VertexForce<double>>(fibres, low, corner);
    const auto after = energy_at<VertexForce<double>>(fibres, high, corner);
    expected.col(axis) = (to_eigen(before.force) - to_eigen(after.force)) / (2 * step);
  }
  CHECK((found - expected).norm() < 1e-6 * expected.norm());
  CHECK(found.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() > -1e-9 * found.norm());
}

// Would catch fibres that push, and a pull that a slack fibre keeps from an earlier sweep.
TEST_CASE("fibres: slack ones do nothing, and give back what they gave", "[unit]") {
  const Fibres fibres(1e-2, 3);
  const Corners x = fibres.stretched(0.6);
  Projection untouched(x);
  const auto none = untouched.project(fibres, {1e-6, 1e-6, 1e-6, 1e-6}, 1e6);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(to_eigen(none.of[k]).norm() == 0);
    const auto energy = energy_at<VertexEnergy<double>>(fibres, x, k);
    CHECK(to_eigen(energy.force).norm() == 0);
    CHECK(matrix_of(energy).norm() == 0);
  }
  Projection pulled(x, -0.1);
  pulled.project(fibres, {1, 1, 1, 1}, 1e6);  // too heavy to be taut once it is let go
  CHECK(pulled.multiplier[0] == 0);
}

// Would catch a multiplier of another unit: implicit Euler's stretch is minus it.
TEST_CASE("fibres: projections go to implicit Euler's step and keep momentum", "[property]") {
  const Fibres fibres(1e-2, GENERATE(range(std::uint64_t{1}, std::uint64_t{6})));
  const std::array<double, 4> masses{1e-3, 2e-3, 5e-4, 1e-3};
  const Corners start = fibres.stretched(1.4);
  Projection step(start);
  constexpr double kInverseSquare = 1e6;  // 1/s^2
  for (int sweep = 0; sweep < 2000; ++sweep) {
    step.project(fibres, masses, kInverseSquare);
  }
  CHECK(FibreConstraint::value(step.x, fibres.parameters) ==
        Approx(-step.multiplier[0]).epsilon(1e-9));
  CHECK(step.multiplier[0] < 0);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double scale = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d impulse = masses[k] * (to_eigen(step.x[k]) - start[k]);
    momentum += impulse;
    scale += impulse.norm();
  }
  CHECK(momentum.norm() < 1e-10 * scale);
}

// Would catch a division by nothing.
TEST_CASE("fibres: what is fixed, without length or not finite moves nothing", "[unit]") {
  const Fibres fibres(1e-2, 2);
  Corners x = fibres.stretched(1.3);
  const auto is_still = [&](const Corners& corners, double mass) {
    const auto moves = Projection(corners).project(fibres, {mass, mass, mass, mass}, 1e6);
    for (const Vec3<double>& move : moves.of) {
      if (to_eigen(move).norm() != 0) {
        return false;
      }
    }
    return true;
  };
  CHECK_FALSE(is_still(x, 1e-6));
  CHECK(is_still(x, 0));
  CHECK(is_still({x[0], x[0], x[0], x[0]}, 1e-6));
  x[2].y() =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  CHECK(is_still(x, 1e-6));
}

}  // namespace pbdsurg
