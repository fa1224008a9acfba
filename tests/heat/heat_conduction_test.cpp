// SPDX-License-Identifier: Apache-2.0
// Conduction against closed forms. Where a tolerance is not of rounding, it is the error measured
// with another program of the same method, with some room.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/heat_field.h"

#include "tests/support/catch.h"
#include "tests/support/conduction_meshes.h"
#include "tests/support/conduction_problems.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using std::numbers::pi;
using testing::all_of;
using testing::Approx;
using testing::dry_model;
using testing::heat_face;
using testing::is_face;
using testing::kExact;
using testing::kFat;
using testing::kLiver;
using testing::largest_error;
using testing::ledger_error;
using testing::make_box;
using testing::make_jittered_box;
using testing::mean_error;
using testing::set_profile;
using testing::settle;
using testing::vertices_where;

double diffusivity(const ThermalProperties& tissue) {
  return tissue.conductivity / (tissue.density * tissue.specific_heat);
}

// The mean over a heated face.
double face_temperature(const HeatField& field, const std::vector<HeatSource>& sources) {
  double sum = 0, power = 0;
  for (const HeatSource& source : sources) {
    sum += source.power * field.temperatures()[source.vertex];
    power += source.power;
  }
  return sum / power;
}

double order(double coarse, double fine, double ratio) {
  return std::log(coarse / fine) / std::log(ratio);
}

}  // namespace

// Patch test (Strang and Fix 1973): T linear is a steady state that linear elements hold exactly,
// on any mesh. Would catch clipped or weighted conductances.
TEST_CASE("heat conduction: a linear steady state is exact on a jittered mesh", "[validation]") {
  constexpr double kLength = 8e-3;
  const TetMesh mesh = make_jittered_box({8, 8, 8}, 1e-3, 0.25);
  const auto linear = [&](const Eigen::Vector3d& x) { return 100 - 63 * x.x() / kLength; };
  HeatField field(mesh, kLiver, dry_model(), kExact);
  const std::vector<Index> ends = vertices_where(
      mesh, [&](const Eigen::Vector3d& x) { return x.x() == 0 || x.x() > 0.9999 * kLength; });
  set_profile(field, ends, linear);
  field.hold(ends);
  CHECK(settle(field));
  CHECK(largest_error(field, linear) < 1e-7);
  CHECK(ledger_error(field.ledger()) == Approx(0).margin(1e-9 * field.ledger().sensible));
}

// Semi-infinite body, its surface held: T = T0 + (Ts - T0) erfc(x / (2 sqrt(a t))) (Carslaw and
// Jaeger 1959, 2.5). And the maximum principle: with lumped mass nothing is colder than it was.
TEST_CASE("heat conduction: a surface step spreads as the error function", "[validation]") {
  const auto [edge, tolerance] =
      GENERATE(table<double, double>({{0.5e-3, 0.5}, {0.25e-3, 0.15}, {0.125e-3, 0.06}}));
  const TetMesh bar = make_box({static_cast<Index>(std::lround(10e-3 / edge)), 1, 1}, edge);
  HeatField field(bar, kLiver, dry_model(), kExact);
  const std::vector<Index> face = vertices_where(bar, is_face);
  set_profile(field, face, [](const Eigen::Vector3d&) { return 100; });
  field.hold(face);
  for (int i = 0; i < 300; ++i) {
    field.step(1.0 / 60, {});
    REQUIRE(*std::min_element(field.temperatures().begin(), field.temperatures().end()) >=
            37 - 1e-9);
    REQUIRE(*std::max_element(field.temperatures().begin(), field.temperatures().end()) <=
            100 + 1e-9);
  }
  const double width = 2 * std::sqrt(diffusivity(kLiver) * 5);
  CHECK(largest_error(field, [&](const Eigen::Vector3d& x) {
          return 37 + 63 * std::erfc(x.x() / width);
        }) < tolerance);
  const HeatLedger& ledger = field.ledger();
  CHECK(ledger.in == Approx(ledger.sensible).epsilon(1e-12));
}

