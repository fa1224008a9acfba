// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fields of potential and heat must give whoever solves their systems: for a device, and for
/// what stands in for one where there is none.

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"
#include "tests/support/scenes.h"

namespace pbdsurg::testing {

/// What a field has found, one entry a solution.
struct Found {
  std::vector<PotentialReport> reports;
  std::vector<std::vector<double>> potentials, vertex_heat, tet_heat;

  void add(const PotentialField& field) {
    reports.push_back(field.report());
    potentials.emplace_back(field.potentials().begin(), field.potentials().end());
    vertex_heat.emplace_back(field.vertex_heat().begin(), field.vertex_heat().end());
    tet_heat.emplace_back(field.element_heat().begin(), field.element_heat().end());
  }
};

/// A contact, whole or in part, that moves over a block with obtuse tetrahedra and burns it:
/// tetrahedra that go or are dry, a hole, a region that is a ball or all of the block, a current
/// shape, an island.
inline Found burn_block(std::array<Index, 3> cells, const PotentialOptions& options) {
  constexpr double kEdge = 1e-3;  // m
  const TetMesh shape = make_box(cells, kEdge, 0.2);
  Tissue tissue(scene_of(shape));
  const ThermalMesh mesh(tissue, std::array{ThermalBody{0, tissues::liver().heat}});
  PotentialField field(mesh, options);
  std::vector<double> conductivities(shape.tets().size(), 0.3);
  const Eigen::Vector3d top(cells[0] / 2 * kEdge, cells[1] / 2 * kEdge, cells[2] * kEdge);
  const auto for_tets_between = [&](double low, double high, auto visit) {
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      const double distance = (mesh.rest_positions()[mesh.tets()[t][0]] - top).norm() / kEdge;
      if (distance >= low && distance < high) {
        visit(t);
      }
    }
  };
  const auto remove_between = [&](double low, double high) {
    TopologyEdit edit;
    for_tets_between(low, high, [&](Index t) {
      if (mesh.is_alive(t)) {
        edit.remove_tets.push_back(t);
      }
    });
    tissue.apply(edit);
  };
  const auto touch = [&](double way, double reach) {
    std::vector<PatchVertex> patch;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const double distance =
          (mesh.rest_positions()[v] - top - Eigen::Vector3d(way * kEdge, 0, 0)).norm() / kEdge;
      if (distance < reach) {
        patch.push_back({v, std::min(1.0, reach - distance)});
      }
    }
    field.set_patch(patch, 3 * kEdge * kEdge);
  };
  Found found;
  const auto solve = [&](std::span<const Eigen::Vector3f> positions = {}) {
    field.solve(conductivities, positions);
    found.add(field);
  };
  for (int frame = 0; frame < 14; ++frame) {
    touch(0.3 * frame, 1.9);
    for_tets_between(0, 2, [&](Index t) { conductivities[t] *= 0.9; });
    if (frame % 4 == 3) {  // one goes, which leaves the region as it is
      TopologyEdit edit;
      for_tets_between(1.5, 3, [&](Index t) {
        if (mesh.is_alive(t)) {
          edit.remove_tets = {t};
        }
      });
      tissue.apply(edit);
    }
    solve();
  }
  for_tets_between(2, 2.6, [&](Index t) { conductivities[t] = 0; });
  solve();
  remove_between(0, 1.5);
  solve();
  std::vector<Index> ground;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.rest_positions()[v].z() < 0.5 * kEdge) {
      ground.push_back(v);
    }
  }
  field.set_ground(ground);
  solve();
  std::vector<Eigen::Vector3f> stretched;
  for (const Eigen::Vector3d& x : mesh.rest_positions()) {
    stretched.emplace_back(x.cast<float>().cwiseProduct(Eigen::Vector3f(1.2F, 1, 0.9F)));
  }
  solve(stretched);
  solve();
  touch(0, 0.1);  // where nothing is left
  solve();
  remove_between(3.5, 5);
  touch(2.5, 1.2);  // on an island
  solve();
  touch(-6, 1.5);  // beyond
  solve();
  return found;
}

