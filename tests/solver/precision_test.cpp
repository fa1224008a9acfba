// SPDX-License-Identifier: Apache-2.0
// What single precision leaves of motion at short substeps and far from the origin.
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::kSoftEdge;
using testing::kUsualDensity;

TetMesh moved_box(const std::array<Index, 3>& cells, const Eigen::Vector3d& way) {
  const TetMesh box = testing::make_box(cells, kSoftEdge, 0.1);
  std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
  for (Eigen::Vector3d& x : positions) {
    x += way;
  }
  return TetMesh(std::move(positions), {box.tets().begin(), box.tets().end()});
}

std::vector<double> masses_of(const Scene& scene) {
  std::vector<double> masses(scene.positions().size(), 0);
  for (const Tet& tet : scene.tets()) {
    for (const Index v : tet) {
      masses[v] += kUsualDensity * tet_volume(scene.positions(), tet) / 4;
    }
  }
  return masses;
}

template <class Velocities>
double kinetic_energy(const std::vector<double>& masses, const Velocities& velocities) {
  double energy = 0;
  for (std::size_t v = 0; v < masses.size(); ++v) {
    energy += masses[v] / 2 * velocities[v].template cast<double>().squaredNorm();
  }
  return energy;
}

// Velocities of a body that turns about the axis through its middle.
std::vector<Eigen::Vector3d> spin_of(const Scene& scene, const std::vector<double>& masses) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double mass = 0;
  for (std::size_t v = 0; v < masses.size(); ++v) {
    middle += masses[v] * scene.positions()[v];
    mass += masses[v];
  }
  std::vector<Eigen::Vector3d> velocities;
  for (const Eigen::Vector3d& x : scene.positions()) {
    velocities.push_back(Eigen::Vector3d(0, 0, 10).cross(x - middle / mass));  // 10 rad/s
  }
  return velocities;
}

// The same integrator by projections in double precision, with as many sweeps as it takes.
class DoubleBody {
 public:
  DoubleBody(const Scene& scene, float youngs_modulus, double poissons_ratio,
             TimeIntegration integration)
      : integration_(integration),
        tets_(scene.tets().begin(), scene.tets().end()),
        x_(scene.positions().begin(), scene.positions().end()),
        masses_(masses_of(scene)) {
    ways_.assign(x_.size(), Eigen::Vector3d::Zero());
    for (const Tet& tet : tets_) {
      Eigen::Matrix3d sides;
      for (int k = 0; k < 3; ++k) {
        sides.col(k) = x_[tet[k + 1]] - x_[tet[0]];
      }
      const Eigen::Matrix3d inverse = sides.inverse();
      Record record{};
      for (int i = 0; i < 9; ++i) {
        record[NeoHookeanConstraint::kInverseShape + i] = inverse(i / 3, i % 3);
      }
      record[NeoHookeanConstraint::kStiffness] =
          youngs_modulus / (2 * (1 + poissons_ratio)) * sides.determinant() / 6;
      record[NeoHookeanConstraint::kRatio] = 1 / (1 - 2 * poissons_ratio);
      records_.push_back(record);
    }
  }

  void set_velocities(const std::vector<Eigen::Vector3d>& velocities) {
    velocities_ = velocities_before_ = velocities;
  }
  [[nodiscard]] double energy() const { return kinetic_energy(masses_, velocities_); }

  void step(double h) {
    const std::vector<Eigen::Vector3d> before = x_;
    const bool has_past = integration_ == TimeIntegration::bdf2 && steps_++ > 0;
    const double share = has_past ? 1.0 / 3 : 0;
    const double reach = has_past ? 2 * h / 3 : h;
    for (std::size_t v = 0; v < x_.size(); ++v) {
      x_[v] += share * ways_[v] +
               reach * (velocities_[v] + share * (velocities_[v] - velocities_before_[v]));
    }
    std::vector<std::array<double, 9>> multipliers(tets_.size(), std::array<double, 9>{});
    for (int sweep = 0; sweep < 20; ++sweep) {
      for (std::size_t t = 0; t < tets_.size(); ++t) {
        project(t, reach, multipliers[t]);
      }
    }
    for (std::size_t v = 0; v < x_.size(); ++v) {
      velocities_before_[v] = velocities_[v];
      velocities_[v] = (x_[v] - before[v] - share * ways_[v]) / reach;
      ways_[v] = x_[v] - before[v];
    }
  }

 private:
  using Record = std::array<double, NeoHookeanConstraint::kParameterCount>;

  void project(std::size_t t, double h, std::array<double, 9>& multiplier) {
    Vec3<double> x[4];
    double w[4];
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector3d& from = x_[tets_[t][k]];
      x[k] = {from.x(), from.y(), from.z()};
      w[k] = 1 / masses_[tets_[t][k]];
    }
    double parameters[NeoHookeanConstraint::kParameterCount];
    std::ranges::copy(records_[t], parameters);
    double given[9];
    std::ranges::copy(multiplier, given);
    NeoHookeanConstraint::project<ProjectionMode::compliance>(
        x, w, parameters, Substep<double>{1 / h, 1 / (h * h)}, given);
    std::copy_n(given, 9, multiplier.begin());
    for (int k = 0; k < 4; ++k) {
      x_[tets_[t][k]] = {x[k].x, x[k].y, x[k].z};
    }
  }

  TimeIntegration integration_;
  int steps_ = 0;
  std::vector<Tet> tets_;
  std::vector<Eigen::Vector3d> x_, velocities_, velocities_before_, ways_;
  std::vector<double> masses_;
  std::vector<Record> records_;
};

