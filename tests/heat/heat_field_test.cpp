// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/heat_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/heat_blocks.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Blocks;
using testing::ContainsSubstring;
using testing::kFat;
using testing::kLiver;
using testing::ledger_error;
using testing::make_box;
using testing::same;
using testing::same_ledger;
using testing::same_state;
using testing::sensible_heat;

}  // namespace

// Would catch heat made or lost by conduction, boiling, the surface, blood or removal, by a region
// that grows and shrinks, or by a ledger that drifts from the field.
TEST_CASE("heat field: every joule is accounted for in every step", "[property]") {
  const Blocks blocks(make_box({10, 10, 10}, 0.7e-3, 0.1));
  Tissue tissue(blocks.scene);
  ThermalModel model;
  model.has_perfusion = true;
  model.surface_transfer = 500;
  model.ambient_temperature = 22;
  HeatField field = blocks.field(tissue, model);
  const Body& body = tissue.body(1);
  std::vector<TetHeatSource> sources;
  for (Index t = 0; t < 6; ++t) {
    sources.push_back({body.first_tet + 2700 + t, 1.5});
  }
  for (int i = 0; i < 200; ++i) {
    const HeatReport report =
        field.step(5e-3, {}, i < 120 ? sources : std::vector<TetHeatSource>{});
    CHECK(report.converged);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-13 * field.ledger().in);
    CHECK(sensible_heat(field) == Approx(field.ledger().sensible).epsilon(1e-10));
    if (i == 100) {
      TopologyEdit edit;
      for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
        if (field.boiled_vertices(t) == 4) {
          edit.remove_tets.push_back(t);
        }
      }
      REQUIRE_FALSE(edit.remove_tets.empty());
      tissue.apply(edit);
    }
  }
  const HeatLedger& ledger = field.ledger();
  for (const double part : {ledger.latent, ledger.removed, ledger.surface, ledger.perfusion}) {
    CHECK(std::abs(part) > 1e-4 * ledger.in);  // blood warms what the ambient cools
  }
}

// Would catch a rim that keeps heat in, or heat that is forgotten: the warm part alone gives what
// the whole mesh does, but for what is too little to be followed.
TEST_CASE("heat field: what rests does not matter", "[property]") {
  const TetMesh mesh = make_box({16, 16, 16}, 0.5e-3, 0.1);
  HeatField part(mesh, kLiver), whole(mesh, kLiver, {}, {.active_rise = 0});
  const std::vector<HeatSource> sources{{17 * 17 * 8 + 17 * 8 + 8, 2}};
  Index most = 0;
  for (int i = 0; i < 400; ++i) {
    const std::span<const HeatSource> now = i < 100 ? sources : std::span<const HeatSource>();
    most = std::max(most, part.step(0.01, now).active_vertices);
    whole.step(0.01, now);
    double largest = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      largest = std::max(largest, std::abs(part.temperatures()[v] - whole.temperatures()[v]));
    }
    REQUIRE(largest < 0.1);
  }
  CHECK(most < mesh.vertex_count() * 3 / 5);
}

// Would catch work that grows with the organ: the same burn in ten times the tissue.
TEST_CASE("heat field: an equal burn costs the same in a larger organ", "[property]") {
  const auto burn = [](std::array<Index, 3> cells) {
    const TetMesh mesh = make_box(cells, 0.5e-3);
    HeatField field(mesh, kLiver);
    const Index middle = (cells[0] + 1) * (cells[1] / 2) + cells[0] / 2;  // of the face z = 0
    std::vector<Index> active;
    for (int i = 0; i < 100; ++i) {
      const HeatReport report = field.step(5e-3, std::vector<HeatSource>{{middle, 5}});
      active.push_back(report.active_vertices);
    }
    return active;
  };
  const std::vector<Index> small = burn({16, 16, 13});  // 20,000 tetrahedra
  CHECK(small == burn({48, 48, 15}));                   // 207,000
  CHECK(small.back() > 100);
  CHECK(small.back() < 17 * 17 * 14 / 2);
}

