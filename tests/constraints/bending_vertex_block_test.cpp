// SPDX-License-Identifier: Apache-2.0
// Hinges in vertex blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/vertex_block.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"
#include "tests/support/constraint_checks.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Hinge;
using testing::random_point;
using testing::turn_of;

// A hinge seen from one of its vertices: that vertex first or third.
std::array<int, 4> seen_from(int vertex) {
  return vertex % 2 == 0 ? std::array<int, 4>{0, 1, 2, 3} : std::array<int, 4>{1, 0, 3, 2};
}

VertexEnergy<double> hinge_energy(const Vec3<double> (&x)[4], int vertex, double stiffness,
                                  double rest) {
  const std::array<int, 4> order = seen_from(vertex);
  const Vec3<double> seen[4] = {x[order[0]], x[order[1]], x[order[2]], x[order[3]]};
  VertexEnergy<double> energy;
  energy.add_hinge(stiffness, rest, seen, vertex >= 2);
  return energy;
}

}  // namespace

TEST_CASE("bending in vertex blocks: the force is minus the gradient of the energy", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double rest = turn_of(GENERATE(-1.0, 0.0, 2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double stiffness = 3e-6;
  const Hinge hinge(edge, GENERATE(-2.0, 0.1, 1.0));
  const Vec3<double> force = hinge_energy(hinge.x, vertex, stiffness, rest).force;
  const double step = 1e-5 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    const double difference = std::pow(high.value(rest), 2) - std::pow(low.value(rest), 2);
    CHECK(force.*axis ==
          Approx(-stiffness / 2 * difference / (2 * step)).margin(1e-7 * stiffness / edge));
  }
}

TEST_CASE("bending in vertex blocks: at rest the Hessian is that of the energy", "[property]") {
  const double edge = 1e-3;
  const Hinge hinge(edge, GENERATE(0.0, 0.7, -2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double rest = hinge.value();
  const VertexEnergy<double> energy = hinge_energy(hinge.x, vertex, 1, rest);
  const double step = 1e-6 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    Vec3<double> unit;
    unit.*axis = 1;
    const Vec3<double> column = (1 / (2 * step)) * (hinge_energy(low.x, vertex, 1, rest).force -
                                                    hinge_energy(high.x, vertex, 1, rest).force);
    const Vec3<double> difference = energy * unit - column;
    CHECK(std::sqrt(dot(difference, difference)) < 1e-4 / (edge * edge));
  }
}

// Would catch a step that overshoots where the gradient vanishes: folded, or far from rest.
TEST_CASE("bending in vertex blocks: no step makes the energy grow, from any shape", "[property]") {
  const double inertia = GENERATE(1e-9, 1e-3, 1.0);  // times stiffness / size^2
  const double relaxation = GENERATE(1.0, 1.9);
  double largest = 0;
  int grown = 0;
  for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
    Vec3<double> x[4];
    for (int i = 0; i < 4; ++i) {
      x[i] = random_point(1, seed, i);
    }
    const double rest = 8 * random_unit(seed, 10) - 4;
    for (int vertex = 0; vertex < 4; ++vertex) {
      VertexEnergy<double> energy = hinge_energy(x, vertex, 1, rest);
      energy.add_pull(inertia, {0, 0, 0});
      const Vec3<double> move = relaxation * VertexFactor<double>(energy).solve(energy.force);
      Vec3<double> moved[4] = {x[0], x[1], x[2], x[3]};
      moved[vertex] = x[vertex] + move;
      const double before = std::pow(BendingConstraint::value(x, rest), 2);
      const double after =
          std::pow(BendingConstraint::value(moved, rest), 2) + inertia * dot(move, move);
      grown += after > before * (1 + 1e-9) ? 1 : 0;
      largest = std::max(largest, std::sqrt(dot(move, move)));
    }
  }
  CHECK(grown == 0);
  CHECK(largest < 10);
}

// A hinge of a thin sheet whose triangles are at rest those of testing::Hinge, and its angle any.
struct SheetSample {
  SheetHinge terms;

  SheetSample(double edge, double stiffness, double angle)
      : terms(SheetHinge::at_rest(Hinge(edge, angle).x, stiffness)) {}

  // J, beside a constant
  [[nodiscard]] double energy(const Vec3<double> (&x)[4]) const {
    double sum = terms.moment * dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      const Vec3<double> d = x[kTetEdges[e][0]] - x[kTetEdges[e][1]];
      sum += terms.weights[e] / 2 * dot(d, d);
    }
    return sum;
  }
  [[nodiscard]] VertexEnergy<double> around(const Vec3<double> (&x)[4], int vertex) const {
    // as HingeRow has it: the first or the third of the hinge, maybe turned by half a turn
    const std::array<int, 4> v = seen_from(vertex);
    const bool is_opposite = vertex >= 2;
    const Vec3<double>& own = x[vertex];
    VertexEnergy<double> energy;
    energy.add_moment(is_opposite ? -terms.moment : terms.moment, x[v[1]] - own,
                      x[is_opposite ? v[0] : v[2]] - own, x[v[3]] - own);
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      const auto [i, j] = kTetEdges[e];
      if (i == vertex || j == vertex) {
        energy.add_pull(terms.weights[e], x[i + j - vertex] - own);
      }
    }
    return energy;
  }
};

