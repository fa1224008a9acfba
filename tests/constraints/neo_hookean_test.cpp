// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/neo_hookean.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using Corners = std::array<Eigen::Vector3d, 4>;

constexpr double kShear = 2000;  // Pa

Eigen::Matrix3d sides(const Corners& x) {
  Eigen::Matrix3d result;
  result << x[1] - x[0], x[2] - x[0], x[3] - x[0];
  return result;
}

// One tetrahedron of tissue, whose energy is computed apart from the constraint.
template <class Scalar = double>
struct Tet1 {
  Corners rest;
  double poissons_ratio = 0.45;
  double dt = 1e-3;       // s
  double relaxation = 0;  // s
  std::array<Scalar, 4> w{};

  explicit Tet1(double edge, std::uint64_t seed = 1) : rest(testing::random_tet(edge, seed)) {
    for (int i = 0; i < 4; ++i) {
      // inverse masses over a decade, those of tissue with this edge length
      w[i] = static_cast<Scalar>(std::pow(10.0, random_unit(seed, 100 + i)) /
                                 (1000 * edge * edge * edge));
    }
  }

  [[nodiscard]] double rest_volume() const { return sides(rest).determinant() / 6; }
  [[nodiscard]] double ratio() const { return 1 / (1 - 2 * poissons_ratio); }
  [[nodiscard]] double impulse_unit() const { return kShear * rest_volume() * dt * dt; }

  [[nodiscard]] double energy(const Corners& x) const {
    const Eigen::Matrix3d f = sides(x) * sides(rest).inverse();
    const double swelling = f.determinant() - 1 - 1 / ratio();
    return rest_volume() * kShear / 2 * (f.squaredNorm() - 3 + ratio() * swelling * swelling);
  }

  [[nodiscard]] Eigen::Vector3d energy_gradient(const Corners& x, int vertex) const {
    const double step = 1e-5 * std::cbrt(rest_volume());
    Eigen::Vector3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      Corners low = x, high = x;
      low[vertex][axis] -= step;
      high[vertex][axis] += step;
      gradient[axis] = (energy(high) - energy(low)) / (2 * step);
    }
    return gradient;
  }

  std::array<Scalar, 9> multipliers{};

  // @param start  with friction against it
  void project(Corners& x, const Corners* start = nullptr) {
    Vec3<Scalar> points[4];
    Damped<Scalar, 4> damping;
    Scalar weights[4], parameters[NeoHookeanConstraint::kParameterCount];
    for (int i = 0; i < 4; ++i) {
      const auto convert = [](const Eigen::Vector3d& p) {
        return Vec3<Scalar>{static_cast<Scalar>(p.x()), static_cast<Scalar>(p.y()),
                            static_cast<Scalar>(p.z())};
      };
      points[i] = convert(x[i]);
      damping.start[i] = convert(start ? (*start)[i] : x[i]);
      weights[i] = w[i];
    }
    const Eigen::Matrix3d inverse = sides(rest).inverse();
    for (int i = 0; i < 9; ++i) {
      parameters[NeoHookeanConstraint::kInverseShape + i] =
          static_cast<Scalar>(inverse(i / 3, i % 3));
    }
    parameters[NeoHookeanConstraint::kStiffness] = static_cast<Scalar>(kShear * rest_volume());
    parameters[NeoHookeanConstraint::kRatio] = static_cast<Scalar>(ratio());
    parameters[NeoHookeanConstraint::kDamping] = static_cast<Scalar>(relaxation);
    Scalar stored[9];
    std::copy(multipliers.begin(), multipliers.end(), stored);
    const Substep<Scalar> substep{static_cast<Scalar>(1 / dt), static_cast<Scalar>(1 / (dt * dt))};
    if (start) {
      NeoHookeanConstraint::project<ProjectionMode::compliance>(points, weights, parameters,
                                                                substep, stored, damping);
    } else {
      NeoHookeanConstraint::project<ProjectionMode::compliance>(points, weights, parameters,
                                                                substep, stored);
    }
    std::copy(std::begin(stored), std::end(stored), multipliers.begin());
    for (int i = 0; i < 4; ++i) {
      x[i] = {points[i].x, points[i].y, points[i].z};
    }
  }

  // Corners shaken by a share of the edge.
  [[nodiscard]] Corners shaken(double share, std::uint64_t seed) const {
    Corners x = rest;
    for (int i = 0; i < 4; ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        x[i][axis] +=
            share * std::cbrt(6 * rest_volume()) * (2 * random_unit(seed, i, 10 + axis) - 1);
      }
    }
    return x;
  }
};

double edge_scale() {
  return GENERATE(1.0, 1e-2, 1e-3, 1e-4);
}