struct Place {
  const char* name;
  Eigen::Vector3d way;  // m
};

Place origin_or_far() {
  return GENERATE(Place{"at the origin", {0, 0, 0}}, Place{"1 m away", {1, -1, 1}});
}

}  // namespace

// Would catch gravity that is rounded to a whole number of spacings between positions: at 20 us and
// 1 m away nothing would fall at all.
TEST_CASE("precision: bodies fall as far as gravity takes them at any substep and place",
          "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const Executor executor = GENERATE(executor::serial(), executor::threads(1));
  const double h = GENERATE(5e-6, 20e-6, 100e-6);  // s
  const Place place = origin_or_far();
  INFO(place.name << ", substeps of " << 1e6 * h << " us, method " << static_cast<int>(method));
  Scene scene;
  scene.add_body("box", moved_box({2, 1, 1}, place.way), testing::neo_hookean(1e4F, 0.45F));
  Solver solver(
      scene,
      testing::small_steps(
          {.method = method, .substeps = 10, .integration = integration, .executor = executor}));
  const int steps = 400;
  for (int i = 0; i < steps; ++i) {
    solver.step(static_cast<float>(10 * h));
  }
  const double count = 10.0 * steps;
  // BDF2 is exact once it has a past; its first substep goes half h^2 g too far, and that lingers
  const double late = integration == TimeIntegration::bdf2 ? 1.5 : count;
  const double fallen = 9.81 * h * h * (count * count + late) / 2;
  const std::vector<Eigen::Vector3f> now = solver.positions();
  const std::vector<Eigen::Vector3f> velocities = solver.velocities();
  double mean = 0;
  for (std::size_t v = 0; v < now.size(); ++v) {
    mean += (scene.positions()[v].y() - now[v].y()) / static_cast<double>(now.size());
    CHECK(std::abs(velocities[v].y() + 9.81 * h * count) < 1e-3 * 9.81 * h * count);
  }
  CHECK(std::abs(mean / fallen - 1) < 1e-3);
}

// Would catch rounding that drives a motion or brakes it: with positions rounded in each substep,
// this body ended with 4.4 times the energy of its spin.
TEST_CASE("precision: a body spins on as the same integrator does in double precision",
          "[property]") {
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const float h = GENERATE(1e-4F, 1e-3F);  // s
  const Place place = origin_or_far();
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("box", moved_box({3, 2, 1}, place.way), testing::neo_hookean(1e4F, 0.45F));
  const std::vector<double> masses = masses_of(scene);
  const std::vector<Eigen::Vector3d> spin = spin_of(scene, masses);
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3d& v : spin) {
    velocities.push_back(v.cast<float>());
  }
  DoubleBody reference(scene, 1e4F, 0.45, integration);
  reference.set_velocities(spin);
  Solver projections(
      scene, testing::small_steps({.substeps = 1, .iterations = 20, .integration = integration}));
  Solver blocks(scene, {.method = SolverMethod::vertex_block,
                        .substeps = 1,
                        .iterations = 20,
                        .integration = integration});
  projections.write_velocities(velocities);
  blocks.write_velocities(velocities);
  const int steps = static_cast<int>(std::lround(2 / h));
  for (int i = 0; i < steps; ++i) {
    reference.step(h);
    projections.step(h);
    blocks.step(h);
  }
  const double expected = reference.energy();
  INFO(place.name << ", steps of " << 1e3F * h << " ms: " << expected / kinetic_energy(masses, spin)
                  << " of the energy left");
  CHECK(expected > 0.5 * kinetic_energy(masses, spin));
  CHECK(std::abs(kinetic_energy(masses, projections.velocities()) / expected - 1) < 0.02);
  // which keeps its angular momentum besides
  CHECK(std::abs(kinetic_energy(masses, blocks.velocities()) / kinetic_energy(masses, spin) - 1) <
        0.02);
}

