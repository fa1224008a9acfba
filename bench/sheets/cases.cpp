// SPDX-License-Identifier: Apache-2.0
#include "bench/sheets/cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/sheet_meshes.h"

namespace pbdsurg::bench {
namespace {

using testing::SheetMesh;
using Load = std::vector<std::pair<Index, Eigen::Vector3f>>;  // N, of vertices

constexpr float kStep = 5e-3F;  // s

Scene make_scene(const SheetMesh& mesh, const SheetMaterial& material) {
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles, material);
  scene.set_gravity({0, 0, 0});
  return scene;
}

// m, at rest.
// @param start  m, or none: as the scene has it
std::vector<Eigen::Vector3d> settle(const Scene& scene, SolverOptions options, const Load& load,
                                    std::span<const Eigen::Vector3f> start = {}) {
  constexpr int kMostSteps = 1200;
  constexpr double kStill = 2e-6;  // m/s
  options.damping = 20;
  Solver solver(scene, options);
  if (!start.empty()) {
    solver.write_positions(start);
  }
  std::vector<Index> vertices;
  std::vector<Eigen::Vector3f> forces;
  for (const auto& [vertex, force] : load) {
    vertices.push_back(vertex);
    forces.push_back(force);
  }
  solver.set_forces(vertices, forces);
  for (int step = 0; step < kMostSteps; ++step) {
    solver.step(kStep);
    if (step % 50 == 49) {
      const auto velocities = solver.velocities();
      const auto fastest = std::ranges::max_element(
          velocities, {}, [](const Eigen::Vector3f& v) { return v.squaredNorm(); });
      if (fastest->norm() < kStill) {
        break;
      }
    }
  }
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3f& x : solver.positions()) {
    positions.push_back(x.cast<double>());
  }
  return positions;
}

// N, of vertices: a pressure on the area at rest, across the plane of x and y.
Load make_pressure(const Scene& scene, double pressure, const SheetMaterial& material) {
  Load load;
  const double area_of_mass = 1 / (double{material.density} * double{material.thickness});
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const double force = pressure * scene.masses()[v] * area_of_mass;
    load.emplace_back(v, Eigen::Vector3f(0, 0, static_cast<float>(force)));
  }
  return load;
}

// Of a strip clamped at one end and pulled at the other, along its middle half.
SheetOutcome pull_strip(const SolverOptions& options) {
  constexpr std::array<Index, 2> kCells{24, 6};
  constexpr double kEdge = 2.5e-3, kStrain = 0.01;
  const SheetMaterial material{
      .thickness = 5e-4F, .youngs_modulus = 100e3F, .poissons_ratio = 0.45F};
  const SheetMesh mesh = testing::make_sheet(kCells, kEdge);
  Scene scene = make_scene(mesh, material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEdge; });
  const double pull = double{material.youngs_modulus} * double{material.thickness} * kStrain;
  Load load;
  for (Index j = 0; j <= kCells[1]; ++j) {
    const double width = j == 0 || j == kCells[1] ? kEdge / 2 : kEdge;
    load.emplace_back(kCells[0] + (kCells[0] + 1) * j,
                      Eigen::Vector3f(static_cast<float>(pull * width), 0, 0));
  }
  const auto positions = settle(scene, options, load);
  const Index middle = (kCells[0] + 1) * (kCells[1] / 2);
  const Index from = middle + kCells[0] / 4, to = middle + 3 * kCells[0] / 4;
  const double length = positions[to].x() - positions[from].x();
  return {100 * (length / (kEdge * (kCells[0] / 2)) - 1), 100 * kStrain};
}