double largest_move(const Corners& a, const Corners& b) {
  double largest = 0;
  for (int i = 0; i < 4; ++i) {
    largest = std::max(largest, (a[i] - b[i]).norm());
  }
  return largest;
}

Corners moved(const Corners& x, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& shift) {
  Corners result;
  for (int i = 0; i < 4; ++i) {
    result[i] = rotation * x[i] + shift;
  }
  return result;
}

const Eigen::Matrix3d kTurn =
    Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();

}  // namespace

// Would catch a wrong gradient or a factor: where the step is so short that nothing else acts, the
// impulse is the force of the energy, taken by central differences.
TEST_CASE("neo-hookean constraint: its impulse is that of the energy", "[property]") {
  Tet1 tet(edge_scale(), GENERATE(1, 2, 3));
  tet.dt = 1e-5 * std::cbrt(tet.rest_volume());
  const Corners before = tet.shaken(0.3, 7);
  Corners after = before;
  tet.project(after);
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d expected = -tet.w[i] * tet.dt * tet.dt * tet.energy_gradient(before, i);
    CHECK((after[i] - before[i] - expected).norm() < 1e-3 * expected.norm());
  }
}

// Would catch moduli that are not those asked for.
TEST_CASE("neo-hookean constraint: small strain meets Hooke's law", "[validation]") {
  Tet1 tet(edge_scale(), 2);
  tet.poissons_ratio = GENERATE(0.0, 0.3, 0.49);
  tet.w = {};  // then the multiplier is the stress
  const double lambda = kShear * 2 * tet.poissons_ratio / (1 - 2 * tet.poissons_ratio);
  Eigen::Matrix3d strain;
  strain << 2, 0.3, -1, 0.3, -1, 0.7, -1, 0.7, 0.5;
  strain *= 1e-6;
  Corners x = moved(tet.rest, kTurn * (Eigen::Matrix3d::Identity() + strain), {0, 0, 0});
  tet.project(x);
  const Eigen::Matrix3d expected =
      kTurn * (2 * kShear * strain + lambda * strain.trace() * Eigen::Matrix3d::Identity());
  // a fixed tetrahedron takes the whole of mu, and its share of the volume, at once
  const Eigen::Matrix3d stress =
      -kShear * Eigen::Map<const Eigen::Matrix3d>(tet.multipliers.data());
  CHECK((stress - expected).norm() < 1e-4 * expected.norm());
}

TEST_CASE("neo-hookean constraint: at rest, however turned, nothing moves", "[property]") {
  Tet1 tet(edge_scale(), 3);
  tet.dt = GENERATE(1e-5, 1e-2);
  tet.poissons_ratio = GENERATE(0.0, 0.45, 0.499);
  tet.relaxation = 0.1;
  const double edge = std::cbrt(tet.rest_volume());
  const Corners start = tet.rest;
  const Corners turned = moved(tet.rest, kTurn, edge * Eigen::Vector3d(3, -2, 5));
  Corners x = turned;
  tet.project(x);
  CHECK(largest_move(x, turned) < 1e-11 * edge);
  tet.multipliers = {};
  tet.project(x, &start);  // friction does not feel the turn either
  CHECK(largest_move(x, turned) < 1e-11 * edge);
}

// Would catch forces that do not cancel: with all vertices free, a projection keeps the centre of
// mass and the angular momentum.
TEST_CASE("neo-hookean constraint: momentum is kept", "[property]") {
  Tet1 tet(edge_scale(), GENERATE(1, 2, 3));
  tet.dt = GENERATE(1e-3, 10.0) * std::cbrt(tet.rest_volume());
  tet.relaxation = 0.01;
  const Corners start = tet.shaken(0.2, 8), before = tet.shaken(0.3, 9);
  Corners after = before;
  tet.project(after, &start);
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = Eigen::Vector3d::Zero();
  double scale = 0;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d impulse = (after[i] - before[i]) / tet.w[i];
    linear += impulse;
    angular += before[i].cross(impulse);
    scale += impulse.norm();
  }
  REQUIRE(scale > 0);
  CHECK(linear.norm() < 1e-11 * scale);
  CHECK(angular.norm() < 1e-10 * scale * std::cbrt(6 * tet.rest_volume()));
}

TEST_CASE("neo-hookean constraint: a moved copy gives the moved result", "[property]") {
  Tet1 tet(edge_scale(), 4);
  tet.relaxation = 0.01;
  const double edge = std::cbrt(6 * tet.rest_volume());
  const Eigen::Vector3d shift = edge * Eigen::Vector3d(3, -2, 5);
  const Corners start = tet.shaken(0.2, 8);
  Corners here = tet.shaken(0.3, 9);
  const Corners moved_start = moved(start, kTurn, shift);
  Corners there = moved(here, kTurn, shift);
  tet.project(here, &start);
  tet.multipliers = {};
  tet.project(there, &moved_start);
  CHECK(largest_move(there, moved(here, kTurn, shift)) < 1e-11 * edge);
}

