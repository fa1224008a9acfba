// SPDX-License-Identifier: Apache-2.0
// Neo-Hookean bodies against the theory of elasticity.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kSoftEdge;
using testing::kUsualDensity;

constexpr double kModulus = 5000;  // Pa

Material elastic_tissue(double poissons_ratio, double modulus = kModulus) {
  return {.density = kUsualDensity,
          .model = ElasticModel::neo_hookean,
          .youngs_modulus = static_cast<float>(modulus),
          .poissons_ratio = static_cast<float>(poissons_ratio)};
}

// A bar along x, without gravity.
Scene make_elastic_bar(const Material& material, std::array<Index, 3> cells,
                       double edge = kSoftEdge, double jitter = 0) {
  Scene scene;
  scene.add_body("bar", testing::make_box(cells, edge, jitter), material);
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

void fix_start(Scene& scene, double edge = kSoftEdge) {
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < 0.5 * edge; });
}

SolverOptions projections_of(int substeps, int iterations, double damping = 0) {
  return {.method = SolverMethod::projection,
          .substeps = substeps,
          .iterations = iterations,
          .damping = static_cast<float>(damping),
          .executor = executor::threads(1)};
}

StepReport run_for(Solver& solver, int steps, double dt) {
  StepReport report;
  for (int i = 0; i < steps; ++i) {
    report = solver.step(static_cast<float>(dt));
  }
  return report;
}

// Mean displacement along an axis of the vertices that satisfy a condition at rest.
template <class Condition>
double mean_displacement(const Scene& scene, const Solver& solver, int axis, Condition condition) {
  const auto x = solver.positions();
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (condition(scene.positions()[v])) {
      sum += x[v][axis] - scene.positions()[v][axis];
      ++count;
    }
  }
  return sum / count;
}

auto at_plane(int axis, double place) {
  return [=](const Eigen::Vector3d& x) { return std::abs(x[axis] - place) < 1e-3 * kSoftEdge; };
}

double kinetic_energy(const Scene& scene, const Solver& solver) {
  const auto velocities = solver.velocities();
  double energy = 0;
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    energy += scene.masses()[v] * velocities[v].cast<double>().squaredNorm() / 2;
  }
  return energy;
}

// How much stiffer a cantilever is under its own weight than Timoshenko's beam.
// @param cells  across; the beam is five times as long as wide
double excess_stiffness(double poissons_ratio, Index cells) {
  const double width = 8e-3, length = 5 * width, edge = width / cells;
  const double shear_modulus = kModulus / (2 * (1 + poissons_ratio));
  const double shear_factor = 10 * (1 + poissons_ratio) / (12 + 11 * poissons_ratio);
  const double area = width * width, inertia = std::pow(width, 4) / 12;
  // of the tip, for a weight of one newton a metre
  const auto deflection = [&](double x) {
    return x * x * (6 * length * length - 4 * length * x + x * x) / (24 * kModulus * inertia) +
           (length * x - x * x / 2) / (shear_factor * shear_modulus * area);
  };
  const double weight = 0.04 * length / deflection(length);
  Scene scene = make_elastic_bar(elastic_tissue(poissons_ratio), {5 * cells, cells, cells}, edge);
  fix_start(scene, edge);
  scene.set_gravity({0, 0, static_cast<float>(-weight / (kUsualDensity * area))});
  Solver solver(scene, projections_of(20, cells * cells / 3, 20));
  std::vector<Eigen::Vector3f> x = solver.positions();
  for (Eigen::Vector3f& p : x) {  // near the answer, which is then found sooner
    p.z() -= static_cast<float>(0.8 * weight * deflection(p.x()));
  }
  solver.write_positions(x);
  run_for(solver, 100, 0.01);
  const double tip = -mean_displacement(
      scene, solver, 2, [&](const Eigen::Vector3d& p) { return p.x() > length - 0.5 * edge; });
  return weight * deflection(length) / tip - 1;
}

}  // namespace