// Of a square pulled alike on all sides and held in the middle.
SheetOutcome pull_square(const SolverOptions& options) {
  constexpr Index kCells = 12;
  constexpr double kEdge = 2.5e-3, kStrain = 0.01;
  const SheetMaterial material{
      .thickness = 5e-4F, .youngs_modulus = 100e3F, .poissons_ratio = 0.45F};
  const SheetMesh mesh = testing::make_sheet({kCells, kCells}, kEdge);
  Scene scene = make_scene(mesh, material);
  const Index middle = (kCells + 1) * (kCells / 2) + kCells / 2;
  scene.fix_vertices(0, std::array{middle});
  const double pull = double{material.youngs_modulus} * double{material.thickness} * kStrain /
                      (1 - double{material.poissons_ratio});
  Load load;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const Index i = v % (kCells + 1), j = v / (kCells + 1);
    const auto side = [](Index k) { return k == 0 ? -1.0 : k == kCells ? 1.0 : 0.0; };
    const auto width = [&](Index k) { return side(k) == 0 ? kEdge : kEdge / 2; };
    const Eigen::Vector3d force(side(i) * width(j), side(j) * width(i), 0);
    if (!force.isZero()) {
      load.emplace_back(v, (pull * force).cast<float>());
    }
  }
  const auto positions = settle(scene, options, load);
  const double length = positions[middle + 3].x() - positions[middle - 3].x();
  return {100 * (length / (6 * kEdge) - 1), 100 * kStrain};
}

// A strip that hangs under its weight: the middle of its lower end.
SheetOutcome hang_strip(const SolverOptions& options) {
  constexpr std::array<Index, 2> kCells{30, 6};
  constexpr double kEdge = 2.5e-3;
  const SheetMaterial material{.thickness = 5e-4F, .youngs_modulus = 40e3F, .poissons_ratio = 0.3F};
  Scene scene = make_scene(testing::make_sheet(kCells, kEdge), material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEdge; });
  scene.set_gravity({9.81F, 0, 0});
  const auto positions = settle(scene, options, {});
  const double length = kCells[0] * kEdge;
  const double lowered = positions[kCells[0] + (kCells[0] + 1) * (kCells[1] / 2)].x() - length;
  return {1e3 * lowered, 1e3 * double{material.density} * 9.81 * length * length /
                             (2 * double{material.youngs_modulus})};
}

// Clamped at one side, under its weight: as wide as twice its length, so that its sides, where
// hinges have a Poisson's ratio of their own, count for little.
struct BendingPlate {
  static constexpr double kGravity = 1;  // m/s^2

  Scene scene;
  Index end;                      // the middle of the free one
  double length, rigidity, load;  // m, N m, Pa

  BendingPlate(Index cells, double edge, const SheetMaterial& material)
      : scene(make_scene(testing::make_plate({cells, 2 * cells}, edge), material)),
        end(cells + (cells + 1) * cells),
        rigidity(flexural_rigidity(material.youngs_modulus, material.thickness, 0)),
        load(double{material.density} * double{material.thickness} * kGravity) {
    const double column = std::numbers::sqrt3 / 2 * edge;  // m, from one to the next
    length = (cells - 0.5) * column;  // the hinges at the clamp turn for half a cell on either side
    scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < 1.5 * column; });
    scene.set_gravity({0, 0, -static_cast<float>(kGravity)});
  }

  // mm, of the end, at rest.
  [[nodiscard]] double sag() const { return 1e3 * load * std::pow(length, 4) / (8 * rigidity); }
};

constexpr SheetMaterial kPlate{.thickness = 1e-3F, .youngs_modulus = 300e3F, .poissons_ratio = 0};

SheetOutcome bend_plate(const SolverOptions& options) {
  const BendingPlate plate(12, 2e-3, kPlate);
  return {-1e3 * settle(plate.scene, options, {})[plate.end].z(), plate.sag()};
}

// While friction lets it sink: as its slowest mode does, whose inertia counts for little. So stiff
// a friction takes many sweeps, and more than automatic ones may be.
SheetOutcome creep_plate(SolverOptions options) {
  constexpr double kFriction = 0.1;  // s
  SheetMaterial material = kPlate;
  material.damping = static_cast<float>(kFriction);
  const BendingPlate plate(6, 4e-3, material);
  options.substeps = 10;
  options.iterations = 200;
  Solver solver(plate.scene, options);
  for (int step = 0; step < std::lround(kFriction / double{kStep}); ++step) {
    solver.step(kStep);
  }
  const double mass = double{material.density} * double{material.thickness};  // kg/m^2
  const double square = std::pow(1.8751, 4) * plate.rigidity / (mass * std::pow(plate.length, 4));
  const double half = square * kFriction / 2, root = std::sqrt(half * half - square);
  const double fast = -half - root, slow = -half + root;  // 1/s
  const double left =
      (fast * std::exp(slow * kFriction) - slow * std::exp(fast * kFriction)) / (fast - slow);
  return {-1e3 * double{solver.positions()[plate.end].z()}, plate.sag() * (1 - left)};
}

