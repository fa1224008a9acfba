// SPDX-License-Identifier: Apache-2.0
// Stages of tissue with fibres, made and followed on the host: what is here needs no device.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/fake_device.h"
#include "tests/support/host_stages.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;
using testing::have_serial_bits;
using testing::HostStages;
using testing::stretch;

// A block with fibres in two thirds of its tetrahedra.
Scene make_scene() {
  Scene scene;
  scene.add_body("block", pbdsurg::testing::make_box({5, 4, 3}, 4e-3, 0.1),
                 {.model = ElasticModel::neo_hookean});
  std::vector<Fibre> fibres(scene.tets().size());
  for (std::size_t t = 0; t < fibres.size(); ++t) {
    fibres[t] = {{0.6F, 0, 0.8F}, t % 3 == 0 ? 0.0F : 20e3F};
  }
  scene.set_fibres(0, fibres);
  return scene;
}

}  // namespace

// Would catch fibres that no stage projects, or one that shares vertices with another of its stage,
// records that an edit changes and nobody writes, and parameters in another order.
TEST_CASE("cuda fibres: a sweep by stages has the serial bits, and after edits, too",
          "[equivalence]") {
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  const int max_colors = GENERATE(0, 5);
  SolverOptions options = pbdsurg::testing::small_steps(
      {.executor = pbdsurg::testing::fake_device(), .composition = composition});
  options.coloring.max_colors = max_colors;
  options.coloring.repair = max_colors == 0;
  Solver solver(make_scene(), options);
  SolverData& data = inspect(solver);
  stretch(solver);
  HostStages stages(data);
  data.changes.clear();
  REQUIRE(have_serial_bits(stages, data));
  const auto count_records = [&] {
    return std::ranges::count_if(stages.records.of<FibreConstraint>(),
                                 [](const auto& record) { return record.places[0] >= 0; });
  };
  const auto count_fibres = [&] {
    Index count = 0;
    for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
      count += solver.tissue().is_tet_alive(t) && solver.tissue().fibre(t).stiffness > 0 ? 1 : 0;
    }
    return count;
  };
  REQUIRE(count_records() == count_fibres());
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
    REQUIRE(count_records() == count_fibres());
    data.changes.clear();
  };
  for (Index round = 0; round < 24; ++round) {
    INFO("round " << round);
    TopologyEdit edit;
    if (round % 3 == 0) {
      for (const Index t : {9 * round, 9 * round + 1}) {  // one without, one with some
        if (solver.tissue().is_tet_alive(t)) {
          edit.fibres.push_back({t, round % 2 == 0 ? Fibre{{0, 1, 0}, 40e3F} : Fibre{}});
        }
      }
    } else if (round % 3 == 1) {
      edit = pbdsurg::testing::part_vertex(solver, 20 + round, 1);
    } else {
      edit.remove_tets = {9 * round + 2};
    }
    const TissueChange result = solver.tissue().apply(edit);
    follow();
    if (round % 4 == 1) {
      solver.tissue().undo();
      follow();
    }
  }
  if (max_colors == 0) {  // else serial stages make all anew
    CHECK(made_anew <= 2);
  }
}

}  // namespace pbdsurg::cuda