// Constant flux: Ts = T0 + (2 q/k) sqrt(a t/pi) (Carslaw and Jaeger 1959, 2.9).
TEST_CASE("heat conduction: the surface under constant flux follows its closed form",
          "[validation]") {
  const auto [edge, tolerance] =
      GENERATE(table<double, double>({{0.5e-3, 0.7}, {0.25e-3, 0.2}, {0.125e-3, 0.06}}));
  const TetMesh bar = make_box({static_cast<Index>(std::lround(10e-3 / edge)), 1, 1}, edge);
  HeatField field(bar, kLiver, dry_model(), kExact);
  const std::vector<HeatSource> sources = heat_face(bar, is_face, 1e4);
  for (int i = 0; i < 300; ++i) {
    field.step(1.0 / 60, sources);
  }
  const double rise = 2e4 / kLiver.conductivity * std::sqrt(diffusivity(kLiver) * 5 / pi);
  CHECK(face_temperature(field, sources) == Approx(37 + rise).margin(tolerance));
}

// The inverse of the above: t = (pi/4) k rho c (dT/q)^2.
TEST_CASE("heat conduction: a surface takes the time to boil that it must", "[validation]") {
  const TetMesh bar = make_box({60, 1, 1}, 0.0625e-3);
  HeatField field(bar, kLiver, dry_model(), kExact);
  const std::vector<HeatSource> sources = heat_face(bar, is_face, 1e5);
  constexpr double kTimeStep = 2e-3;
  double time = 0;
  while (face_temperature(field, sources) < kBoilingTemperature) {
    field.step(kTimeStep, sources);
    time += kTimeStep;
  }
  const double expected =
      pi / 4 * kLiver.conductivity * kLiver.density * kLiver.specific_heat * std::pow(63 / 1e5, 2);
  CHECK(time == Approx(expected).epsilon(0.03));
}

// Insulated cube: cos cos cos decays with exp(-3 pi^2 a t / L^2), a mode of the equation. Second
// order in space and, with theta 1/2, time.
TEST_CASE("heat conduction: a mode of a cube decays at its rate, to second order", "[validation]") {
  constexpr double kLength = 10e-3;
  const double jitter = GENERATE(0.0, 0.15);
  const double time = 0.02 * kLength * kLength / diffusivity(kLiver);
  std::vector<double> errors;
  for (const Index n : {8, 16}) {
    const TetMesh mesh = make_jittered_box({n, n, n}, kLength / n, jitter);
    HeatField field(mesh, kLiver, dry_model(0.5), kExact);
    const auto mode = [&](double decay) {
      return [=](const Eigen::Vector3d& x) {
        return 37 + 10 * decay * std::cos(pi * x.x() / kLength) * std::cos(pi * x.y() / kLength) *
                        std::cos(pi * x.z() / kLength);
      };
    };
    set_profile(field, all_of(mesh), mode(1));
    for (Index i = 0; i < n; ++i) {
      field.step(time / n, {});
    }
    const double decay = std::exp(-3 * pi * pi * 0.02);
    errors.push_back(mean_error(field, mode(decay)) / (10 * decay / std::sqrt(8)));
    CHECK(field.ledger().in == Approx(field.ledger().sensible).margin(1e-9));
  }
  CHECK(errors[1] < 1e-2);
  CHECK(order(errors[0], errors[1], 2) == Approx(2).margin(0.2));
}

