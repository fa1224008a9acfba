// SPDX-License-Identifier: Apache-2.0
// Current whose potential is known in closed form.
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/tissue/library.h"

#include "lib/heat/local_system.h"
#include "tests/support/catch.h"
#include "tests/support/conduction_meshes.h"
#include "tests/support/potential_cases.h"

namespace pbdsurg {
namespace {

using std::numbers::pi;
using testing::Approx;
using testing::Conductor;

constexpr double kSigma = 0.3;  // S/m

// Inner vertices displaced along the axis and across it, ends and sides kept.
TetMesh make_bar(Index cells, Index width, double edge) {
  const TetMesh regular = testing::make_box({cells, width, width}, edge);
  std::vector<Eigen::Vector3d> points(regular.positions().begin(), regular.positions().end());
  for (std::size_t v = 0; v < points.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double most = edge * (axis == 0 ? cells : width);
      const double middle = edge * cells / 2;
      const bool is_free = points[v][axis] > 0.1 * edge && points[v][axis] < most - 0.1 * edge &&
                           std::abs(points[v].x() - middle) > 0.1 * edge;
      points[v][axis] += is_free ? 0.2 * edge * (2 * random_unit(3, v, axis) - 1) : 0;
    }
  }
  return {points, {regular.tets().begin(), regular.tets().end()}};
}

Conductor make_bar_conductor(double edge) {
  return {make_bar(12, 3, edge), [=](const auto& x) { return x.x() < 0.1 * edge; },
          [=](const auto& x) { return x.x() > 11.9 * edge; }, kSigma};
}

// Between spheres of 1 mm and 4 mm.
constexpr double kInner = 1e-3, kOuter = 4e-3;  // m

Conductor make_sphere_conductor(Index n) {
  return {testing::make_sphere_sector(n, kInner, kOuter),
          [](const auto& x) { return x.norm() < 1.0001 * kInner; },
          [](const auto& x) { return x.norm() > 0.9999 * kOuter; }, kSigma};
}

// Under a disk, out to a spheroid ten times as thick.
constexpr double kDisk = 1e-3, kReach = 10;  // m, 1

// sinh(mu) of the spheroid through a point.
double spheroid(const Eigen::Vector3d& x) {
  const Eigen::Vector3d p = x / kDisk;
  const double depth = p.z() * p.z(), excess = p.squaredNorm() - 1;
  return std::sqrt(std::max(0.0, (excess + std::sqrt(excess * excess + 4 * depth)) / 2));
}

Conductor make_disk_conductor(Index n) {
  return {testing::make_disk_quarter(n, kDisk, kReach * kDisk),
          [](const auto& x) { return spheroid(x) < 1e-3; },
          [](const auto& x) { return spheroid(x) > 0.9999 * kReach; }, kSigma};
}

}  // namespace

// Uniform current through a bar: R = L / (sigma A), power per volume the same everywhere. Linear
// potentials are exact for linear elements; any error in a coefficient shows.
TEST_CASE("potential: a bar has the resistance L / (sigma A) and is heated evenly", "[unit]") {
  for (const double edge : {1e-3, 1.0}) {
    Conductor bar = make_bar_conductor(edge);
    const PotentialReport& report = bar.solve();
    CHECK(report.is_closed);
    CHECK(report.has_converged);
    CHECK(report.conductance == Approx(kSigma * 9 * edge / 12).epsilon(1e-9));
    const double density = kSigma / (144 * edge * edge);
    for (std::size_t i = 0; i < bar.field.elements().size(); ++i) {
      CHECK(bar.field.element_heat()[i] ==
            Approx(density * bar.mesh.volume(bar.field.elements()[i])).epsilon(1e-8));
    }
  }
}

// A dry layer of 0.25 mm in a bar of 12 mm, R1 + R2: cells of 1 and 0.5 mm have it as a share of
// their water, cells of 0.25 mm as dry cells. Would catch a resistance that depends on the mesh.
TEST_CASE("potential: a dry layer has the same resistance in cells of any size", "[validation]") {
  const ThermalProperties& liver = tissues::liver().heat;
  constexpr double kDry = 0.25e-3;  // m
  const double moist = electrical_conductivity(liver, 100.0, 1.0);
  const double resistance =
      (12e-3 - kDry) / (moist * 4e-6) + kDry / (kDryConductivity * moist * 4e-6);
  for (const Index parts : {1, 2, 4}) {
    const double edge = 1e-3 / parts;
    Conductor bar(
        testing::make_box({12 * parts, 2 * parts, 2 * parts}, edge),
        [=](const auto& x) { return x.x() < 0.1 * edge; },
        [=](const auto& x) { return x.x() > 12e-3 - 0.1 * edge; }, moist);
    for (Index t = 0; t < bar.mesh.tet_count(); ++t) {
      double middle = 0;
      for (const Index v : bar.mesh.tets()[t]) {
        middle += bar.mesh.rest_positions()[v].x() / 4;
      }
      if (middle > 6e-3 && middle < 6e-3 + edge) {
        bar.conductivities[t] = electrical_conductivity(liver, 100.0, 1 - kDry / edge);
      }
    }
    CHECK(bar.solve().conductance == Approx(1 / resistance).epsilon(1e-8));
  }
}