// The free end of a quarter of a tube that is clamped at the other: pulled towards the axis.
SheetOutcome bend_tube(const SolverOptions& options) {
  constexpr std::array<Index, 2> kCells{16, 32};
  constexpr double kEdge = 2e-3;
  const double kColumn = std::numbers::sqrt3 / 2 * kEdge;  // m, from one to the next
  const double radius = kCells[0] * kColumn / (std::numbers::pi / 2);
  const SheetMaterial material{.thickness = 5e-4F, .youngs_modulus = 300e3F, .poissons_ratio = 0};
  SheetMesh mesh = testing::make_plate(kCells, kEdge);
  for (Eigen::Vector3d& x : mesh.positions) {
    const double angle = x.x() / radius;
    x = {radius * std::sin(angle), x.y(), radius * (1 - std::cos(angle))};
  }
  Scene scene = make_scene(mesh, material);
  const double clamp = 1.5 * kColumn / radius;
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.x() < radius * std::sin(clamp); });
  const double force = 2e-4;  // N/m
  Load load;
  for (Index j = 0; j <= kCells[1]; ++j) {
    const double width = j == 0 || j == kCells[1] ? kEdge / 2 : kEdge;
    load.emplace_back(kCells[0] + (kCells[0] + 1) * j,
                      Eigen::Vector3f(static_cast<float>(-force * width), 0, 0));
  }
  const auto positions = settle(scene, options, load);
  const Index middle = kCells[0] + (kCells[0] + 1) * (kCells[1] / 2);
  // the hinges at the clamp turn for half a cell on either side
  const double angle = (kCells[0] - 0.5) * kColumn / radius;
  const double rigidity = flexural_rigidity(material.youngs_modulus, material.thickness, 0);
  return {1e3 * (scene.positions()[middle].x() - positions[middle].x()),
          1e3 * force * std::pow(radius, 3) / rigidity * (angle / 2 - std::sin(2 * angle) / 4)};
}

constexpr double kRadius = 30e-3;  // m
constexpr Index kRings = 14;

Scene make_drum(const SheetMaterial& material) {
  Scene scene = make_scene(testing::make_disc(kRings, kRadius), material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.norm() > 0.999 * kRadius; });
  return scene;
}

// A clamped disc that a load across it draws far beyond its thickness.
SheetOutcome blow_disc(const SolverOptions& options) {
  const SheetMaterial material{
      .thickness = 1e-4F, .youngs_modulus = 100e3F, .poissons_ratio = 0.3F};
  const Scene scene = make_drum(material);
  const double stiffness = double{material.youngs_modulus} * double{material.thickness};  // N/m
  const double load = 0.003;  // p a / (E t)
  const auto positions =
      settle(scene, options, make_pressure(scene, load * stiffness / kRadius, material));
  constexpr double kShare = 0.6536;  // of Poisson's ratio 0.3
  return {1e3 * positions[0].z(), 1e3 * kShare * kRadius * std::cbrt(load)};
}

// A disc stretched by 5 % before a small load.
SheetOutcome press_drum(const SolverOptions& options) {
  constexpr double kStrain = 0.05;
  const SheetMaterial material{
      .thickness = 1e-4F, .youngs_modulus = 100e3F, .poissons_ratio = 0.3F};
  const Scene scene = make_drum(material);
  std::vector<Eigen::Vector3f> start;
  for (const Eigen::Vector3d& x : scene.positions()) {
    start.emplace_back(((1 + kStrain) * x).cast<float>());
  }
  // N/m, of the membrane's energy; of a load on the area at rest, which that stretch spreads
  const double ratio = material.poissons_ratio, stretch = 1 + kStrain;
  const double stiffness = double{material.youngs_modulus} * double{material.thickness};
  const double mu = stiffness / (2 * (1 + ratio)), lambda = stiffness / (2 * (1 - ratio));
  const double tension = mu + lambda * (stretch * stretch - 1 - mu / lambda);
  const double pressure = 0.02 * tension / kRadius;
  const auto positions = settle(scene, options, make_pressure(scene, pressure, material), start);
  return {1e3 * positions[0].z(), 1e3 * pressure * kRadius * kRadius / (4 * tension)};
}

