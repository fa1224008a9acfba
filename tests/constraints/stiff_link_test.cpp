// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/stiff_link.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstdint>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"
#include "tests/support/constraint_checks.h"
#include "tests/support/eigen_vectors.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kNotANumber;
using testing::to_eigen;
using testing::to_vec3;
using Joint = StiffLinkConstraint::Joint<double>;

// One after another.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : seed_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * random_unit(seed_, 0, count_++);
  }
  Vec3<double> vector() {
    const double x = between(-1, 1), y = between(-1, 1);
    return {x, y, between(-1, 1)};
  }

 private:
  std::uint64_t seed_;
  std::uint64_t count_ = 0;
};

// The energy of a vertex on its own.
struct Vertex {
  VertexEnergy<double> energy;
  Eigen::Matrix3d hessian;
  Eigen::Vector3d force;

  explicit Vertex(RandomNumbers& random) {
    energy.add_pull(random.between(0.5, 2), random.vector());
    for (int i = 0; i < 3; ++i) {
      energy.add_spring(random.between(0, 30), 0.1, random.vector());
    }
    hessian << energy.xx, energy.xy, energy.xz, energy.xy, energy.yy, energy.yz, energy.xz,
        energy.yz, energy.zz;
    hessian += energy.isotropic * Eigen::Matrix3d::Identity();
    force = {energy.force.x, energy.force.y, energy.force.z};
  }
};

}  // namespace

// Would catch a sign, a transposed matrix, an end that gives way as the other should: the two
// blocks and the link are one linear system, which Eigen solves.
TEST_CASE("stiff link: both ends go where the least energy of the two is", "[property]") {
  RandomNumbers random(7);
  for (int trial = 0; trial < 100; ++trial) {
    const Vertex a(random), b(random);
    const Eigen::Vector3d d = 10 * to_eigen(random.vector());
    const double compliance = trial % 3 == 0 ? 0.0 : random.between(1e-6, 1);
    const bool has_length = trial % 2 == 0;
    const Eigen::Vector3d n = d.normalized();
    // how the force on the first vertex follows from its components: along n, or all three
    const Eigen::MatrixXd along =
        has_length ? Eigen::MatrixXd(n) : Eigen::MatrixXd(Eigen::Matrix3d::Identity());
    const double rest = has_length ? random.between(0.1, 2) : 0.0;
    const auto k = along.cols();
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(6 + k, 6 + k);
    system.topLeftCorner<3, 3>() = a.hessian;
    system.block<3, 3>(3, 3) = b.hessian;
    system.block(0, 6, 3, k) = -along;
    system.block(3, 6, 3, k) = along;
    system.block(6, 0, k, 3) = along.transpose();
    system.block(6, 3, k, 3) = -along.transpose();
    system.bottomRightCorner(k, k) = compliance * Eigen::MatrixXd::Identity(k, k);
    Eigen::VectorXd load(6 + k);
    load << a.force, b.force, along.transpose() * (d - rest * n);
    const Eigen::VectorXd solution = system.fullPivLu().solve(load);

    // from where both are without the link, with a guess of the force that both have followed
    Joint joint{to_vec3(along * (along.transpose() * Eigen::Vector3d(0.3, -0.2, 0.5))),
                {VertexGive<double>::of(VertexFactor<double>(a.energy)),
                 VertexGive<double>::of(VertexFactor<double>(b.energy))}};
    const Eigen::Vector3d guess = to_eigen(joint.force);
    const Eigen::Vector3d way_a = a.hessian.ldlt().solve(a.force + guess);
    const Eigen::Vector3d way_b = b.hessian.ldlt().solve(b.force - guess);
    // a link with a length turns as its ends move: its direction is that of d here
    const Eigen::Vector3d seen = d + along * (along.transpose() * (way_b - way_a));

    joint.force = StiffLinkConstraint::force(joint, to_vec3(seen), rest, compliance);

    const Eigen::Vector3d expected = along * solution.tail(k);
    CHECK((to_eigen(joint.force) - expected).norm() < 1e-4 * (1 + expected.norm()));
  }
}

TEST_CASE("stiff link: a projection closes it, as far as its compliance lets it", "[property]") {
  RandomNumbers random(11);
  const Vertex a(random), b(random);
  const double rest = GENERATE(0.0, 0.02);
  const double compliance = GENERATE(0.0, 0.3);
  const Joint start{{0, 0, 0},
                    {VertexGive<double>::of(VertexFactor<double>(a.energy)),
                     VertexGive<double>::of(VertexFactor<double>(b.energy))}};
  double multipliers[StiffLinkConstraint::kMultiplierCount];
  start.store(multipliers);
  Vec3<double> x[2] = {{0, 0, 0}, {0.03, -0.01, 0.02}};
  const double w[2] = {1, 1}, parameters[3] = {rest, compliance, 1};
  for (int i = 0; i < 30; ++i) {  // a link with a length turns
    const auto moves = StiffLinkConstraint::move<ProjectionMode::compliance>(
        x, w, parameters, Substep<double>{1e3, 1e6}, multipliers);
    x[0] = x[0] + moves.of[0];
    x[1] = x[1] + moves.of[1];
  }
  const Vec3<double> d = x[1] - x[0], force = StiffLinkConstraint::force_of(multipliers);
  const double tension = std::sqrt(dot(force, force));
  REQUIRE(tension > 0);
  CHECK(std::sqrt(dot(d, d)) - rest == Approx(compliance * tension).margin(1e-6));
  CHECK(dot(force, d) >= (compliance + rest > 0 ? 0.999 * tension * std::sqrt(dot(d, d)) : 0));
}

TEST_CASE("stiff link: without mobility, direction or numbers nothing moves", "[property]") {
  const double w[2] = {1, 1};
  const double rest = GENERATE(0.0, 0.5);
  const Joint rigid{};  // neither end gives way
  Joint soft{};
  soft.give[0].xx = soft.give[0].yy = soft.give[0].zz = 1;
  const auto moved = [&](const Joint& joint, const Vec3<double>& end) {
    double multipliers[StiffLinkConstraint::kMultiplierCount];
    joint.store(multipliers);
    const Vec3<double> x[2] = {{0, 0, 0}, end};
    const double parameters[3] = {rest, 0, 0.7};
    const auto moves = StiffLinkConstraint::move<ProjectionMode::compliance>(
        x, w, parameters, Substep<double>{1e3, 1e6}, multipliers);
    return dot(moves.of[0], moves.of[0]) + dot(moves.of[1], moves.of[1]);
  };
  CHECK(moved(rigid, {1, 0, 0}) == 0);
  CHECK(moved(soft, {0, 0, 0}) == 0);
  CHECK(moved(soft, {kNotANumber, 0, 0}) == 0);
  CHECK(moved(soft, {1, 0, 0}) > 0);
}

}  // namespace pbdsurg