// Manufactured solution e^{-s} sin sin sin of s = a t / L^2, whose source is (3 pi^2 - 1) of it
// (Roache 2002, J. Fluids Eng. 124:4).
TEST_CASE("heat conduction: a manufactured solution is met to second order", "[validation]") {
  constexpr double kLength = 10e-3;
  const double time = 0.1 * kLength * kLength / diffusivity(kLiver);
  std::vector<double> errors;
  for (const Index n : {6, 12, 24}) {
    const TetMesh mesh = make_jittered_box({n, n, n}, kLength / n, 0.15);
    HeatField field(mesh, kLiver, dry_model(0.5), {.active_rise = 0, .tolerance = 1e-9});
    const auto shape = [&](const Eigen::Vector3d& x) {
      return 20 * std::sin(pi * x.x() / kLength) * std::sin(pi * x.y() / kLength) *
             std::sin(pi * x.z() / kLength);
    };
    set_profile(field, all_of(mesh), [&](const Eigen::Vector3d& x) { return 37 + shape(x); });
    field.hold(vertices_where(mesh, [&](const Eigen::Vector3d& x) {
      return x.minCoeff() == 0 || x.maxCoeff() > 0.9999 * kLength;
    }));
    const double rate = diffusivity(kLiver) / (kLength * kLength);
    std::vector<HeatSource> sources;
    for (Index i = 0; i < n; ++i) {
      const double middle = (i + 0.5) * time / n;
      sources.clear();
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        const double power = field.capacity(v) * rate * (3 * pi * pi - 1) *
                             std::exp(-rate * middle) * shape(mesh.positions()[v]);
        sources.push_back({v, std::max(power, 0.0)});
      }
      field.step(time / n, sources);
    }
    errors.push_back(mean_error(
        field, [&](const Eigen::Vector3d& x) { return 37 + std::exp(-0.1) * shape(x); }));
  }
  CHECK(order(errors[0], errors[1], 2) > 1.8);
  CHECK(order(errors[1], errors[2], 2) == Approx(2.05).margin(0.25));
}

// Against the same mesh with a step so fine that it has no error of its own.
TEST_CASE("heat conduction: theta 1 is of first order in time, 1/2 of second", "[validation]") {
  constexpr double kLength = 10e-3;
  const TetMesh bar = make_box({16, 1, 1}, kLength / 16);
  const double time = 0.1 * kLength * kLength / diffusivity(kLiver);
  const auto solve = [&](double theta, int steps) {
    HeatField field(bar, kLiver, dry_model(theta), {.active_rise = 0, .tolerance = 1e-13});
    set_profile(field, all_of(bar),
                [&](const Eigen::Vector3d& x) { return 47 + 10 * std::cos(pi * x.x() / kLength); });
    for (int i = 0; i < steps; ++i) {
      field.step(time / steps, {});
    }
    return std::vector<double>(field.temperatures().begin(), field.temperatures().end());
  };
  const std::vector<double> reference = solve(0.5, 2000);
  const auto error = [&](double theta, int steps) {
    const std::vector<double> found = solve(theta, steps);
    double largest = 0;
    for (std::size_t v = 0; v < found.size(); ++v) {
      largest = std::max(largest, std::abs(found[v] - reference[v]));
    }
    return largest;
  };
  CHECK(order(error(1, 8), error(1, 16), 2) == Approx(1).margin(0.1));
  CHECK(order(error(1, 16), error(1, 32), 2) == Approx(1).margin(0.1));
  CHECK(order(error(0.5, 16), error(0.5, 32), 2) == Approx(2.2).margin(0.4));
}

// Steady heat through two layers: the temperature between them divides the span as their
// resistances L/k do. Exact for linear elements where the layers meet at vertices.
TEST_CASE("heat conduction: two layers share a temperature span as their resistances",
          "[validation]") {
  const TetMesh mesh = make_box({8, 3, 3}, 1e-3);
  std::vector<Index> layers;
  for (const Tet& tet : mesh.tets()) {
    double x = 0;
    for (const Index v : tet) {
      x += mesh.positions()[v].x() / 4;
    }
    layers.push_back(x < 4e-3 ? 0 : 1);
  }
  const ThermalProperties tissues[] = {kLiver, kFat};
  HeatField field(ThermalMesh(mesh, tissues, layers), dry_model(), kExact);
  const std::vector<Index> ends =
      vertices_where(mesh, [](const Eigen::Vector3d& x) { return x.x() == 0 || x.x() > 7.999e-3; });
  set_profile(field, ends, [](const Eigen::Vector3d& x) { return x.x() == 0 ? 100 : 37; });
  field.hold(ends);
  const double in_before = field.ledger().in, sensible_before = field.ledger().sensible;
  CHECK(settle(field));
  const double middle = 100 - 63 * kFat.conductivity / (kFat.conductivity + kLiver.conductivity);
  CHECK(largest_error(field, [&](const Eigen::Vector3d& x) {
          return x.x() < 4e-3 ? 100 + (middle - 100) * x.x() / 4e-3
                              : middle + (37 - middle) * (x.x() - 4e-3) / 4e-3;
        }) < 1e-7);
  CHECK(field.ledger().in - in_before ==
        Approx(field.ledger().sensible - sensible_before).epsilon(1e-9));
}