TEST_CASE("elasticity: a stretched bar pulls and thins as its moduli say", "[validation]") {
  const double poissons_ratio = GENERATE(0.0, 0.3, 0.45);
  Scene scene = make_elastic_bar(elastic_tissue(poissons_ratio), {12, 2, 2});
  fix_start(scene);
  Solver solver(scene, projections_of(20, 4, 10));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  std::vector<Index> end;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > 11.5 * kSoftEdge) {
      end.push_back(v);
    }
  }
  solver.grasp(tool, end);
  ToolPose pose = ToolPose::Identity();
  pose.translation().x() = static_cast<float>(0.01 * 12 * kSoftEdge);
  solver.move_tool(tool, pose);
  run_for(solver, 200, 5e-3);
  double force = 0;
  for (int i = 0; i < 20; ++i) {
    run_for(solver, 1, 5e-3);
    force -= solver.tool_force(tool).x() / 20;
  }

  // away from the ends, which cannot thin
  const double strain = (mean_displacement(scene, solver, 0, at_plane(0, 8 * kSoftEdge)) -
                         mean_displacement(scene, solver, 0, at_plane(0, 4 * kSoftEdge))) /
                        (4 * kSoftEdge);
  const auto side = [&](double y) {
    return mean_displacement(scene, solver, 1, [&](const Eigen::Vector3d& x) {
      return at_plane(0, 6 * kSoftEdge)(x) && at_plane(1, y)(x);
    });
  };
  const double thinning = (side(0) - side(2 * kSoftEdge)) / (2 * kSoftEdge);
  const double area = 4 * kSoftEdge * kSoftEdge;
  CHECK(strain == Approx(0.01).epsilon(0.1));
  CHECK(force / (area * strain) == Approx(kModulus).epsilon(0.02));
  CHECK(thinning / strain == Approx(poissons_ratio).margin(0.02));
}

// Straight-edged tetrahedra lock in bending: what they resist too much goes with the square of
// their size, so two sizes tell what none at all would do.
TEST_CASE("elasticity: a cantilever bends as beam theory says", "[validation]") {
  const double poissons_ratio = GENERATE(0.0, 0.3);
  const double coarse = excess_stiffness(poissons_ratio, 3);
  const double fine = excess_stiffness(poissons_ratio, 6);
  CHECK(fine < 0.3 * coarse);
  // the held end cannot thin, which stiffens what would
  CHECK((4 * fine - coarse) / 3 == Approx(0).margin(poissons_ratio > 0 ? 0.04 : 0.02));
}

TEST_CASE("elasticity: stiffness depends neither on the step nor on iterations", "[validation]") {
  const auto sag = [](int substeps, int iterations, double dt) {
    Scene scene = make_elastic_bar(elastic_tissue(0.45), {5, 2, 2}, kSoftEdge, 0.1);
    fix_start(scene);
    scene.set_gravity({0, -3, 0});
    Solver solver(scene, projections_of(substeps, iterations, 20));
    run_for(solver, static_cast<int>(1.5 / dt), dt);
    return -mean_displacement(scene, solver, 1,
                              [](const Eigen::Vector3d& x) { return x.x() > 4.5 * kSoftEdge; });
  };
  const double reference = sag(20, 8, 0.01);
  CHECK(reference > 0.1 * kSoftEdge);
  CHECK(sag(40, 8, 0.01) == Approx(reference).epsilon(0.01));
  CHECK(sag(80, 8, 0.01) == Approx(reference).epsilon(0.01));
  CHECK(sag(20, 16, 0.01) == Approx(reference).epsilon(0.01));
  CHECK(sag(20, 32, 0.01) == Approx(reference).epsilon(0.01));
  CHECK(sag(80, 1, 0.01) == Approx(reference).epsilon(0.01));
  CHECK(sag(20, 8, 0.005) == Approx(reference).epsilon(0.01));
  CHECK(sag(20, 16, 0.02) == Approx(reference).epsilon(0.01));
}

