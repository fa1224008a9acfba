// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/membrane.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "tests/support/catch.h"
#include "tests/support/eigen_vectors.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::to_eigen;
using testing::to_vec3;
using TriangleCorners = std::array<Eigen::Vector3d, 3>;

TriangleCorners random_corners(double edge, std::uint64_t seed) {
  const auto tet = testing::random_tet(edge, seed);
  return {tet[0], tet[1], tet[2]};
}

// One triangle, whose energy is computed apart from the constraint, by its metric.
struct Triangle1 {
  TriangleCorners rest;
  double mu = 40;  // N/m
  double poissons_ratio = 0.4;
  double dt = 1e-3;       // s
  double relaxation = 0;  // s
  std::array<double, 3> w{};
  std::array<double, 6> multipliers{};

  explicit Triangle1(double edge, std::uint64_t seed = 1) : rest(random_corners(edge, seed)) {
    for (int i = 0; i < 3; ++i) {
      // inverse masses over a decade, those of a sheet of 1 mm with this edge length
      w[i] = std::pow(10.0, random_unit(seed, 100 + i)) / (0.3 * edge * edge);
    }
  }

  [[nodiscard]] double ratio() const { return (1 + poissons_ratio) / (1 - poissons_ratio); }
  [[nodiscard]] static double area_of(const TriangleCorners& x) {
    return (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2;
  }
  [[nodiscard]] Eigen::Matrix2d sides() const {  // at rest, in the plane
    const Eigen::Vector3d first = rest[1] - rest[0], second = rest[2] - rest[0];
    Eigen::Matrix2d result;
    result << first.norm(), first.normalized().dot(second), 0,
        first.normalized().cross(second).norm();
    return result;
  }

  [[nodiscard]] double energy(const TriangleCorners& x) const {
    Eigen::Matrix<double, 3, 2> now;
    now << x[1] - x[0], x[2] - x[0];
    const double stretch = (now * sides().inverse()).squaredNorm();
    const double area = area_of(rest);
    const double swelling = area_of(x) / area - 1 - 1 / ratio();
    return area * mu / 2 * (stretch - 2 + ratio() * swelling * swelling);
  }

  [[nodiscard]] Eigen::Vector3d gradient(const TriangleCorners& x, int vertex) const {
    const double step = 1e-5 * std::sqrt(area_of(rest));
    Eigen::Vector3d result;
    for (int axis = 0; axis < 3; ++axis) {
      TriangleCorners low = x, high = x;
      low[vertex][axis] -= step;
      high[vertex][axis] += step;
      result[axis] = (energy(high) - energy(low)) / (2 * step);
    }
    return result;
  }

  void project(TriangleCorners& x, const TriangleCorners* start = nullptr) {
    const Eigen::Matrix2d inverse = sides().inverse();
    const double parameters[] = {inverse(0, 0),      inverse(0, 1), inverse(1, 0), inverse(1, 1),
                                 mu * area_of(rest), ratio(),       relaxation};
    Vec3<double> points[3];
    double weights[3], given[6];
    Damped<double, 3> damping;
    for (int i = 0; i < 3; ++i) {
      points[i] = to_vec3(x[i]);
      damping.start[i] = to_vec3(start != nullptr ? (*start)[i] : x[i]);
      weights[i] = w[i];
    }
    std::copy(multipliers.begin(), multipliers.end(), given);
    const Substep<double> substep{1 / dt, 1 / (dt * dt)};
    if (start != nullptr) {
      MembraneConstraint::project<ProjectionMode::compliance>(points, weights, parameters, substep,
                                                              given, damping);
    } else {
      MembraneConstraint::project<ProjectionMode::compliance>(points, weights, parameters, substep,
                                                              given);
    }
    std::copy(std::begin(given), std::end(given), multipliers.begin());
    for (int i = 0; i < 3; ++i) {
      x[i] = to_eigen(points[i]);
    }
  }
};

// Stretched, sheared and turned out of its plane.
TriangleCorners deformed(const TriangleCorners& rest, std::uint64_t seed) {
  TriangleCorners x = rest;
  const double edge = (rest[1] - rest[0]).norm();
  for (std::uint64_t i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      x[i][axis] += 0.6 * edge * (random_unit(seed, 50 + i, axis) - 0.5);
    }
  }
  return x;
}

}  // namespace