// Layers in series, R = sum of L / (sigma A), of conductivities 100 : 1 as tissue and a dry shell:
// u between them is R2 / (R1 + R2).
TEST_CASE("potential: layers in series share the voltage by their resistances", "[unit]") {
  Conductor bar = make_bar_conductor(1e-3);
  for (Index t = 0; t < bar.mesh.tet_count(); ++t) {
    const Tet& tet = bar.mesh.tets()[t];
    double middle = 0;
    for (const Index v : tet) {
      middle += bar.mesh.rest_positions()[v].x() / 4;
    }
    bar.conductivities[t] = middle < 6e-3 ? kSigma : kSigma / 100;
  }
  const double near = 6e-3 / (kSigma * 9e-6), far = 100 * near;
  CHECK(bar.solve().conductance == Approx(1 / (near + far)).epsilon(1e-9));
  const std::vector<double> u =
      testing::spread(bar.field, bar.field.potentials(), bar.mesh.vertex_count());
  for (Index v = 0; v < bar.mesh.vertex_count(); ++v) {
    if (std::abs(bar.mesh.rest_positions()[v].x() - 6e-3) < 1e-6) {
      CHECK(u[v] == Approx(far / (near + far)).epsilon(1e-9));
    }
  }
}

// Concentric spheres: R = (1/a - 1/b) / (4 pi sigma), u = (1/r - 1/b) / (1/a - 1/b); second order.
TEST_CASE("potential: between concentric spheres it falls as 1/r, at second order", "[unit]") {
  const double exact = 4 * pi * kSigma / (1 / kInner - 1 / kOuter);
  std::vector<double> errors;
  for (const Index n : {4, 8, 16}) {
    Conductor spheres = make_sphere_conductor(n);
    errors.push_back(std::abs(6 * spheres.solve().conductance / exact - 1));
    double worst = 0;
    for (std::size_t row = 0; row < spheres.field.vertices().size(); ++row) {
      const double r = spheres.mesh.rest_positions()[spheres.field.vertices()[row]].norm();
      const double u = (1 / r - 1 / kOuter) / (1 / kInner - 1 / kOuter);
      worst = std::max(worst, std::abs(spheres.field.potentials()[row] - u));
    }
    CHECK(worst < 0.16 / n);
  }
  CHECK(errors[1] < 5e-3);
  CHECK(std::log2(errors[0] / errors[1]) > 1.7);
  CHECK(std::log2(errors[1] / errors[2]) > 1.7);
}

// A disk on a half-space, out to the spheroid sinh(mu1) = 10 (oblate spheroidal coordinates):
// R = atan(sinh mu1) / (2 pi sigma a), u = 1 - atan(sinh mu) / atan(sinh mu1), the power inside
// sinh(mu) = s is atan(s) / atan(sinh mu1) of all. Current crowds at the rim (Wiley and Webster
// 1982), where heat must be densest.
TEST_CASE("potential: a disk on a half-space has its resistance, power and hot rim", "[unit]") {
  const double exact = 2 * pi * kSigma * kDisk / std::atan(kReach);
  for (const Index n : {6, 8, 12}) {
    Conductor disk = make_disk_conductor(n);
    CHECK(4 * disk.solve().conductance == Approx(exact).epsilon(0.005));
    double worst = 0;
    for (std::size_t row = 0; row < disk.field.vertices().size(); ++row) {
      const double s = spheroid(disk.mesh.rest_positions()[disk.field.vertices()[row]]);
      worst = std::max(
          worst, std::abs(disk.field.potentials()[row] - (1 - std::atan(s) / std::atan(kReach))));
    }
    CHECK(worst < 0.07);

    const double total = testing::sum(disk.field.element_heat());
    std::vector<double> inside(static_cast<std::size_t>(3 * n + 1), 0.0);
    double centre = 0, rim = 0;  // W/V^2 m^3
    for (std::size_t i = 0; i < disk.field.elements().size(); ++i) {
      const Index t = disk.field.elements()[i];
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const Index v : disk.mesh.tets()[t]) {
        middle += disk.mesh.rest_positions()[v] / 4;
      }
      const double sheet = std::asinh(spheroid(middle)) / std::asinh(kReach) * 3 * n;
      for (Index k = static_cast<Index>(sheet) + 1; k <= 3 * n; ++k) {
        inside[k] += disk.field.element_heat()[i];
      }
      const double density = disk.field.element_heat()[i] / disk.mesh.volume(t);
      const double across = middle.head<2>().norm();
      if (sheet < 1) {
        (across < 0.5 * kDisk ? centre : rim) =
            std::max(across < 0.5 * kDisk ? centre : rim, density);
      }
    }
    CHECK(rim > 2 * centre);
    for (const Index k : {n / 2, n, 2 * n}) {
      const double s = std::sinh(std::asinh(kReach) * k / (3 * n));
      CHECK(inside[k] / total == Approx(std::atan(s) / std::atan(kReach)).margin(0.02));
    }
  }
}

