// SPDX-License-Identifier: Apache-2.0
// Stages of scenes with sheets, made and followed on the host: what is here needs no device.
#include <algorithm>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/fake_device.h"
#include "tests/support/host_stages.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;
using testing::have_serial_bits;
using testing::HostStages;
using testing::stretch;

constexpr double kEdge = 4e-3;  // m

// Two sheets, and tetrahedra that hang on one of them by links.
Scene make_scene(float damping) {
  const auto sheet = pbdsurg::testing::make_sheet({9, 7}, kEdge, 0.2);
  const auto disc = pbdsurg::testing::make_disc(3, 3 * kEdge);
  Scene scene;
  scene.add_sheet("sheet", sheet.positions, sheet.triangles, {.damping = damping});
  scene.add_body("block", pbdsurg::testing::make_box({3, 2, 2}, kEdge, 0.1),
                 {.model = ElasticModel::neo_hookean, .damping = damping});
  scene.add_sheet("disc", disc.positions, disc.triangles, {.damping = damping});
  for (Index i = 0; i < 4; ++i) {
    scene.add_link({12 + i, scene.body(1).first_vertex + i, 2e-3F, {0.5F, 1e-3F}});
  }
  return scene;
}

}  // namespace

// Would catch triangles that no stage projects, or one that shares vertices with another of its
// stage, records that an edit changes and nobody writes, and parameters in another order.
TEST_CASE("cuda sheets: a sweep by stages has the serial bits, and after edits, too",
          "[equivalence]") {
  const float damping = GENERATE(0.0F, 2e-3F);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  const int max_colors = GENERATE(0, 5);
  SolverOptions options = pbdsurg::testing::small_steps(
      {.executor = pbdsurg::testing::fake_device(), .composition = composition});
  options.coloring.max_colors = max_colors;
  options.coloring.repair = max_colors == 0;
  Solver solver(make_scene(damping), options);
  SolverData& data = inspect(solver);
  stretch(solver);
  HostStages stages(data);
  data.changes.clear();
  REQUIRE(have_serial_bits(stages, data));
  const auto count_alive = [&] {
    return std::ranges::count_if(stages.records.of<MembraneConstraint>(),
                                 [](const auto& record) { return record.places[0] >= 0; });
  };
  const auto triangle_count = static_cast<Index>(solver.tissue().triangles().size());
  REQUIRE(count_alive() == triangle_count);
  int made_anew = 0;
  const auto follow = [&] {
    std::vector<WordChange> words;
    if (stages.plan.follow(data, data.changes, words)) {
      stages.write(words);
    } else {
      stages = HostStages(data, true);
      ++made_anew;
    }
    REQUIRE(have_serial_bits(stages, data));
    Index alive = 0;
    for (Index t = 0; t < triangle_count; ++t) {
      alive += solver.tissue().is_triangle_alive(t) ? 1 : 0;
    }
    REQUIRE(count_alive() == alive);
    data.changes.clear();
  };
  for (Index round = 0; round < 24; ++round) {
    INFO("round " << round);
    const TissueChange result =
        solver.tissue().apply(round % 2 == 0 ? TopologyEdit{.remove_triangles = {7 * round}}
                                             : pbdsurg::testing::rip_vertex(solver, 11 + round));
    follow();
    if (round % 3 == 1) {
      solver.tissue().undo();
      follow();
    }
  }
  if (max_colors == 0) {  // else serial stages make all anew
    CHECK(made_anew <= 2);
  }
}

}  // namespace pbdsurg::cuda
