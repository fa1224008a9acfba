// SPDX-License-Identifier: Apache-2.0
// Programs of clusters are made, and follow edits, on the host: what is here needs no device.
#include "lib/device/cluster_program.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/cluster_machine.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/random_plan.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/toy_sweep.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::inspect;
using testing::ClusterMachine;
using testing::ToyValue;

/// The image on a device, which gets no more than what changes.
void write(std::vector<std::uint32_t>& image, std::span<const WordChange> words) {
  std::set<std::uint32_t> written;
  for (const WordChange& word : words) {
    REQUIRE(word.array == DeviceArray::cluster);
    REQUIRE(word.word < image.size());
    REQUIRE(written.insert(word.word).second);  // they are written in any order
    image[word.word] = word.value;
  }
}

/// Runs a program in some order that its barriers allow, against the order of the plan.
void check_sweeps(std::span<const Stage> stages, StageRecords& records, Index place_count,
                  const ClusterProgram& program, const std::vector<std::uint32_t>& image,
                  bool is_damped, std::uint64_t seed) {
  constexpr int kSweeps = 3;
  std::vector<ToyValue> expected(static_cast<std::size_t>(place_count));
  for (std::size_t place = 0; place < expected.size(); ++place) {
    expected[place] = testing::mix(place + 1);
  }
  std::vector<ToyValue> values = expected;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    testing::sweep_toy(stages, records, expected, is_damped);
  }
  const std::string failure =
      ClusterMachine(program.sizes(), image, is_damped).sweep(values, kSweeps, seed);
  REQUIRE(failure == "");
  REQUIRE(values == expected);
}

struct Case {
  Index place_count, per_stage, spare;
  int block_count;
  bool is_damped;
};

}  // namespace

// Would catch a constraint that is lost or packed in another way than kernels unpack it, and a
// change of a record that does not reach the program.
TEST_CASE("cluster program: it sweeps as its stages, and follows their records") {
  const int block_count = GENERATE(1, 4, 16);
  const bool is_damped = GENERATE(false, true);
  Scene scene =
      pbdsurg::testing::make_eventful_scene(ProjectionMode::compliance, is_damped ? 0.01F : 0);
  const auto sheet = pbdsurg::testing::make_sheet({5, 4}, 4e-3, 0.2);
  scene.add_sheet("sheet", sheet.positions, sheet.triangles);
  pbdsurg::testing::give_solid_fibres(scene);
  SolverOptions options = pbdsurg::testing::small_steps({.executor = executor::serial()});
  options.composition = PlanComposition::separate;
  Solver solver(scene, options);
  StageRecords records;
  const StagePlan plan(inspect(solver), records);
  auto program = ClusterProgram::make(plan.stages(), records, scene.vertex_count(),
                                      std::vector<PlaceRun>{{0, scene.vertex_count()}}, block_count,
                                      is_damped, GrowthRoom::none);
  REQUIRE(program);
  std::vector<std::uint32_t> image(program->image().begin(), program->image().end());
  const auto check = [&] {
    check_sweeps(plan.stages(), records, scene.vertex_count(), *program, image, is_damped, 7);
  };
  check();

  // as the backend changes records
  std::vector<WordChange> changes;
  const auto follow = [&] {
    const std::size_t count = changes.size();
    REQUIRE(program->follow(changes, scene.vertex_count()));
    const std::span<const WordChange> words = std::span(changes).subspan(count);
    const auto word_count = static_cast<int>(words.size());
    write(image, words);
    changes.clear();
    check();
    return word_count;
  };
  const auto change = [&](DeviceArray array, auto& record, Index index, float& field, float value) {
    const auto word = (reinterpret_cast<char*>(&field) - reinterpret_cast<char*>(&record)) / 4;
    field = value;
    changes.push_back(
        {array, static_cast<std::uint32_t>(index * static_cast<Index>(sizeof record / 4) + word),
         std::bit_cast<std::uint32_t>(value)});
  };
  change(DeviceArray::distances, records.of<DistanceConstraint>()[7], 7,
         records.of<DistanceConstraint>()[7].parameters[DistanceConstraint::kRest], 0.25F);
  change(DeviceArray::distance_damping, records.distance_damping[8], 8, records.distance_damping[8],
         0.125F);
  change(DeviceArray::volumes, records.of<VolumeConstraint>()[3], 3,
         records.of<VolumeConstraint>()[3].parameters[VolumeConstraint::kStiffness], 0.5F);
  change(DeviceArray::volumes, records.of<VolumeConstraint>()[4], 4,
         records.of<VolumeConstraint>()[4].parameters[VolumeConstraint::kDamping], 0.75F);
  change(DeviceArray::strain_limits, records.of<StrainLimitConstraint>()[1], 1,
         records.of<StrainLimitConstraint>()[1].parameters[StrainLimitConstraint::kLimit], 2);
  for (int p = 0; p < NeoHookeanConstraint::kParameterCount; ++p) {
    auto& record = records.of<NeoHookeanConstraint>()[5];
    change(DeviceArray::neo_hookeans, record, 5, record.parameters[p],
           3.0F + static_cast<float>(p));
  }
  for (int p = 0; p < MembraneConstraint::kParameterCount; ++p) {
    auto& record = records.of<MembraneConstraint>()[6];
    change(DeviceArray::membranes, record, 6, record.parameters[p], 5.0F + static_cast<float>(p));
  }
  for (int p = 0; p < FibreConstraint::kParameterCount; ++p) {
    auto& record = records.of<FibreConstraint>()[8];
    change(DeviceArray::fibres, record, 8, record.parameters[p], 7.0F + static_cast<float>(p));
  }
  changes.push_back({DeviceArray::tubes, 0, 1});  // of no sweep
  CHECK(follow() == 4 + (is_damped ? 1 : 0) + NeoHookeanConstraint::kParameterCount +
                        MembraneConstraint::kParameterCount + FibreConstraint::kParameterCount);

  const Record<VolumeConstraint> removed = records.of<VolumeConstraint>()[2];
  records.of<VolumeConstraint>()[2].places[0] = kInvalidIndex;
  changes.push_back({DeviceArray::volumes, 2 * sizeof(Record<VolumeConstraint>) / 4,
                     static_cast<std::uint32_t>(kInvalidIndex)});
  CHECK(follow() == 1);  // it lets its vertices pass

  records.of<VolumeConstraint>()[2] = removed;  // it comes back, by all its words
  const auto numbers = testing::numbers_of(records, PhaseKind::volume, 2);
  for (std::uint32_t w = 0; w < numbers.size(); ++w) {
    changes.push_back(
        {DeviceArray::volumes, 2 * std::uint32_t{sizeof removed / 4} + w, numbers[w]});
  }
  CHECK(follow() == 1);
}