// Would catch a wrong stress, or modulus, or scale of it: what so soft a triangle gives in one
// projection is minus the gradient of its energy, times dt^2 and the inverse mass.
TEST_CASE("membrane: a projection of soft tissue gives the force of the energy", "[unit]") {
  const double edge = GENERATE(1.0, 1e-3);
  const std::uint64_t seed = GENERATE(1, 2, 3, 4);
  Triangle1 triangle(edge, seed);
  triangle.mu = 1e-6 / (triangle.w[0] * triangle.dt * triangle.dt);
  const TriangleCorners before = deformed(triangle.rest, seed);
  TriangleCorners after = before;
  triangle.project(after);
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d force =
        (after[i] - before[i]) / (triangle.w[i] * triangle.dt * triangle.dt);
    CHECK((force + triangle.gradient(before, i)).norm() < 1e-4 * triangle.mu * edge);
  }
}

// Would catch a pull on a sheet at rest, and forces that do not cancel.
TEST_CASE("membrane: rest is at rest, and projections keep momentum", "[unit]") {
  const std::uint64_t seed = GENERATE(1, 2, 3);
  const double edge = 4e-3;
  Triangle1 triangle(edge, seed);
  TriangleCorners still = triangle.rest;
  triangle.project(still);
  for (int i = 0; i < 3; ++i) {
    CHECK((still[i] - triangle.rest[i]).norm() < 1e-12 * edge);
  }
  triangle.multipliers = {};
  const TriangleCorners before = deformed(triangle.rest, seed);
  TriangleCorners after = before;
  triangle.project(after);
  Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = linear;
  double scale = 0;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d impulse = (after[i] - before[i]) / triangle.w[i];
    linear += impulse;
    angular += before[i].cross(impulse);
    scale += impulse.norm();
  }
  REQUIRE(scale > 0);
  CHECK(linear.norm() < 1e-12 * scale);
  CHECK(angular.norm() < 1e-11 * scale * edge);
}

// Would catch a projection that stops short of implicit Euler's step, or diverges: soft and stiff,
// stretched and compressed.
TEST_CASE("membrane: projections converge to a step of implicit Euler", "[property]") {
  const double stiffness = GENERATE(0.01, 1.0, 100.0);  // times mobility, over a substep
  const std::uint64_t seed = GENERATE(1, 2, 3, 4, 5);
  const double edge = 4e-3;
  Triangle1 triangle(edge, seed);
  triangle.mu = stiffness / (triangle.w[0] * triangle.dt * triangle.dt);
  const TriangleCorners start = deformed(triangle.rest, seed);
  TriangleCorners x = start;
  for (int i = 0; i < 3000; ++i) {
    triangle.project(x);
  }
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d impulse = (x[i] - start[i]) / triangle.w[i];
    const Eigen::Vector3d expected = -triangle.dt * triangle.dt * triangle.gradient(x, i);
    CHECK((impulse - expected).norm() < 1e-4 * edge / triangle.w[i]);
  }
}

// Would catch friction of rigid motion, or none of stretch: seven tenths of a stretch that friction
// opposes are left where without it next to nothing is.
TEST_CASE("membrane: friction resists stretch and no turn", "[unit]") {
  Triangle1 triangle(4e-3);
  triangle.mu = 10;
  triangle.relaxation = 5e-3;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  TriangleCorners x = triangle.rest;
  for (Eigen::Vector3d& corner : x) {
    corner = turn * corner;
  }
  const TriangleCorners turned = x;
  triangle.project(x, &triangle.rest);
  for (int i = 0; i < 3; ++i) {
    CHECK((x[i] - turned[i]).norm() < 1e-9);
  }
  const auto left_of_stretch = [](double relaxation) {
    Triangle1 stretched(4e-3);
    stretched.mu = 1e5;
    stretched.relaxation = relaxation;
    TriangleCorners start = stretched.rest;
    for (Eigen::Vector3d& corner : start) {
      corner *= 1.1;
    }
    TriangleCorners end = start;
    for (int i = 0; i < 200; ++i) {
      stretched.project(end, &start);
    }
    return (Triangle1::area_of(end) / Triangle1::area_of(stretched.rest) - 1) / 0.21;
  };
  CHECK(left_of_stretch(0) < 0.05);
  CHECK(left_of_stretch(1e-2) > 0.8);
}

// Would catch a division by an area of zero, or one vertex that takes others with it.
TEST_CASE("membrane: a triangle without area or with a lost vertex stays finite", "[unit]") {
  Triangle1 triangle(4e-3);
  TriangleCorners x = triangle.rest;
  x[2] = (x[0] + x[1]) / 2;
  const TriangleCorners flat = x;
  triangle.project(x);
  for (int i = 0; i < 3; ++i) {
    CHECK(x[i].allFinite());
  }
  CHECK((x[1] - x[0]).norm() < (flat[1] - flat[0]).norm());
  triangle.multipliers = {};
  x = triangle.rest;
  x[2].x() = std::numeric_limits<double>::quiet_NaN();
  triangle.project(x);
  CHECK(x[0] == triangle.rest[0]);
  CHECK(x[1] == triangle.rest[1]);
}