// Would catch active vertices that are those of the next step: what had changed would be missed.
TEST_CASE("heat field: the region shrinks as it cools, and rests", "[unit]") {
  const TetMesh mesh = make_box({12, 12, 12}, 0.5e-3);
  ThermalModel model;
  model.has_perfusion = true;
  HeatField field(mesh, kLiver, model);
  CHECK(field.step(1, {}).active_vertices == 0);
  Index most = 0;
  for (int i = 0; i < 20; ++i) {
    most = std::max(most, field.step(0.01, std::vector<HeatSource>{{0, 0.2}}).active_vertices);
  }
  REQUIRE(most > 50);
  for (int i = 0; i < 400; ++i) {
    const Index worked_on = field.step(1, {}).active_vertices;
    REQUIRE(static_cast<Index>(field.active_vertices().size()) == worked_on);
  }
  CHECK(field.active_vertices().empty());
  CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
}

// The paper's numbers as printed let heat cross the organ in one step: the region must follow
// within it, or its rim would be far too hot.
TEST_CASE("heat field: the region keeps up with heat that crosses it in a step", "[unit]") {
  const TetMesh mesh = make_box({20, 6, 6}, 1e-3);
  ThermalModel model = ThermalModel::paper();
  model.tissue->density = 3;
  model.tissue->specific_heat = 0.3;
  HeatField part(mesh, kLiver, model), whole(mesh, kLiver, model, {.active_rise = 0});
  const std::vector<HeatSource> sources{{0, 1e-2}};
  for (int i = 0; i < 5; ++i) {
    part.step(1e-4, sources);
    whole.step(1e-4, sources);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      REQUIRE(part.temperatures()[v] ==
              Approx(whole.temperatures()[v]).margin(1 + 0.02 * whole.temperatures()[v]));
    }
  }
  REQUIRE(whole.temperatures()[60] > 40);
}

// Would catch sums that depend on who adds first.
TEST_CASE("heat field: the same bits for any number of threads", "[property]") {
  const TetMesh mesh = make_box({19, 19, 19}, 0.5e-3, 0.1);  // large enough to be shared
  std::vector<HeatField> fields;
  for (const int threads : {1, 2, 3}) {
    fields.emplace_back(mesh, kLiver, ThermalModel{},
                        HeatOptions{.active_rise = 0, .executor = executor::threads(threads)});
  }
  for (int i = 0; i < 30; ++i) {
    for (HeatField& field : fields) {
      field.step(5e-3, std::vector<HeatSource>{{4000, 4}, {20, 1}});
      REQUIRE(same_state(field, fields[0]));
    }
  }
  CHECK(fields[0].ledger().latent > 0);
}

// Would catch coefficients of flat tetrahedra that overflow or take the solver's digits.
TEST_CASE("heat field: slivers are counted and do no harm", "[property]") {
  const double height = GENERATE(1e-3, 1e-6, 1e-9);  // of cells, relative to their width
  const TetMesh block = make_box({5, 5, 3}, 1e-3);
  std::vector<Eigen::Vector3d> points(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& p : points) {
    p.z() = p.z() > 1.5e-3 ? p.z() : height * p.z();  // all below the middle
  }
  const TetMesh flat(points, {block.tets().begin(), block.tets().end()});
  HeatField field(flat, kLiver);
  HeatReport report;
  for (int i = 0; i < 50; ++i) {
    report = field.step(5e-3, std::vector<HeatSource>{{60, 0.2}, {120, 0.2}});
    CHECK(report.accepted);
    CHECK(report.converged);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
  }
  CHECK((report.slivers > 0) == (height < 1e-4));
  for (const double t : field.temperatures()) {
    REQUIRE(std::isfinite(t));
    REQUIRE(t > 30);
  }
}

TEST_CASE("heat field: a step without a finite result is reported and not taken", "[unit]") {
  const TetMesh mesh = make_box({4, 4, 4}, 1e-3);
  HeatField field(mesh, kLiver);
  field.step(0.01, std::vector<HeatSource>{{60, 1}});
  const HeatField before = field;
  const HeatReport report = field.step(0.01, std::vector<HeatSource>{{60, 1e308}, {61, 1e308}});
  CHECK_FALSE(report.accepted);
  CHECK(same(field.temperatures(), before.temperatures()));
  CHECK(same_ledger(field.ledger(), before.ledger()));
  CHECK(field.step(0.01, std::vector<HeatSource>{{60, 1}}).accepted);
}