// Would catch neighbours that are seen where rounding has put them: 1 m away a stiff body would
// tremble, and with inner friction, which divides by the substep, gain energy.
TEST_CASE("precision: a stiff body rests far from the origin as it does there", "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float friction = GENERATE(0.0F, 1e-3F);  // s
  INFO("method " << static_cast<int>(method) << ", friction " << friction << " s");
  Material material = testing::neo_hookean(2.5e5F, 0.45F);
  material.damping = friction;
  const auto fastest = [&](const Eigen::Vector3d& way) {
    Scene scene;
    scene.set_gravity(Eigen::Vector3f::Zero());
    scene.add_body("box", moved_box({3, 2, 1}, way), material);
    Solver solver(scene, testing::small_steps({.method = method, .substeps = 10}));
    for (int i = 0; i < 1000; ++i) {
      solver.step(1e-4F);  // substeps of 10 us
    }
    float speed = 0;
    for (const Eigen::Vector3f& v : solver.velocities()) {
      speed = std::max(speed, v.norm());
    }
    return speed;
  };
  // m/s: friction of 1 ms is a hundred substeps, so rounding counts a hundred times
  const float most = method == SolverMethod::projection ? (friction > 0 ? 1e-4F : 4e-5F)
                                                        : (friction > 0 ? 4e-3F : 2e-4F);
  CHECK(fastest({0, 0, 0}) < most);
  CHECK(fastest({1, -1, 1}) < most);
}

// Would catch fixed points that are lost or wrap around where all vertices move fast together, or
// where an edit makes edges long: the body would fall apart, or not shrink back.
TEST_CASE("precision: vertex blocks shrink back alike at any speed and size", "[property]") {
  const double size = GENERATE(1e-3, 4e-3, 0.5);  // m, of edges
  const auto stretch_after = [&](float speed) {
    Scene scene;
    scene.set_gravity(Eigen::Vector3f::Zero());
    scene.add_body("box", testing::make_box({2, 2, 2}, size, 0.1),
                   testing::neo_hookean(1e4F, 0.4F));
    Solver solver(scene, {.method = SolverMethod::vertex_block, .substeps = 1, .iterations = 20});
    std::vector<Eigen::Vector3f> stretched = solver.positions();
    for (Eigen::Vector3f& x : stretched) {
      x *= 1.1F;
    }
    solver.write_positions(stretched);
    solver.write_velocities(
        std::vector<Eigen::Vector3f>(stretched.size(), Eigen::Vector3f(speed, 0, 0)));
    for (int i = 0; i < 5; ++i) {
      solver.step(1.0F / 60);
    }
    const std::vector<Eigen::Vector3f> now = solver.positions();
    return (now.front() - now.back()).norm() / (stretched.front() - stretched.back()).norm();
  };
  const float still = stretch_after(0);
  CHECK(still < 0.99F);
  CHECK(stretch_after(20) == testing::Approx(still).epsilon(2e-3));
}

TEST_CASE("precision: vertex blocks follow rest lengths that grow a hundred times", "[property]") {
  const TetMesh mesh = testing::make_box({2, 2, 2}, kSoftEdge, 0.1);
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("box", mesh, testing::soft_springs(mesh));
  Solver solver(scene, testing::small_steps({.method = SolverMethod::vertex_block}));
  constexpr float kGrowth = 200;
  TopologyEdit edit;
  for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    edit.rest_lengths.push_back({e, kGrowth * solver.rest_length(e)});
  }
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    edit.rest_volumes.push_back({t, kGrowth * kGrowth * kGrowth * solver.rest_volume(t)});
  }
  solver.tissue().apply(edit);
  std::vector<Eigen::Vector3f> positions = solver.positions();
  for (Eigen::Vector3f& x : positions) {
    x *= kGrowth;
  }
  solver.write_positions(positions);
  solver.step(1e-4F);
  for (const Eigen::Vector3f& v : solver.velocities()) {
    CHECK(v.norm() < 50);  // m/s; where numbers wrap around, 1e5
  }
  solver.tissue().undo();
  solver.step(1e-4F);
  CHECK(solver.last_report().non_finite_vertices == 0);
}

// Would catch a snapshot that forgets what positions lack: a copy that takes it would part from its
// original.
TEST_CASE("precision: a snapshot has what rounding left over, and one made by hand does without",
          "[golden]") {
  Scene scene;
  scene.add_body("box", moved_box({2, 1, 1}, {1, -1, 1}), testing::neo_hookean(1e4F, 0.45F));
  Solver solver(scene, testing::small_steps({.copies = 2}));
  Solver other(scene, testing::small_steps());
  solver.step(1e-4F);
  Snapshot snapshot = solver.snapshot();
  float largest = 0;
  for (const Eigen::Vector3f& rounding : snapshot.roundings) {
    largest = std::max(largest, rounding.norm());
  }
  CHECK(largest > 0);
  CHECK(largest < 1.2e-7F);                                   // m, spacings of numbers near 1
  CHECK_THROWS_AS(other.restore(snapshot), InvalidArgument);  // of another tissue
  solver.write_positions(solver.positions(0), 1);
  solver.restore(snapshot, 1);
  solver.step(1e-4F);
  const std::uint64_t after = solver.state_hash();
  CHECK(solver.state_hash(1) == after);
  Snapshot wrong = snapshot;
  wrong.roundings[2].y() = 1e-6F;
  CHECK_THROWS_WITH(solver.restore(wrong), testing::ContainsSubstring("rounding of vertex 2"));
  snapshot.roundings.clear();
  snapshot.falling.clear();
  solver.restore(snapshot);
  solver.step(1e-4F);
  CHECK(solver.state_hash() != after);
}

}  // namespace pbdsurg
