// SPDX-License-Identifier: Apache-2.0
// Stages are made, and follow edits, on the host: what is here needs no device.
#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/fake_device.h"
#include "tests/support/host_stages.h"
#include "tests/support/inspect.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;
using pbdsurg::testing::Variant;
using testing::have_serial_bits;
using testing::HostStages;
using testing::stretch;

// In a stage, or in a level of it, no vertex is two constraints'.
template <class Record>
void check_independent(std::span<const Record> records) {
  std::vector<Index> places;
  for (const Record& record : records) {
    places.insert(places.end(), std::begin(record.places), std::end(record.places));
  }
  std::ranges::sort(places);
  CHECK(std::ranges::adjacent_find(places) == places.end());
}

}  // namespace

TEST_CASE("cuda stages: a sweep by stages has the serial bits, and after edits, too",
          "[equivalence]") {
  const Variant variant = GENERATE(from_range(testing::plan_variants()));
  INFO("mode " << static_cast<int>(variant.mode) << ", composition "
               << static_cast<int>(variant.composition) << ", at most " << variant.max_colors
               << " colors, damping " << variant.damping);
  SolverOptions options = pbdsurg::testing::options_of(variant);
  options.executor = pbdsurg::testing::fake_device();
  Solver solver(pbdsurg::testing::make_eventful_scene(variant.mode, variant.damping), options);
  SolverData& data = inspect(solver);
  stretch(solver);
  HostStages stages(data);
  REQUIRE(have_serial_bits(stages, data));

  int rebuilt = 0;
  const auto follow = [&] {
    std::vector<WordChange> words;
    if (stages.plan.follow(data, data.changes, words)) {
      CHECK(words.size() < 60 * (data.changes.constraints.size() + data.changes.tets.size()));
      stages.write(words);
    } else {
      stages = HostStages(data);
      ++rebuilt;
    }
    REQUIRE(have_serial_bits(stages, data));
    data.changes.clear();
  };
  data.changes.clear();
  for (Index round = 0; round < 30; ++round) {
    INFO("round " << round);
    const TopologyEdit edit = pbdsurg::testing::eventful_edit(solver, round);
    const TissueChange result = solver.tissue().apply(edit);
    follow();
    if (round % 3 == 1) {
      solver.tissue().undo();
      follow();
    }
  }
  CHECK((rebuilt > 0) == (variant.max_colors > 0));

  // more links at a vertex than colours: some are new
  TopologyEdit growth;
  for (Index v = 0; v < solver.vertex_count() && growth.new_links.size() < 40; ++v) {
    if (v != 1 && solver.tissue().has_tissue(1) && solver.tissue().has_tissue(v)) {
      growth.new_links.push_back({1, v, 3e-3F, {.fraction = 0.3F, .compliance = 1e-6F}});
    }
  }
  REQUIRE(growth.new_links.size() == 40);
  solver.tissue().apply(growth);
  stages = HostStages(data);
  CHECK(have_serial_bits(stages, data));
  Index alive = 0;
  for (const TubeRecord& tube : stages.records.tubes) {
    alive += tube.places[0] >= 0;
  }
  Index expected = 0;
  for (Index t = solver.tissue().body(1).first_tet; t < solver.tissue().body(2).first_tet; ++t) {
    expected += solver.tissue().is_tet_alive(t);
  }
  CHECK(alive == expected);
}

// Would catch domains that are launched one after another, as a CPU takes them.
TEST_CASE("cuda stages: domains of one level are one stage, a serial phase is cut into levels",
          "[unit]") {
  const TetMesh mesh = pbdsurg::testing::make_box({28, 21, 19}, 4e-3, 0.1);  // four domains
  Scene scene;
  scene.add_body("block", mesh, pbdsurg::testing::kSprings);
  SolverOptions options = pbdsurg::testing::small_steps(
      {.executor = executor::serial(), .composition = PlanComposition::nested});
  options.coloring.max_colors = GENERATE(0, 12);
  options.coloring.repair = options.coloring.max_colors == 0;
  Solver solver(scene, options);
  SolverData& data = inspect(solver);
  stretch(solver);
  HostStages stages(data);
  std::map<std::pair<Index, PhaseKind>, Index> most;  // phases of a level and kind in a domain
  std::map<std::tuple<Index, PhaseKind, Index>, Index> phases;
  for (const Phase& phase : data.plan.phases) {
    Index& count = phases[{phase.level, phase.kind, phase.domain}];
    most[{phase.level, phase.kind}] = std::max(most[{phase.level, phase.kind}], ++count);
  }
  std::size_t expected = 0;
  for (const auto& [key, count] : most) {
    expected += static_cast<std::size_t>(count);
  }
  CHECK(stages.plan.stages().size() <= expected + most.size());
  CHECK(stages.plan.stages().size() < data.plan.phases.size() / 2);
  for (const Stage& stage : stages.plan.stages()) {
    Index first = stage.first;
    for (Index level = 0; level < std::max<Index>(1, stage.level_count); ++level) {
      const Index end = stage.level_count == 0
                            ? stage.first + stage.count
                            : stages.records.level_ends[stage.first_level + level];
      const auto part = [&](const auto& records) {
        return std::span(records).subspan(static_cast<std::size_t>(first),
                                          static_cast<std::size_t>(end - first));
      };
      if (stage.kind == PhaseKind::distance) {
        check_independent(part(stages.records.of<DistanceConstraint>()));
      } else {
        check_independent(part(stages.records.of<VolumeConstraint>()));
      }
      first = end;
    }
  }
  CHECK(have_serial_bits(stages, data));
}

}  // namespace pbdsurg::cuda