// Projections allow no more; vertex blocks resist more beyond it.
TEST_CASE("elasticity: no edge of a loaded body goes far beyond its limit", "[validation]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto stretch = [&](float limit) {
    Material material = elastic_tissue(0.45, 500);
    material.max_stretch = limit;
    Scene scene = make_elastic_bar(material, {8, 2, 2}, kSoftEdge, 0.1);
    fix_start(scene);
    scene.set_gravity({9.81F, 0, 0});
    SolverOptions options = projections_of(10, 10, 10);
    options.method = method;
    Solver solver(scene, options);
    CHECK(run_for(solver, 200, 0.01).inverted_tets == 0);
    const auto x = solver.positions();
    double longest = 0;
    for (const Edge& edge : solver.tissue().edges()) {
      longest = std::max<double>(
          longest, (x[edge[0]] - x[edge[1]]).norm() /
                       (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm());
    }
    return longest;
  };
  CHECK(stretch(std::numeric_limits<float>::infinity()) > 1.5);
  CHECK(stretch(1.2F) < 1.2 * (method == SolverMethod::projection ? 1.02 : 1.15));
}

namespace {

bool recovers(int seed) {
  const Scene scene = make_elastic_bar(elastic_tissue(0.45), {4, 2, 2}, kSoftEdge, 0.1);
  Solver solver(scene, projections_of(10, 4, 5));
  std::vector<Eigen::Vector3f> x = solver.positions();
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (seed == 0) {
      x[v].x() = -x[v].x();
    } else {
      for (int axis = 0; axis < 3; ++axis) {
        x[v][axis] += static_cast<float>(kSoftEdge * (2 * random_unit(seed, v, axis) - 1));
      }
    }
  }
  solver.write_positions(x);
  std::vector<Eigen::Vector3d> crumpled;
  for (const Eigen::Vector3f& p : x) {
    crumpled.push_back(p.cast<double>());
  }
  CHECK(std::count_if(scene.tets().begin(), scene.tets().end(),
                      [&](const Tet& tet) { return tet_volume(crumpled, tet) < 0; }) > 10);
  CHECK(run_for(solver, 400, 0.01).inverted_tets == 0);
  x = solver.positions();
  double largest = 0;
  for (const Edge& edge : solver.tissue().edges()) {
    const double rest = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
    largest = std::max(largest, std::abs((x[edge[0]] - x[edge[1]]).norm() - rest) / rest);
  }
  return largest < 1e-2;
}

}  // namespace

TEST_CASE("elasticity: an inverted or crumpled body recovers", "[validation]") {
  CHECK(recovers(0));
  int recovered = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    recovered += recovers(seed);
  }
  // crumpled by the length of an edge, few stay wound around one: the energy has such minima
  CHECK(recovered >= 9);
}

// The longitudinal swing of a free bar decays by exp(-w^2 (tau + h) t) in energy: tau is the
// material's, h the implicit step's.
TEST_CASE("elasticity: a swing decays as the relaxation time says", "[validation]") {
  constexpr Index kCells = 12;
  constexpr double kLength = kCells * kSoftEdge, kSubstep = 4e-4;
  const double omega = std::numbers::pi * std::sqrt(kModulus / kUsualDensity) / kLength;
  const auto decay = [&](double relaxation) {
    Material material = elastic_tissue(0.0);
    material.damping = static_cast<float>(relaxation);
    const Scene scene = make_elastic_bar(material, {kCells, 2, 2});
    Solver solver(scene, projections_of(1, 20));
    // around the origin, where numbers are finest: positions rounded coarsely take energy too
    std::vector<Eigen::Vector3f> positions = solver.positions();
    for (Eigen::Vector3f& p : positions) {
      p -= Eigen::Vector3f(kLength / 2, kSoftEdge, kSoftEdge);
    }
    solver.write_positions(positions);
    std::vector<Eigen::Vector3f> velocities;
    for (const Eigen::Vector3d& x : scene.positions()) {
      velocities.push_back(
          {static_cast<float>(0.05 * std::cos(std::numbers::pi * x.x() / kLength)), 0, 0});
    }
    solver.write_velocities(velocities);
    // the largest speed of the swing in each half period
    std::vector<double> peaks(1, 0.0), turns;
    double before = 0;
    for (int i = 1; turns.size() < 5 && i < 4000; ++i) {
      solver.step(static_cast<float>(kSubstep));
      const auto u = solver.velocities();
      double speed = 0;
      for (std::size_t v = 0; v < u.size(); ++v) {
        speed += scene.masses()[v] * u[v].x() *
                 std::cos(std::numbers::pi * scene.positions()[v].x() / kLength);
      }
      if (before * speed < 0) {
        turns.push_back(kSubstep * (i - speed / (speed - before)));
        peaks.push_back(0);
      }
      peaks.back() = std::max(peaks.back(), std::abs(speed));
      before = speed;
    }
    REQUIRE(turns.size() == 5);
    CHECK(turns[4] - turns[0] == Approx(4 * std::numbers::pi / omega).epsilon(0.03));
    return 2 * std::log(peaks[1] / peaks[4]) / (3 * (turns[4] - turns[0]) / 4);
  };
  CHECK(decay(0) == Approx(omega * omega * kSubstep).epsilon(0.05));
  CHECK(decay(5e-4) == Approx(omega * omega * (5e-4 + kSubstep)).epsilon(0.05));
  CHECK(decay(2e-3) == Approx(omega * omega * (2e-3 + kSubstep)).epsilon(0.05));
}