// Where k = k0 (1 + b (T - 37)), a steady T + b (T - 37)^2 / 2 is linear (Kirchhoff 1894), which
// bends T by up to 4.6 K here. Met to second order, as conductivity is taken at the mean of a
// tetrahedron; would catch one that does not follow the temperature, or a step behind for good.
TEST_CASE("heat conduction: conductivity that rises with heat bends a steady profile",
          "[validation]") {
  constexpr double kRise = 0.012, kLength = 8e-3;
  ThermalProperties tissue = kLiver;
  tissue.conductivity_rise = kRise;
  const auto exact = [&](const Eigen::Vector3d& x) {
    const double hot = 63 + kRise * 63 * 63 / 2;
    return 37 + (std::sqrt(1 + 2 * kRise * hot * (1 - x.x() / kLength)) - 1) / kRise;
  };
  std::vector<double> errors;
  for (const Index cells : {4, 8, 16}) {
    const double edge = kLength / cells;
    const TetMesh mesh = make_box({cells, cells / 2, cells / 2}, edge);
    HeatField field(mesh, tissue, dry_model(), kExact);
    const std::vector<Index> ends = vertices_where(
        mesh, [&](const Eigen::Vector3d& x) { return x.x() == 0 || x.x() > kLength - 0.5 * edge; });
    set_profile(field, ends, [](const Eigen::Vector3d& x) { return x.x() == 0 ? 100 : 37; });
    field.hold(ends);
    for (int i = 0; i < 5; ++i) {  // each takes conductivities from the one before
      CHECK(settle(field));
    }
    errors.push_back(mean_error(field, exact));
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-9 * field.ledger().in);
  }
  CHECK(errors[2] < 0.02);
  CHECK(order(errors[0], errors[1], 2) == Approx(2).margin(0.25));
  CHECK(order(errors[1], errors[2], 2) == Approx(2).margin(0.25));
}

// Would catch an operator that knows where a body lies or how it is turned.
TEST_CASE("heat conduction: a body that is moved and turned conducts the same", "[property]") {
  const TetMesh mesh = make_box({5, 5, 5}, 1e-3, 0.1);
  const Eigen::Matrix3d rotation =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -3).normalized()).toRotationMatrix();
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& x : mesh.positions()) {
    points.emplace_back(rotation * x + Eigen::Vector3d(0.03, -0.02, 0.05));
  }
  const TetMesh moved(points, {mesh.tets().begin(), mesh.tets().end()});
  HeatField here(mesh, kLiver, {}, kExact), there(moved, kLiver, {}, kExact);
  double largest = 0, difference = 0;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    for (std::size_t e = 0; e < 6; ++e) {
      const double coefficient = here.mesh().edge_coefficients(t)[e];
      largest = std::max(largest, std::abs(coefficient));
      difference =
          std::max(difference, std::abs(coefficient - there.mesh().edge_coefficients(t)[e]));
    }
  }
  CHECK(difference < 1e-11 * largest);  // a millimetre at 6 cm, to rounding
  for (int i = 0; i < 20; ++i) {
    here.step(5e-3, std::vector<HeatSource>{{100, 0.3}});
    there.step(5e-3, std::vector<HeatSource>{{100, 0.3}});
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    REQUIRE(here.temperatures()[v] == Approx(there.temperatures()[v]).epsilon(1e-9));
  }
}