namespace {

// The same triangle as the vertex-block method has it.
struct VertexTerms {
  explicit VertexTerms(const Triangle1& triangle) {
    const Vec3<double> x[3] = {to_vec3(triangle.rest[0]), to_vec3(triangle.rest[1]),
                               to_vec3(triangle.rest[2])};
    terms = MembraneTerms<double>::at_rest(x, triangle.mu, triangle.mu * triangle.ratio());
  }

  template <class Energy>
  void add(const TriangleCorners& x, int corner, Energy& energy) const {
    const int a = (corner + 1) % 3, b = (corner + 2) % 3;
    energy.add_triangle(terms.weights[b], terms.weights[a], terms.stiffness, terms.target,
                        to_vec3(x[a] - x[corner]), to_vec3(x[b] - x[corner]));
  }

  MembraneTerms<double> terms{};
};

}  // namespace

// Would catch another energy than that of projections, or a wrong corner, sign or factor.
TEST_CASE("membrane: vertex blocks follow the gradient of the same energy", "[unit]") {
  const double edge = GENERATE(1.0, 1e-3);
  const std::uint64_t seed = GENERATE(1, 2, 3, 4);
  const Triangle1 triangle(edge, seed);
  const VertexTerms terms(triangle);
  const TriangleCorners x = deformed(triangle.rest, seed);
  for (int i = 0; i < 3; ++i) {
    VertexEnergy<double> energy;
    terms.add(x, i, energy);
    CHECK((to_eigen(energy.force) + triangle.gradient(x, i)).norm() < 1e-4 * triangle.mu * edge);
    VertexForce<double> force;
    terms.add(x, i, force);
    CHECK((to_eigen(force.force) - to_eigen(energy.force)).norm() < 1e-12 * triangle.mu * edge);
  }
}

// Would catch a Hessian that is not the energy's within the plane, where steps are to be exact, or
// that is not positive: compressed triangles, too.
TEST_CASE("membrane: one vertex alone goes to its least energy in the plane", "[unit]") {
  const std::uint64_t seed = GENERATE(1, 2, 3, 4, 5, 6, 7, 8);
  const double size = GENERATE(0.3, 1.0, 1.5);
  Triangle1 triangle(4e-3, seed);
  const VertexTerms terms(triangle);
  TriangleCorners x = deformed(triangle.rest, seed);
  for (Eigen::Vector3d& corner : x) {
    corner *= size;
  }
  const double before = triangle.energy(x);
  VertexEnergy<double> energy;
  energy.isotropic = 1e-9 * triangle.mu;
  terms.add(x, 0, energy);
  Eigen::Matrix3d square;
  square << energy.xx, energy.xy, energy.xz, energy.xy, energy.yy, energy.yz, energy.xz, energy.yz,
      energy.zz;
  CHECK(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(square).eigenvalues()[0] >
        -1e-9 * triangle.mu);
  x[0] += to_eigen(VertexFactor<double>(energy).solve(energy.force));
  CHECK(triangle.energy(x) <= before + 1e-12 * triangle.mu);
  CHECK(triangle.gradient(x, 0).norm() < 1e-4 * triangle.mu * 4e-3);
}

// Would catch a stiffness across the plane at rest, where a membrane has none, or none under
// tension, where it is the tension: of a fan of six at 10 % stretch.
TEST_CASE("membrane: what resists across the plane is the tension", "[unit]") {
  const double stretch = GENERATE(1.0, 1.1);
  constexpr double kMu = 40, kLambda = 90;  // N/m
  VertexEnergy<double> energy;
  const auto corner = [](int i) {
    return Vec3<double>{std::cos(i * std::acos(-1.0) / 3), std::sin(i * std::acos(-1.0) / 3), 0};
  };
  for (int i = 0; i < 6; ++i) {
    const Vec3<double> rest[3] = {{}, corner(i), corner(i + 1)};
    const auto terms = MembraneTerms<double>::at_rest(rest, kMu, kLambda);
    energy.add_triangle(terms.weights[2], terms.weights[1], terms.stiffness, terms.target,
                        stretch * corner(i), stretch * corner(i + 1));
  }
  const double tension = kMu + kLambda * (stretch * stretch - 1 - kMu / kLambda);  // N/m
  // six edges with a cotangent weight each
  CHECK(energy.zz + energy.isotropic == Approx(6 / std::sqrt(3.0) * tension).margin(1e-9));
}

}  // namespace pbdsurg
