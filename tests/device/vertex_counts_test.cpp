// SPDX-License-Identifier: Apache-2.0
#include "lib/device/vertex_counts.h"

#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;

Solver make_solver(const SpareRoom& spare) {
  SolverOptions options = pbdsurg::testing::vertex_options();
  options.executor = pbdsurg::testing::fake_device();
  options.spare = spare;
  return Solver(pbdsurg::testing::make_bar(pbdsurg::testing::neo_hookean(1e4F, 0.4F), {12, 5, 5}),
                options);
}

}  // namespace

// Would catch memory that nobody asked for, and arrays that each edit outgrows.
TEST_CASE("vertex counts: there is room where it is asked for, or was needed before", "[unit]") {
  const Solver plain = make_solver({});
  const SolverData& data = inspect(plain);
  const VertexCounts counts(data);
  REQUIRE(counts.blocks > 20);
  REQUIRE(counts.places == data.particles.size());
  REQUIRE(counts.springs == 0);

  const VertexCounts exact = with_room(counts, data, false);
  CHECK(counts.has_room_for(exact));
  const VertexCounts grown = with_room(counts, data, true);
  CHECK(grown.blocks >= counts.blocks + counts.blocks / 8);
  CHECK(grown.volumes >= counts.volumes + counts.volumes / 8);
  CHECK(grown.places > counts.places);
  CHECK(grown.springs == 0);
  const Solver spacious = make_solver({100, 600, 800, 0});
  const VertexCounts asked = with_room(counts, inspect(spacious), false);
  CHECK(asked.places == counts.places + 100);
  CHECK(asked.blocks > counts.blocks + 100 / kBlockLanes);
  CHECK(asked.springs == 0);
}

// Would catch rips that a device has no room for.
TEST_CASE("vertex counts: there is room for triangles of sheets", "[unit]") {
  const auto mesh = pbdsurg::testing::make_sheet({12, 10}, 4e-3);
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles);
  SolverOptions options = pbdsurg::testing::vertex_options();
  options.executor = pbdsurg::testing::fake_device();
  options.spare = {60, 0, 0, 0};
  Solver solver(scene, options);
  const SolverData& data = inspect(solver);
  const VertexCounts counts(data);
  REQUIRE(counts.triangles > 0);
  const VertexCounts room = with_room(counts, data, false);
  CHECK(room.triangles > counts.triangles);
  CHECK(room.volumes == 0);
  CHECK(with_room(counts, data, true).triangles >= counts.triangles + counts.triangles / 8);
  for (Index round = 0; round < 40; ++round) {
    solver.tissue().apply(pbdsurg::testing::rip_vertex(solver, 20 + 2 * round));
  }
  CHECK_FALSE(counts.has_room_for(VertexCounts(data)));
  CHECK(room.has_room_for(VertexCounts(data)));
}

// Would catch cuts through tissue with fibres that a device has no room for.
TEST_CASE("vertex counts: there is room for fibres", "[unit]") {
  Scene scene = pbdsurg::testing::make_bar(pbdsurg::testing::neo_hookean(1e4F, 0.4F), {12, 5, 5});
  scene.set_fibres(0, std::vector<Fibre>(scene.tets().size(), {{1, 0, 0}, 1e4F}));
  SolverOptions options = pbdsurg::testing::vertex_options();
  options.executor = pbdsurg::testing::fake_device();
  options.spare = {100, 600, 800, 0};
  Solver solver(scene, options);
  const SolverData& data = inspect(solver);
  const VertexCounts counts(data);
  REQUIRE(counts.has_rare_rows());
  CHECK_FALSE(VertexCounts(inspect(make_solver({}))).has_rare_rows());
  const VertexCounts room = with_room(counts, data, false);
  CHECK(with_room(counts, data, true).fibres >= counts.fibres + counts.fibres / 8);
  for (std::uint64_t round = 0; round < 30; ++round) {
    solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
  }
  CHECK(VertexCounts(data).fibres > counts.fibres);
  CHECK(room.has_room_for(VertexCounts(data)));
}

// Would catch words that are written beyond an array, after an undo has made it shorter.
TEST_CASE("vertex counts: what an undo takes back keeps its room", "[unit]") {
  Solver solver = make_solver({});
  const SolverData& data = inspect(solver);
  const VertexCounts before(data);
  VertexCounts most = before;
  for (std::uint64_t round = 0; round < 8; ++round) {
    solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
    most.include(VertexCounts(data));
  }
  const VertexCounts after(data);
  CHECK_FALSE(before.has_room_for(after));
  solver.tissue().undo();
  most.include(VertexCounts(data));
  CHECK(most.has_room_for(after));
  CHECK(most.has_room_for(VertexCounts(data)));
}

}  // namespace pbdsurg::cuda