// Power Q from a sphere of radius a into what is held at Tb at radius b: T - Tb = Q / (4 pi k) (1/r
// - 1/b) (Carslaw and Jaeger 1959, 9.2). A sixth of it.
TEST_CASE("heat conduction: heat from a sphere falls off with its distance", "[validation]") {
  constexpr double kInner = 1e-3, kOuter = 4e-3, kPower = 0.2;
  const auto exact = [&](double r) {
    return 37 + kPower / (4 * pi * kLiver.conductivity) * (1 / r - 1 / kOuter);
  };
  std::vector<double> errors, resistance_errors;
  for (const Index n : {8, 16}) {
    const TetMesh mesh = testing::make_sphere_sector(n, kInner, kOuter);
    HeatField field(mesh, kLiver, dry_model(), {.active_rise = 0, .tolerance = 1e-9});
    field.hold(
        vertices_where(mesh, [&](const Eigen::Vector3d& x) { return x.norm() > 0.9999 * kOuter; }));
    std::vector<HeatSource> sources = heat_face(
        mesh, [&](const Eigen::Vector3d& x) { return x.norm() < 1.0001 * kInner; }, 1);
    double area = 0;
    for (const HeatSource& source : sources) {
      area += source.power;
    }
    for (HeatSource& source : sources) {
      source.power *= kPower / 6 / area;
    }
    for (int i = 0; i < 4; ++i) {
      CHECK(field.step(1e5, sources).converged);
    }
    const double rise = exact(kInner) - 37;
    resistance_errors.push_back(std::abs(face_temperature(field, sources) - exact(kInner)) / rise);
    errors.push_back(
        largest_error(field, [&](const Eigen::Vector3d& x) { return exact(x.norm()); }) / rise);
    CHECK(field.ledger().in == Approx(field.ledger().sensible).epsilon(1e-9));
  }
  CHECK(errors[1] < 1e-2);
  CHECK(resistance_errors[1] < 2e-3);
  CHECK(order(resistance_errors[0], resistance_errors[1], 2) > 1.7);
}

// The theta method is stable for any step from theta 1/2 on; theta below, which has a longest step,
// is refused (thermal_model_test.cpp). The variance of temperatures never grows, on a mesh whose
// flat tetrahedra would need steps of microseconds otherwise.
TEST_CASE("heat conduction: no step is too long", "[property]") {
  const double theta = GENERATE(0.5, 2.0 / 3, 1.0);
  const double dt = GENERATE(1e-3, 1.0, 1e4);
  const double height = GENERATE(1.0, 0.03);
  const TetMesh block = make_jittered_box({5, 5, 5}, 1e-3, 0.25);
  std::vector<Eigen::Vector3d> points(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& p : points) {
    p.z() *= height;
  }
  const TetMesh mesh(points, {block.tets().begin(), block.tets().end()});
  HeatField field(mesh, kLiver, dry_model(theta),
                  {.active_rise = 0, .tolerance = 1e-10, .most_iterations = 1000});
  set_profile(field, all_of(mesh), [&](const Eigen::Vector3d& x) {
    return 37 + 20 * random_unit(3, static_cast<std::uint64_t>(1e9 * x.sum()));
  });
  const auto mean = [&](const Eigen::Vector3d&) {
    double heat = 0, capacity = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      heat += field.capacity(v) * field.temperatures()[v];
      capacity += field.capacity(v);
    }
    return heat / capacity;
  };
  const double level = mean({});
  double variance = mean_error(field, [&](const Eigen::Vector3d&) { return level; });
  for (int i = 0; i < 10; ++i) {
    const HeatReport report = field.step(dt, {});
    CHECK((i > 0 || report.converged));  // later, rounding is all that is left to solve for
    const double now = mean_error(field, [&](const Eigen::Vector3d&) { return level; });
    REQUIRE(now <= variance * (1 + 1e-6));
    variance = now;
  }
  CHECK(mean({}) == Approx(level).epsilon(1e-12));
}

}  // namespace pbdsurg