// Would catch a fixed point that depends on how the projection gets there, and a projection that
// overshoots: repeated, it solves the implicit step of one tetrahedron from soft to nearly rigid.
TEST_CASE("neo-hookean constraint: projections converge to the implicit step", "[property]") {
  Tet1 tet(edge_scale(), GENERATE(1, 2, 3));
  tet.poissons_ratio = GENERATE(0.0, 0.45, 0.49);
  const double stiffness = GENERATE(0.01, 1.0, 100.0);  // impulse unit times mobility
  tet.dt = std::sqrt(stiffness / (tet.w[0] * kShear * std::cbrt(tet.rest_volume())));
  const double edge = std::cbrt(6 * tet.rest_volume());
  const Corners predicted = tet.shaken(0.15, 9);
  Corners x = predicted;
  for (int i = 0; i < 2000; ++i) {
    tet.project(x);
  }
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d impulse = (x[i] - predicted[i]) / tet.w[i];
    const Eigen::Vector3d expected = -tet.dt * tet.dt * tet.energy_gradient(x, i);
    CHECK((impulse - expected).norm() < 1e-4 * edge / tet.w[i]);
  }
  if (stiffness > 10) {
    CHECK((sides(x) * sides(tet.rest).inverse()).determinant() == Approx(1).epsilon(0.05));
  }
}

TEST_CASE("neo-hookean constraint: from any shape it goes back to rest", "[property]") {
  Tet1<float> tet(GENERATE(1e-2, 1e-4), 5);
  tet.dt = GENERATE(0.2, 0.5, 5.0) * std::cbrt(tet.rest_volume());
  const auto seed = GENERATE(1, 2, 3, 4, 5);
  Corners x = seed == 1 ? moved(tet.rest, Eigen::Vector3d(-1, 1, 1).asDiagonal(), {0, 0, 0})
                        : tet.shaken(1.5, seed);
  const Corners start = x;
  double volume = 0;
  for (int i = 0; i < 3000; ++i) {
    tet.multipliers = {};  // a new substep, without memory of speed
    tet.project(x);
    volume = sides(x).determinant() / 6;
  }
  CHECK(largest_move(x, start) < 20 * std::cbrt(tet.rest_volume()));
  CHECK(volume == Approx(tet.rest_volume()).epsilon(1e-2));
  CHECK((sides(x) * sides(tet.rest).inverse()).squaredNorm() == Approx(3).epsilon(1e-2));
}

TEST_CASE("neo-hookean constraint: shapes without volume stay finite", "[unit]") {
  Tet1<float> tet(1e-3, 1);
  tet.dt = GENERATE(1e-5, 1e-3, 1.0);
  const Eigen::Vector3d keep =
      GENERATE(Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 0),
               Eigen::Vector3d(1e4, 1e4, 1e4), Eigen::Vector3d(1e20, 1, 1));
  Corners x = moved(tet.rest, keep.asDiagonal(), {1e-2, 1e-2, 1e-2});
  for (int i = 0; i < 10; ++i) {
    tet.project(x);
    for (const Eigen::Vector3d& p : x) {
      CHECK(p.allFinite());
    }
  }
}

TEST_CASE("neo-hookean constraint: what is fixed or not finite moves nothing", "[unit]") {
  Tet1<float> tet(1e-3, 1);
  tet.w[2] = 0;
  const Corners before = tet.shaken(0.2, 3);
  Corners x = before;
  tet.project(x);
  CHECK((x[2].cast<float>() == before[2].cast<float>()));
  CHECK((x[1].cast<float>() != before[1].cast<float>()));

  const double bad =
      GENERATE(std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  const int which = GENERATE(0, 3);
  Corners broken = before;
  broken[which].y() = bad;
  tet.multipliers = {};
  tet.project(broken);
  for (int i = 0; i < 4; ++i) {
    if (i != which) {
      CHECK((broken[i].cast<float>() == before[i].cast<float>()));
    }
  }
  for (const float multiplier : tet.multipliers) {
    CHECK(multiplier == 0);
  }
}

TEST_CASE("neo-hookean constraint: its value is the excess of volume", "[unit]") {
  Vec3<double> x[4] = {{0, 0, 0}, {2e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, 1.1e-3}};
  const double parameters[] = {1e3, 0, 0, 0, 1e3, 0, 0, 0, 1e3, 1, 10, 0};
  CHECK(NeoHookeanConstraint::value(x, parameters) == Approx(1.2));
}

}  // namespace pbdsurg