TEST_CASE("cluster program: serial and joint stages have none") {
  const Scene scene = pbdsurg::testing::make_eventful_scene(ProjectionMode::compliance, 0);
  SolverOptions options = pbdsurg::testing::small_steps({.executor = executor::serial()});
  const bool is_joint = GENERATE(true, false);
  options.composition = is_joint ? PlanComposition::joint : PlanComposition::separate;
  options.coloring.max_colors = is_joint ? 0 : 5;
  Solver solver(scene, options);
  StageRecords records;
  const StagePlan plan(inspect(solver), records);
  CHECK(!ClusterProgram::make(plan.stages(), records, scene.vertex_count(),
                              std::vector<PlaceRun>{{0, scene.vertex_count()}}, 4, false,
                              GrowthRoom::ample));
}

// Would catch a vertex that is sent to the wrong place or phase, a wait for more or less than what
// comes, blocks that wait for each other for ever, and words that do not reach the device, after
// any sequence of edits; also that a program is made anew where it could follow.
TEST_CASE("cluster program: after edits, blocks in any order do what the plan says", "[long]") {
  const Case how = GENERATE(Case{120, 12, 12, 4, false}, Case{400, 40, 20, 16, true},
                            Case{400, 40, 0, 16, false}, Case{90, 10, 40, 2, true},
                            Case{3000, 470, 30, 1, false}, Case{1500, 180, 60, 3, true});
  INFO(how.block_count << " blocks, " << how.place_count << " vertices, " << how.spare
                       << " spare records a stage");
  const GrowthRoom room =
      how.spare == 0 ? GrowthRoom::none : GENERATE(GrowthRoom::some, GrowthRoom::ample);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    testing::RandomPlan plan(how.place_count, how.per_stage, how.spare, seed);
    const auto make = [&] {
      return ClusterProgram::make(
          plan.stages, plan.records, plan.place_count(),
          std::vector<PlaceRun>{{0, std::min(how.place_count, plan.place_count())}},
          how.block_count, how.is_damped, room);
    };
    auto program = make();
    REQUIRE(program);
    std::vector<std::uint32_t> image(program->image().begin(), program->image().end());
    check_sweeps(plan.stages, plan.records, plan.place_count(), *program, image, how.is_damped,
                 seed);
    int followed = 0;
    constexpr int kEdits = 20;
    for (int e = 0; e < kEdits; ++e) {
      INFO("seed " << seed << ", edit " << e);
      std::vector<WordChange> changes = plan.edit(1 + e * 2);
      const std::size_t count = changes.size();
      if (program->follow(changes, plan.place_count())) {
        ++followed;
        write(image, std::span(changes).subspan(count));
        REQUIRE(std::ranges::equal(image, program->image()));
      } else {
        program = make();
        REQUIRE(program);
        image.assign(program->image().begin(), program->image().end());
      }
      check_sweeps(plan.stages, plan.records, plan.place_count(), *program, image, how.is_damped,
                   seed + static_cast<std::uint64_t>(e));
    }
    CHECK((room == GrowthRoom::none || followed > kEdits - 3));
  }
}

}  // namespace pbdsurg::cuda