// Current between spheres heats them, q = I^2 / (16 pi^2 sigma r^4); with both held at T_a the
// steady rise is Q ((1/a + 1/b) / r - 1/(a b) - 1/r^2) / 2, Q = I^2 / (16 pi^2 sigma k), from
// (r^2 T')' = -Q / r^2. Would catch heat that goes to wrong vertices.
TEST_CASE("potential: its heat between spheres gives the steady temperature", "[unit]") {
  Conductor spheres = make_sphere_conductor(16);
  const double current = 6 * spheres.solve().conductance;  // of the whole spheres, at 1 V
  const auto rows = static_cast<std::size_t>(spheres.mesh.vertex_count());
  std::vector<double> power(rows, 0.0), rise(rows, 0.0), added(rows, 0.0);
  for (std::size_t i = 0; i < spheres.field.vertices().size(); ++i) {
    power[spheres.field.vertices()[i]] = spheres.field.vertex_heat()[i];
  }
  for (const PatchVertex& held : spheres.patch) {
    added[held.vertex] = std::numeric_limits<double>::infinity();
  }
  for (const Index v : spheres.ground_vertices) {
    added[v] = std::numeric_limits<double>::infinity();
  }
  std::vector<std::array<double, 6>> conductances;
  for (Index t = 0; t < spheres.mesh.tet_count(); ++t) {
    conductances.push_back(spheres.mesh.edge_coefficients(t));
    for (double& value : conductances.back()) {
      value *= tissues::liver().heat.conductivity;
    }
  }
  LocalSystem system;
  system.set_rows(spheres.mesh.vertex_count(), spheres.mesh.tets());
  system.set_couplings(conductances);
  system.set_added(added);
  CHECK(system.solve(power, rise, {.tolerance = 1e-9}).converged);

  const double q = current * current / (16 * pi * pi * kSigma * tissues::liver().heat.conductivity);
  double worst = 0, highest = 0;
  for (std::size_t v = 0; v < rows; ++v) {
    const double r = spheres.mesh.rest_positions()[static_cast<Index>(v)].norm();
    const double exact =
        q / 2 * ((1 / kInner + 1 / kOuter) / r - 1 / (kInner * kOuter) - 1 / (r * r));
    worst = std::max(worst, std::abs(rise[v] - exact));
    highest = std::max(highest, exact);
  }
  CHECK(worst < 0.02 * highest);
}

namespace {

void check_power(Conductor& at) {
  const double conductance = at.solve().conductance;
  CHECK(testing::sum(at.field.element_heat()) == Approx(conductance).epsilon(1e-12));
  CHECK(testing::sum(at.field.vertex_heat()) == Approx(conductance).epsilon(1e-12));
  const std::vector<double> all = testing::currents(at.mesh, at.field, at.conductivities);
  double into = 0, out = 0;
  for (const PatchVertex& held : at.patch) {
    into += all[held.vertex];
  }
  for (const Index v : at.ground_vertices) {
    out -= all[v];
  }
  CHECK(into == Approx(conductance).epsilon(1e-9));
  CHECK(out == Approx(conductance).epsilon(1e-9));
}

}  // namespace

// What tets and vertices are given sums to U I, and the currents of either electrode are I.
TEST_CASE("potential: power is voltage times current, which nothing loses", "[unit]") {
  Conductor bar = make_bar_conductor(1e-3);
  check_power(bar);
  Conductor spheres = make_sphere_conductor(6);
  check_power(spheres);
}

}  // namespace pbdsurg