// N/m, of a membrane pulled along one side alone, of its energy: what the other side gives way to.
double uniaxial_tension(const SheetMaterial& material, double stretch) {
  const double stiffness = double{material.youngs_modulus} * double{material.thickness};
  const double mu = stiffness / (2 * (1 + double{material.poissons_ratio}));
  const double lambda = stiffness / (2 * (1 - double{material.poissons_ratio}));
  const double target = 1 + mu / lambda;
  const double across = lambda * target * stretch / (mu + lambda * stretch * stretch);
  return mu * stretch + lambda * (stretch * across - target) * across;
}

constexpr double kShear = 0.1;
constexpr Index kRows = 10;

// N, on a side that is moved along the opposite one, of a sheet that wrinkles between them.
double shear_force(const SheetMaterial& material, Index columns, SolverOptions options) {
  constexpr double kEdge = 2.5e-3;
  Scene scene = make_scene(testing::make_slanted_sheet({columns, kRows}, kEdge), material);
  const double height = kRows * kEdge;
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.y() < 0.5 * kEdge; });
  std::vector<Eigen::Vector3f> start;
  std::vector<Index> top;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const Eigen::Vector3d& x = scene.positions()[v];
    const bool is_held = x.y() < 0.5 * kEdge || x.y() > height - 0.5 * kEdge;
    const double out = is_held ? 0 : 1e-2 * kEdge * (2 * random_unit(1, v) - 1);
    start.emplace_back(static_cast<float>(x.x() + kShear * x.y()), static_cast<float>(x.y()),
                       static_cast<float>(out));
    if (x.y() > height - 0.5 * kEdge) {
      top.push_back(v);
    }
  }
  options.damping = 20;
  Solver solver(scene, options);
  solver.write_positions(start);
  const ToolId grip = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(grip, top);
  for (int step = 0; step < 300; ++step) {
    solver.step(kStep);
  }
  return -double{solver.tool_force(grip).x()};
}

// By how much a wider sheet resists more: so its free ends, where no wrinkle reaches both sides, do
// not count.
SheetOutcome shear_sheet(const SolverOptions& options) {
  constexpr double kEdge = 2.5e-3;
  constexpr Index kNarrow = 24, kWide = 60;
  const SheetMaterial material{
      .thickness = 5e-5F, .youngs_modulus = 100e3F, .poissons_ratio = 0.3F};
  const double more =
      shear_force(material, kWide, options) - shear_force(material, kNarrow, options);
  const double root = std::sqrt(1 + kShear * kShear / 4);
  const double expected =
      uniaxial_tension(material, kShear / 2 + root) * (0.5 + kShear / (4 * root));
  return {more / (kEdge * (kWide - kNarrow)), expected};
}

}  // namespace

const std::vector<SheetCase>& sheet_cases() {
  static const std::vector<SheetCase> cases{
      {"strip pulled by 1 %", "%", "E t strain", pull_strip},
      {"square pulled alike on all sides by 1 %", "%", "E t strain / (1 - nu)", pull_square},
      {"strip hanging under its weight", "mm", "rho g L^2 / (2 E)", hang_strip},
      {"plate bending under its weight", "mm", "q L^4 / (8 D)", bend_plate},
      {"plate sinking under its weight against 0.1 s of friction, then", "mm",
       "that times 1 - exp(-1), Kelvin and Voigt, with the inertia of the first mode", creep_plate},
      {"quarter of a tube under a load at its end", "mm",
       "Castigliano: F R^3 / D (a / 2 - sin(2 a) / 4)", bend_tube},
      {"clamped disc under a load", "mm",
       "Hencky 1915, as in Fichter 1997, NASA TP-3658: 0.6536 a (p a / (E t))^(1/3)", blow_disc},
      {"stretched disc under a small load", "mm", "p a^2 / (4 T)", press_drum},
      {"sheet wrinkling in shear by 10 %", "N/m",
       "tension field of the membrane's energy, Steigmann 1990; E t shear / 4 at small strain",
       shear_sheet}};
  return cases;
}

}  // namespace pbdsurg::bench