TEST_CASE("elasticity: inner friction leaves rigid motion alone", "[property]") {
  const auto end_of = [](float relaxation) {
    Material material = elastic_tissue(0.45, 50e3);
    material.damping = relaxation;
    const Scene scene = make_elastic_bar(material, {4, 2, 2}, kSoftEdge, 0.1);
    Solver solver(scene, projections_of(10, 2));
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double mass = 0;
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      centre += scene.masses()[v] * scene.positions()[v];
      mass += scene.masses()[v];
    }
    centre /= mass;
    std::vector<Eigen::Vector3f> velocities;
    for (const Eigen::Vector3d& x : scene.positions()) {
      velocities.push_back(
          (Eigen::Vector3d(0.01, 0, 0) + Eigen::Vector3d(2, 3, 10).cross(x - centre))
              .cast<float>());
    }
    solver.write_velocities(velocities);
    const double before = kinetic_energy(scene, solver);
    run_for(solver, 100, 5e-3);
    return kinetic_energy(scene, solver) / before;
  };
  const double undamped = end_of(0);
  CHECK(undamped > 0.9);
  CHECK(end_of(0.05F) == Approx(undamped).epsilon(0.01));
}

TEST_CASE("elasticity: from jelly to bone, and in steps of any length, nothing explodes",
          "[validation]") {
  const double modulus = kModulus * GENERATE(1e-4, 1e-2, 1.0, 1e2, 1e3);
  const double dt = GENERATE(1e-4, 1e-2);
  const float damping = GENERATE(0.0F, 0.01F);
  Material material = elastic_tissue(0.45, modulus);
  material.damping = damping;
  Scene scene = make_elastic_bar(material, {5, 2, 2}, kSoftEdge, 0.1);
  fix_start(scene);
  scene.set_gravity({0, -9.81F, 0});
  Solver solver(scene, projections_of(10, 1));
  const StepReport report = run_for(solver, 100, dt);
  CHECK(report.non_finite_vertices == 0);
  // no farther than it can fall, and what can carry itself hangs
  const double fall = 9.81 * std::pow(100 * dt, 2) / 2;
  const double reach = modulus < kModulus ? 6 * kSoftEdge + 1.01 * fall : 6 * kSoftEdge;
  for (const Eigen::Vector3f& x : solver.positions()) {
    CHECK(x.norm() < reach);
  }
}

TEST_CASE("elasticity: a vertex that leaves the range of numbers is reported and goes alone",
          "[unit]") {
  Scene scene = make_elastic_bar(elastic_tissue(0.45), {4, 2, 2});
  Solver solver(scene, projections_of(1, 1));
  std::vector<Eigen::Vector3f> velocities(solver.positions().size(), Eigen::Vector3f::Zero());
  velocities[20].setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);
  StepReport report = solver.step(10);
  CHECK(report.non_finite_vertices == 1);
  CHECK(report.first_non_finite == 20);
  CHECK(std::isinf(report.volume_residual));
  report = run_for(solver, 50, 0.01);
  CHECK(report.non_finite_vertices == 1);
}

}  // namespace pbdsurg
