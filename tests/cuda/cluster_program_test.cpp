// SPDX-License-Identifier: Apache-2.0
// Programs of clusters are made, and follow edits, on the host: what is here needs no device.
#include "solver/cluster_program.h"

#include <algorithm>
#include <bit>
#include <map>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "solver/solver_data.h"
#include "support/catch.h"
#include "support/eventful_program.h"

namespace pbdsurg::cuda {
namespace {

/// A constraint without regard to where it lies.
struct Plain {
  std::vector<Index> places;
  std::vector<std::uint32_t> numbers;
  bool operator==(const Plain&) const = default;
  auto operator<=>(const Plain&) const = default;
};
using PhaseContents = std::map<Index, std::vector<Plain>>;  // by phase, sorted

std::uint32_t bits(float value) {
  return std::bit_cast<std::uint32_t>(value);
}

std::uint32_t number(const Word128& word, Index i) {
  const std::uint32_t numbers[] = {word.x, word.y, word.z, word.w};
  return numbers[i];
}

// What a kernel reads.
PhaseContents unpack(const ClusterProgram& program, bool is_damped) {
  PhaseContents contents;
  for (std::size_t b = 0; b < program.blocks.size(); ++b) {
    const ClusterBlock& block = program.blocks[b];
    for (std::uint32_t r = 0; r < block.round_count; ++r) {
      const ClusterRound& round = program.rounds[block.first_round + r];
      const auto kind = static_cast<PhaseKind>(round.kind);
      const bool is_pair = kind == PhaseKind::distance || kind == PhaseKind::strain_limit;
      const Index corners = is_pair ? 2 : 4;
      const Index parameters = kind == PhaseKind::distance       ? 2
                               : kind == PhaseKind::strain_limit ? 1
                               : kind == PhaseKind::volume       ? (is_damped ? 3 : 2)
                                                                 : 12;
      for (std::uint32_t i = 0; i < round.count; ++i) {
        const Word128& head = program.words[round.first + i];
        Plain plain;
        for (Index corner = 0; corner < corners; ++corner) {
          const std::uint32_t half = number(head, corner / 2) >> (16 * (corner % 2)) & 0xffff;
          plain.places.push_back(program.places[block.first_place + (half & kSlotMask)]);
          if ((half & kLeaves) != 0) {
            REQUIRE(i < round.border);
            const std::uint32_t target =
                number(program.words[round.first + round.words * round.count + i], corner);
            const ClusterBlock& there = program.blocks[target >> 28];
            CHECK(program.places[there.first_place + (target & 0xffff)] == plain.places.back());
            CHECK((target >> 28) != b);
          }
        }
        for (Index p = 0; p < parameters; ++p) {
          const Index at = p + 2;
          plain.numbers.push_back(number(
              program.words[round.first + i + static_cast<std::uint32_t>(at / 4) * round.count],
              at % 4));
        }
        contents[round.phase].push_back(plain);
      }
    }
  }
  for (auto& [phase, constraints] : contents) {
    std::ranges::sort(constraints);
  }
  return contents;
}

PhaseContents expected_contents(std::span<const Stage> stages, const StageRecords& records,
                                bool is_damped) {
  PhaseContents contents;
  for (std::size_t s = 0; s < stages.size(); ++s) {
    auto& constraints = contents[static_cast<Index>(s)];
    for (Index i = stages[s].first; i < stages[s].first + stages[s].count; ++i) {
      Plain plain;
      const auto take = [&](const auto& record, std::initializer_list<float> numbers) {
        plain.places.assign(std::begin(record.places), std::end(record.places));
        std::ranges::transform(numbers, std::back_inserter(plain.numbers), bits);
      };
      switch (stages[s].kind) {
        case PhaseKind::distance:
          take(records.distances[i], {records.distances[i].rest, records.distances[i].stiffness});
          break;
        case PhaseKind::volume:
          take(records.volumes[i], {records.volumes[i].rest, records.volumes[i].stiffness});
          if (is_damped) {
            plain.numbers.push_back(bits(records.volumes[i].damping));
          }
          break;
        case PhaseKind::neo_hookean:
          take(records.neo_hookeans[i], {});
          std::ranges::transform(records.neo_hookeans[i].parameters,
                                 std::back_inserter(plain.numbers), bits);
          break;
        default:
          take(records.strain_limits[i], {records.strain_limits[i].limit});
          break;
      }
      constraints.push_back(plain);
    }
    std::ranges::sort(constraints);
  }
  return contents;
}

}  // namespace

// Would catch a constraint that is lost or packed in another way than kernels unpack it, and a
// change of a record that does not reach the program.
TEST_CASE("cluster program: it holds the records of its stages, and follows them") {
  const int block_count = GENERATE(1, 4, 16);
  const bool is_damped = GENERATE(false, true);
  const Scene scene =
      pbdsurg::testing::make_eventful_scene(ProjectionMode::compliance, is_damped ? 0.01F : 0);
  SolverOptions options{.backend = BackendKind::serial};
  options.composition = PlanComposition::separate;
  Solver solver(scene, options);
  const SolverData& data = solver_data(solver);
  StageRecords records;
  const StagePlan plan(data, records);
  ClusterRecords cluster;
  auto program =
      cluster.make_program(plan.stages(), records, scene.vertex_count(), block_count, is_damped);
  REQUIRE(program);
  CHECK(unpack(*program, is_damped) == expected_contents(plan.stages(), records, is_damped));

  // as the backend changes records
  std::vector<WordChange> changes;
  const auto change = [&](DeviceArray array, auto& record, Index index, float& field, float value) {
    const auto word = (reinterpret_cast<char*>(&field) - reinterpret_cast<char*>(&record)) / 4;
    field = value;
    changes.push_back(
        {array, static_cast<std::uint32_t>(index * static_cast<Index>(sizeof record / 4) + word),
         bits(value)});
  };
  change(DeviceArray::distances, records.distances[7], 7, records.distances[7].rest, 0.25F);
  change(DeviceArray::volumes, records.volumes[3], 3, records.volumes[3].stiffness, 0.5F);
  change(DeviceArray::volumes, records.volumes[4], 4, records.volumes[4].damping, 0.75F);
  change(DeviceArray::strain_limits, records.strain_limits[1], 1, records.strain_limits[1].limit,
         2);
  for (int p = 0; p < NeoHookeanConstraint::kParameterCount; ++p) {
    auto& record = records.neo_hookeans[5];
    change(DeviceArray::neo_hookeans, record, 5, record.parameters[p],
           3.0F + static_cast<float>(p));
  }
  changes.push_back({DeviceArray::tubes, 0, 1});  // of no sweep
  std::vector<WordChange> words;
  cluster.follow(changes, words);
  for (const WordChange& word : words) {
    REQUIRE(word.array == DeviceArray::cluster);
    reinterpret_cast<std::uint32_t*>(program->words.data())[word.word] = word.value;
  }
  CHECK(unpack(*program, is_damped) == expected_contents(plan.stages(), records, is_damped));

  words.clear();
  const WordChange removal{DeviceArray::volumes, 2 * sizeof(VolumeRecord) / 4,
                           static_cast<std::uint32_t>(kInvalidIndex)};
  cluster.follow({&removal, 1}, words);
  REQUIRE(words.size() == 1);
  CHECK(words[0].value == kRemovedConstraint);
  reinterpret_cast<std::uint32_t*>(program->words.data())[words[0].word] = words[0].value;
  const VolumeRecord removed = records.volumes[2];
  records.volumes[2].rest = std::bit_cast<float>(kRemovedConstraint);
  CHECK(unpack(*program, is_damped) == expected_contents(plan.stages(), records, is_damped));

  records.volumes[2] = removed;  // it comes back, by all its words
  changes.clear();
  for (std::uint32_t w = 0; w < sizeof removed / 4; ++w) {
    std::uint32_t value = 0;
    std::memcpy(&value, reinterpret_cast<const char*>(&removed) + 4 * w, 4);
    changes.push_back({DeviceArray::volumes, 2 * std::uint32_t{sizeof removed / 4} + w, value});
  }
  words.clear();
  cluster.follow(changes, words);
  for (const WordChange& word : words) {
    reinterpret_cast<std::uint32_t*>(program->words.data())[word.word] = word.value;
  }
  CHECK(unpack(*program, is_damped) == expected_contents(plan.stages(), records, is_damped));
}

TEST_CASE("cluster program: serial and joint stages have none") {
  const Scene scene = pbdsurg::testing::make_eventful_scene(ProjectionMode::compliance, 0);
  SolverOptions options{.backend = BackendKind::serial};
  const bool is_joint = GENERATE(true, false);
  options.composition = is_joint ? PlanComposition::joint : PlanComposition::separate;
  options.coloring.max_colors = is_joint ? 0 : 5;
  Solver solver(scene, options);
  StageRecords records;
  const StagePlan plan(solver_data(solver), records);
  CHECK(!ClusterRecords().make_program(plan.stages(), records, scene.vertex_count(), 4, false));
}

}  // namespace pbdsurg::cuda
