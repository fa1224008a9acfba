// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/local_system.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/shared_work.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;

constexpr double kHeld = std::numeric_limits<double>::infinity();

// Random conductances, some of them negative as at obtuse angles, and a random right-hand side.
struct Sample {
  explicit Sample(std::array<Index, 3> cells) : mesh(testing::make_box(cells, 1)) {
    for (std::size_t t = 0; t < mesh.tets().size(); ++t) {
      for (std::uint64_t k = 0; k < 6; ++k) {
        conductances.emplace_back();
        conductances.resize(t + 1);
        conductances[t][k] = random_unit(1, t, k) - 0.05;
      }
    }
    for (std::size_t row = 0; row < mesh.positions().size(); ++row) {
      added.push_back(0.1 * random_unit(2, row));
      b.push_back(random_unit(3, row) - 0.5);
      x.push_back(random_unit(4, row));
    }
  }

  void fill(LocalSystem& system) const {
    system.set_rows(mesh.vertex_count(), mesh.tets());
    system.set_couplings(conductances);
    system.set_added(added);
  }

  [[nodiscard]] std::vector<Index> groups(Index count) const {
    std::vector<Index> starts;
    for (Index i = 0; i <= count; ++i) {
      starts.push_back(mesh.vertex_count() * i / count);
    }
    return starts;
  }

  TetMesh mesh;
  std::vector<std::array<double, 6>> conductances;
  std::vector<double> added, b, x;
};

std::vector<double> solve_densely(const Sample& sample) {
  const auto n = static_cast<Eigen::Index>(sample.b.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t t = 0; t < sample.conductances.size(); ++t) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Index i = sample.mesh.tets()[t][kTetEdges[k][0]];
      const Index j = sample.mesh.tets()[t][kTetEdges[k][1]];
      const double c = sample.conductances[t][k];
      a(i, i) += c;
      a(j, j) += c;
      a(i, j) -= c;
      a(j, i) -= c;
    }
  }
  Eigen::VectorXd b = Eigen::Map<const Eigen::VectorXd>(sample.b.data(), n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sample.added[i] == kHeld) {
      b -= sample.x[i] * a.col(i);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sample.added[i] == kHeld) {
      a.row(i).setZero();
      a.col(i).setZero();
      a(i, i) = 1;
      b[i] = sample.x[i];
    } else {
      a(i, i) += sample.added[i];
    }
  }
  const Eigen::VectorXd x = a.ldlt().solve(b);
  return {x.begin(), x.end()};
}

}  // namespace

// Would catch couplings that go to a wrong entry, and held rows that move or are left out of sums.
TEST_CASE("local system: it solves what a dense matrix does, in groups or not", "[unit]") {
  Sample sample({3, 3, 2});
  sample.added[0] = sample.added[17] = kHeld;
  const std::vector<double> exact = solve_densely(sample);
  for (const Index groups : {0, 1, 4}) {
    LocalSystem system;
    sample.fill(system);
    if (groups > 0) {
      system.set_groups(sample.groups(groups));
    }
    std::vector<double> x = sample.x;
    const LinearSolveReport report = system.solve(sample.b, x, {.tolerance = 1e-12});
    CHECK(report.converged);
    CHECK(report.residual <= 1e-12);
    for (std::size_t row = 0; row < x.size(); ++row) {
      CHECK(x[row] == Approx(exact[row]).margin(1e-9));
    }
    CHECK(x[17] == sample.x[17]);
  }
}

// Would catch a difference that is taken of rounded products: what is uniform must not flow.
TEST_CASE("local system: uniform values flow nowhere, and flows sum to nothing", "[unit]") {
  const Sample sample({3, 2, 2});
  LocalSystem system;
  sample.fill(system);
  std::vector<double> flows(sample.x.size());
  system.flows(std::vector<double>(sample.x.size(), 37.1), flows);
  CHECK(flows == std::vector<double>(sample.x.size(), 0.0));
  system.flows(sample.x, flows);
  CHECK(std::accumulate(flows.begin(), flows.end(), 0.0) == Approx(0).margin(1e-12));
}

// Would catch rows summed in another order by an update than afresh.
TEST_CASE("local system: rows summed again have the bits of all summed afresh", "[unit]") {
  Sample sample({4, 3, 3});
  LocalSystem updated, fresh;
  sample.fill(updated);
  for (double& value : sample.conductances[5]) {
    value *= 1.1;
  }
  const Tet& changed = sample.mesh.tets()[5];
  updated.update_couplings(sample.conductances, changed);
  sample.fill(fresh);
  std::vector<double> one = sample.x, other = sample.x;
  updated.solve(sample.b, one, {});
  fresh.solve(sample.b, other, {});
  CHECK(one == other);
}

// Would catch sums whose pieces depend on who works.
TEST_CASE("local system: any number of threads gives the same bits", "[unit]") {
  const Sample sample({15, 14, 13});
  std::vector<double> expected;
  for (const Index groups : {0, 32}) {
    for (const int threads : {1, 2, 3}) {
      LocalSystem system(executor::threads(threads));
      sample.fill(system);
      if (groups > 0) {
        system.set_groups(sample.groups(groups));
      }
      std::vector<double> x = sample.x;
      const LinearSolveReport first = system.solve(sample.b, x, {});
      CHECK(first.converged);
      CHECK(first.iterations * system.row_count() > kVisitsWorthThreads);  // so the next is shared
      x = sample.x;
      system.solve(sample.b, x, {});
      if (threads == 1) {
        expected = x;
      }
      CHECK(x == expected);
    }
  }
}

// Would catch division by nothing: rows that nothing couples, parts that nothing holds, no
// right-hand side, not a number in it, no iteration allowed.
TEST_CASE("local system: what has no single answer stays finite", "[unit]") {
  Sample sample({3, 3, 3});
  const std::vector<double> start = sample.x;
  const auto solve = [&](LinearSolveOptions options) {
    LocalSystem system;
    sample.fill(system);
    system.set_groups(sample.groups(8));
    sample.x = start;
    return system.solve(sample.b, sample.x, options);
  };
  CHECK_FALSE(solve({.most_iterations = 0}).converged);
  CHECK(sample.x == start);

  sample.b.assign(sample.b.size(), 0.0);
  CHECK(solve({}).converged);
  CHECK(sample.x == sample.b);

  sample.b[3] = std::nan("");
  CHECK_FALSE(solve({}).converged);
  CHECK(sample.x == start);

  sample.b.assign(sample.b.size(), 0.0);
  sample.b[0] = 1;
  sample.b[1] = -1;
  sample.added.assign(sample.added.size(), 0.0);  // floating
  CHECK(solve({}).converged);
  CHECK(sample.x[0] > sample.x[1]);

  sample.conductances.assign(sample.conductances.size(), {});
  CHECK(solve({}).iterations == 0);
  CHECK(sample.x == start);
}

}  // namespace pbdsurg