TEST_CASE("heat field: a solver that has too few iterations is reported, and loses no heat",
          "[unit]") {
  const TetMesh mesh = make_box({6, 6, 6}, 0.5e-3, 0.1);
  HeatField field(mesh, kLiver, {}, {.tolerance = 1e-10, .most_iterations = 1});
  for (int i = 0; i < 20; ++i) {
    const HeatReport report = field.step(0.05, std::vector<HeatSource>{{171, 1}});
    CHECK_FALSE(report.converged);
    CHECK(report.residual > 1e-10);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
  }
}

TEST_CASE("heat field: power in a tetrahedron goes to its corners", "[unit]") {
  const TetMesh mesh = make_box({3, 3, 3}, 1e-3);
  HeatField by_tet(mesh, kFat), by_vertex(mesh, kFat);
  const Tet& tet = mesh.tets()[80];
  by_tet.step(0.01, {}, std::vector<TetHeatSource>{{80, 2}});
  by_vertex.step(
      0.01, std::vector<HeatSource>{{tet[0], 0.5}, {tet[1], 0.5}, {tet[2], 0.5}, {tet[3], 0.5}});
  CHECK(same(by_tet.temperatures(), by_vertex.temperatures()));
  CHECK(by_tet.ledger().in == Approx(0.02));
}

TEST_CASE("heat field: bad values are refused by name", "[unit]") {
  const TetMesh block = make_box({1, 1, 1}, 1e-3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(HeatField(block, {0, 1, 1, 0}), ContainsSubstring("density"));
  CHECK_THROWS_WITH(HeatField(block, kFat, {}, {.active_rise = -1}),
                    ContainsSubstring("active_rise"));
  CHECK_THROWS_WITH(HeatField(block, kFat, {}, {.tolerance = 0}), ContainsSubstring("tolerance"));
  ThermalModel model;
  model.theta = 0.3;
  CHECK_THROWS_WITH(HeatField(block, kFat, model), ContainsSubstring("theta"));
  HeatField field(block, kFat);
  CHECK_THROWS_AS(field.step(0, {}), InvalidArgument);
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{8, 1}}), ContainsSubstring("vertex 8"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, nan}}), ContainsSubstring("power"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, 1}, {2, -1}}),
                    ContainsSubstring("vertex 2"));
  CHECK_THROWS_WITH(field.step(1, {}, std::vector<TetHeatSource>{{6, 1}}),
                    ContainsSubstring("tet 6"));
  const std::vector<Index> first{0}, wrong{-1};
  CHECK_THROWS_WITH(field.set_temperatures(first, std::vector<double>{nan}),
                    ContainsSubstring("vertex 0"));
  CHECK_THROWS_WITH(field.set_temperatures(wrong, std::vector<double>{40}),
                    ContainsSubstring("vertex -1"));
  CHECK_THROWS_WITH(field.hold(wrong), ContainsSubstring("vertex -1"));
  const std::vector<Index> twice{3, 5, 3};
  CHECK_THROWS_WITH(field.hold(twice), ContainsSubstring("vertex 3 is twice"));
  CHECK(field.ledger().in == 0);
  CHECK(field.temperatures()[0] == kBodyTemperature);
}

// Would catch a snapshot without what takes part, what waits, or the ledger.
TEST_CASE("heat field: goes on from a snapshot as it went on, to the bit", "[property]") {
  const Blocks blocks(make_box({10, 10, 10}, 0.7e-3, 0.1));
  Tissue tissue(blocks.scene);
  HeatField field = blocks.field(tissue), other = blocks.field(tissue);
  const Body& body = tissue.body(1);
  const std::vector<TetHeatSource> sources{{body.first_tet + 2700, 2}, {body.first_tet + 90, 1}};
  const auto run = [&](HeatField& of) {
    for (int i = 0; i < 60; ++i) {
      of.step(5e-3, {}, i < 20 ? sources : std::vector<TetHeatSource>{});
    }
  };
  run(field);
  const std::vector<Index> some{body.first_vertex + 7};
  field.set_temperatures(some, std::array{80.0});
  const HeatSnapshot snapshot = field.snapshot();
  run(field);
  const HeatField after = field;
  CHECK_FALSE(snapshot.temperatures == field.snapshot().temperatures);
  for (HeatField* each : {&field, &other}) {
    each->restore(snapshot);
    CHECK(each->snapshot().temperatures == snapshot.temperatures);
    run(*each);
    CHECK(same_state(*each, after));
  }
}

}  // namespace pbdsurg