/// Checks that a backend finds what the CPU does, and finds it again.
inline void check_potentials(std::array<Index, 3> cells, const Executor& device) {
  const PotentialOptions tight{.tolerance = 1e-11, .most_iterations = 2000};
  PotentialOptions options = tight;
  const Found expected = burn_block(cells, options);
  options.executor = device;
  options.device_rows = 0;
  const Found found = burn_block(cells, options);
  const Found again = burn_block(cells, options);
  CHECK(again.potentials == found.potentials);
  CHECK(again.vertex_heat == found.vertex_heat);
  CHECK(again.tet_heat == found.tet_heat);
  REQUIRE(found.reports.size() == expected.reports.size());
  int closed = 0, open = 0;
  for (std::size_t i = 0; i < found.reports.size(); ++i) {
    INFO("solution " << i);
    const PotentialReport& report = found.reports[i];
    CHECK(report.is_closed == expected.reports[i].is_closed);
    CHECK(report.is_new == expected.reports[i].is_new);
    CHECK(report.has_converged);
    CHECK(report.vertex_count == expected.reports[i].vertex_count);
    CHECK((report.is_on_device || report.vertex_count == 0));
    const double whole = expected.reports[i].conductance;
    CHECK(report.conductance == Approx(whole).epsilon(1e-8));
    // the heat of contacts in part is no tetrahedron's
    CHECK(sum(found.vertex_heat[i]) == Approx(report.conductance).epsilon(1e-12));
    CHECK(sum(found.tet_heat[i]) == Approx(sum(expected.tet_heat[i])).epsilon(1e-8));
    REQUIRE(found.potentials[i].size() == expected.potentials[i].size());
    double of_potentials = 0, of_heat = 0;
    for (std::size_t row = 0; row < found.potentials[i].size(); ++row) {
      of_potentials =
          std::max(of_potentials, std::abs(found.potentials[i][row] - expected.potentials[i][row]));
      of_heat =
          std::max(of_heat, std::abs(found.vertex_heat[i][row] - expected.vertex_heat[i][row]));
    }
    CHECK(of_potentials < 1e-7);
    CHECK(of_heat <= 1e-7 * whole);
    (report.is_closed ? closed : open) += 1;
  }
  CHECK(closed > 15);
  CHECK(open > 0);
}

/// Steps of a block that is heated at a place that moves, with a vertex that is held and an edit.
inline std::vector<double> heat_block(std::array<Index, 3> cells, const HeatOptions& options) {
  constexpr double kEdge = 1e-3;  // m
  const TetMesh mesh = make_box(cells, kEdge, 0.2);
  Tissue tissue(scene_of(mesh));
  HeatField field(tissue, std::array{ThermalBody{0, tissues::liver().heat}}, {}, options);
  field.set_temperatures(std::vector<Index>{3}, std::vector<double>{80});
  field.hold(std::vector<Index>{3});
  HeatField copy = field;  // with a device system of its own, if any
  std::vector<double> all;
  for (int step = 0; step < 40; ++step) {
    const Index at = mesh.vertex_count() / 2 + step / 4;
    const std::vector<HeatSource> sources{{at, 2}};
    const HeatReport report = field.step(5e-3, sources);
    CHECK(report.converged);
    CHECK(report.is_on_device == static_cast<bool>(options.executor));
    if (step <= 20) {
      CHECK(copy.step(5e-3, sources).is_on_device == report.is_on_device);
      CHECK(std::ranges::equal(copy.temperatures(), field.temperatures()));
    }
    if (step == 20) {
      tissue.apply({.remove_tets = {5, 6, 7}});  // which copies do not follow
    }
    all.insert(all.end(), field.temperatures().begin(), field.temperatures().end());
  }
  const HeatLedger& ledger = field.ledger();
  CHECK(ledger.sensible + ledger.latent + ledger.removed + ledger.surface + ledger.perfusion ==
        Approx(ledger.in).epsilon(1e-9));
  return all;
}

/// As check_potentials(), of temperatures.
inline void check_temperatures(std::array<Index, 3> cells, const Executor& device) {
  HeatOptions options{.tolerance = 1e-12, .most_iterations = 1000};
  const std::vector<double> expected = heat_block(cells, options);
  options.executor = device;
  options.device_rows = 0;
  const std::vector<double> found = heat_block(cells, options);
  CHECK(found == heat_block(cells, options));
  double apart = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    apart = std::max(apart, std::abs(found[i] - expected[i]));
  }
  CHECK(apart < 1e-7);
  CHECK(*std::max_element(found.begin(), found.end()) > 60);
}

}  // namespace pbdsurg::testing