// Would catch weights of another stiffness than angles have.
TEST_CASE("bending in vertex blocks: a thin sheet's hinge stores what its angle does",
          "[property]") {
  const double stiffness = 2e-6, edge = 1e-3;
  const double rest = GENERATE(-2.0, 0.0, 0.9, 3.0);
  const SheetSample hinge(edge, stiffness, rest);
  const auto stored = [&](double angle) {
    return hinge.energy(Hinge(edge, angle).x) - hinge.energy(Hinge(edge, rest).x);
  };
  for (const double angle : {-3.1, -1.0, -0.1, 0.0, 0.05, 2.0}) {
    CHECK(stored(angle) ==
          Approx(stiffness * (1 - std::cos(angle - rest))).epsilon(1e-8).margin(1e-9 * stiffness));
  }
  const double value = Hinge(edge, rest + 0.02).value(turn_of(rest));
  CHECK(stored(rest + 0.02) == Approx(stiffness / 2 * value * value).epsilon(1e-3));
}

// Would catch a bent hinge that draws its triangles together, and a flat one that resists stretch.
TEST_CASE("bending in vertex blocks: a thin sheet's hinge pushes nothing at rest", "[property]") {
  const double rest = GENERATE(-2.0, 0.0, 0.9, 3.0);
  const SheetSample hinge(1e-3, 2e-6, rest);
  Hinge at_rest(1e-3, rest);
  if (rest == 0) {
    CHECK(hinge.terms.moment == 0);
    for (Vec3<double>& x : at_rest.x) {
      x.x = 1.3 * x.x + 0.2 * x.y;
    }
  }
  for (int vertex = 0; vertex < 4; ++vertex) {
    const VertexEnergy<double> energy = hinge.around(at_rest.x, vertex);
    CHECK(std::sqrt(dot(energy.force, energy.force)) < 1e-11 * 2e-6 / 1e-3);
    CHECK(energy.isotropic > 0);
  }
}

TEST_CASE("bending in vertex blocks: forces on a thin sheet's hinge are those of its energy",
          "[property]") {
  const double edge = GENERATE(1.0, 1e-4), stiffness = 3e-6;
  const SheetSample hinge(edge, stiffness, GENERATE(-1.0, 0.0, 2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  Hinge bent(edge, GENERATE(-2.0, 0.1, 1.0));
  bent.x[vertex].x += 0.2 * edge;  // stretched, too
  const VertexEnergy<double> energy = hinge.around(bent.x, vertex);
  const double step = 1e-4 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = bent, high = bent;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    CHECK(energy.force.*axis == Approx((hinge.energy(low.x) - hinge.energy(high.x)) / (2 * step))
                                    .margin(1e-8 * stiffness / edge));
    const Vec3<double> column =
        (1 / (2 * step)) * (hinge.around(low.x, vertex).force - hinge.around(high.x, vertex).force);
    CHECK(column.*axis == Approx(energy.isotropic));
  }
}

// Would catch forces that move or turn what all four have in common.
TEST_CASE("bending in vertex blocks: forces on a thin sheet's hinge balance", "[property]") {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const SheetSample hinge(1, 1, 6 * random_unit(seed, 10) - 3);
    Vec3<double> x[4], sum, torque;
    for (int i = 0; i < 4; ++i) {
      x[i] = random_point(1, seed, i);
    }
    for (int vertex = 0; vertex < 4; ++vertex) {
      const Vec3<double> force = hinge.around(x, vertex).force;
      sum = sum + force;
      torque = torque + cross(x[vertex], force);
    }
    CHECK(dot(sum, sum) < 1e-20);
    CHECK(dot(torque, torque) < 1e-20);
  }
}

}  // namespace pbdsurg
