// SPDX-License-Identifier: Apache-2.0
// Stages that follow edits which bring constraints, on the host: what is here needs no device.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/device/cluster_program.h"
#include "lib/solver/solver_options.h"
#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/edit_maker.h"
#include "tests/support/edit_scenes.h"
#include "tests/support/fake_device.h"
#include "tests/support/host_stages.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::Choices;
using pbdsurg::testing::EditMaker;
using pbdsurg::testing::inspect;
using testing::have_serial_bits;
using testing::HostStages;
using testing::stretch;

using Words = std::vector<std::uint32_t>;

template <class Record>
Words words_of(const Record& record) {
  Words words(sizeof(Record) / sizeof(std::uint32_t));
  std::memcpy(words.data(), &record, sizeof record);
  return words;
}

template <class Record>
void add_contents(const std::vector<Record>& records, const Stage& stage,
                  std::vector<Words>& contents) {
  for (Index i = stage.first; i < stage.first + stage.count; ++i) {
    if (records[i].places[0] >= 0) {
      contents.push_back(words_of(records[i]));
    }
  }
}

// Of stages that do something, in their order: records that do something, in an order of their own.
// Tubes come last.
std::vector<std::vector<Words>> contents_of(const HostStages& stages) {
  const StageRecords& records = stages.records;
  std::vector<std::vector<Words>> all;
  const auto end = [&](std::vector<Words>& contents) {
    std::ranges::sort(contents);
    if (!contents.empty()) {
      all.push_back(std::move(contents));
    }
  };
  for (const Stage& stage : stages.plan.stages()) {
    std::vector<Words> contents;
    switch (stage.kind) {
      case PhaseKind::distance:
        add_contents(records.of<DistanceConstraint>(), stage, contents);
        for (Index i = stage.first, next = 0; i < stage.first + stage.count; ++i) {
          if (records.of<DistanceConstraint>()[i].places[0] >= 0) {
            contents[next++].push_back(words_of(records.distance_damping[i])[0]);
          }
        }
        break;
      case PhaseKind::volume:
        add_contents(records.of<VolumeConstraint>(), stage, contents);
        break;
      case PhaseKind::joint:
        add_contents(records.joints, stage, contents);
        break;
      case PhaseKind::neo_hookean:
        add_contents(records.of<NeoHookeanConstraint>(), stage, contents);
        break;
      case PhaseKind::fibre:
        add_contents(records.of<FibreConstraint>(), stage, contents);
        break;
      case PhaseKind::membrane:
        add_contents(records.of<MembraneConstraint>(), stage, contents);
        break;
      case PhaseKind::strain_limit:
        add_contents(records.of<StrainLimitConstraint>(), stage, contents);
        break;
      case PhaseKind::bending:
        add_contents(records.of<BendingConstraint>(), stage, contents);
        break;
      case PhaseKind::stiff_link:
        add_contents(records.of<StiffLinkConstraint>(), stage, contents);
        break;
      case PhaseKind::vertex:
      case PhaseKind::attachment:
      case PhaseKind::grip:
      case PhaseKind::contact:
      case PhaseKind::body_contact:
      case PhaseKind::custom:
        break;  // have no records
    }
    end(contents);
  }
  std::vector<Words> tubes;
  add_contents(records.tubes, {PhaseKind::volume, 0, static_cast<Index>(records.tubes.size())},
               tubes);
  end(tubes);
  return all;
}

// A device's words are written in no order.
bool are_alike_where_repeated(const std::vector<WordChange>& words) {
  std::map<std::pair<DeviceArray, std::uint32_t>, std::uint32_t> values;
  return std::ranges::all_of(words, [&](const WordChange& change) {
    return values.emplace(std::pair(change.array, change.word), change.value).first->second ==
           change.value;
  });
}

bool are_alike(const Stage& a, const Stage& b) {
  return a.kind == b.kind && a.first == b.first && a.count == b.count;
}

std::vector<Stage> vertex_stages(const HostStages& stages) {
  std::vector<Stage> found;
  std::ranges::copy_if(stages.plan.open_stages(), std::back_inserter(found),
                       [](const Stage& stage) { return stage.kind == PhaseKind::vertex; });
  return found;
}

/// Stages that follow a solver, made anew when they say so.
class StageFollower {
 public:
  explicit StageFollower(Solver& solver) : data_(inspect(solver)), stages_(data_) {
    data_.changes.clear();
  }

  /// @return  whether they are as if they were made of the data as it is now
  bool follow() {
    take_over();
    const HostStages fresh(data_);
    return contents_of(stages_) == contents_of(fresh) &&
           std::ranges::equal(vertex_stages(stages_), vertex_stages(fresh), are_alike) &&
           (moves_vertices(data_.options) || have_serial_bits(stages_, data_));
  }

  void take_over() {
    std::vector<WordChange> words;
    has_grown_ = has_grown_ || data_.changes.grown;
    const std::span<const Stage> all = stages_.plan.open_stages();
    const std::vector<Stage> before(all.begin(), all.end());
    const std::uint64_t revision = stages_.plan.revision();  // a recorded step goes by this
    if (stages_.plan.follow(data_, data_.changes, words)) {
      CHECK(are_alike_where_repeated(words));
      std::erase_if(words, [](const WordChange& change) {  // vertex_growth_test.cpp is about these
        return change.array >= DeviceArray::vertex_blocks;
      });
      CHECK(words.size() < 60 * (data_.changes.constraints.size() + data_.changes.tets.size() + 1));
      const std::span<const Stage> now = stages_.plan.open_stages();
      CHECK((stages_.plan.revision() != revision) == !std::ranges::equal(now, before, are_alike));
      has_opened = has_opened || now.size() > before.size();
      stages_.write(words);
      followed_growth += data_.changes.grown ? 1 : 0;
    } else {
      stages_ = HostStages(data_, has_grown_);
      ++made_anew;
    }
    data_.changes.clear();
  }

  int followed_growth = 0;
  int made_anew = 0;
  bool has_opened = false;  // a stage, without being made anew

 private:
  SolverData& data_;
  HostStages stages_;
  bool has_grown_ = false;
};

// A body with damping where the scene may have none, and a particle that hangs from it.
Scene make_guest(const Solver& solver, Choices& choices) {
  const std::string number = std::to_string(solver.tissue().bodies().size());
  const TetMesh mesh = pbdsurg::testing::make_box({2, 1, 1}, 4e-3, 0.1, 9);
  Material material = elastic_material(mesh, 900, 20e3);
  material.max_stretch = 1.1F;
  material.has_volume_constraints = choices.below(2) == 0;
  material.damping = choices.below(4) == 0 ? 1e-3F : 0;
  Scene guest;
  guest.add_body("guest " + number, mesh, material);
  guest.add_particles("bead " + number, std::vector<Eigen::Vector3d>{{0.01, 0.012, 0}}, 1e-5);
  guest.add_link({0, mesh.vertex_count(), 0.012F, {0.5F, 1e-3F}});
  return guest;
}

// A cut, other changes, links or a guest.
TopologyEdit make_stage_edit(const Solver& solver, Choices& choices) {
  const Index what = choices.below(8);
  if (what == 0) {
    return {.new_bodies = make_guest(solver, choices)};
  }
  EditMaker maker(solver, choices,
                  what < 4 ? pbdsurg::testing::make_cut(solver, {}, choices).edit : TopologyEdit{});
  for (Index more = choices.below(3); more > 0; --more) {
    maker.add();
  }
  if (choices.below(3) == 0) {
    maker.add_links();
  }
  maker.fix_some();
  return maker.edit();
}

}  // namespace

// Would catch what comes, moves or goes and is told nobody; records that two constraints share, or
// that stay behind; stages in another order than phases; and order in what a device writes at once.
TEST_CASE("cuda growth: stages that follow any edits and their undo are as if made anew",
          "[equivalence]") {
  constexpr std::uint64_t kTrials = 240;
  int followed_growth = 0;
  int made_anew = 0;
  for (std::uint64_t seed = 0; seed < kTrials; ++seed) {
    const std::vector<std::uint8_t> bytes = pbdsurg::testing::random_bytes(seed, 400);
    Choices choices(bytes);
    const auto& scene = choices.one_of(pbdsurg::testing::edit_scenes());
    SolverOptions options = choices.one_of(pbdsurg::testing::edit_options(scene));
    options.executor = pbdsurg::testing::fake_device();
    const Index spare = choices.one_of(std::array{0, 0, 20, 2000});
    options.spare = {spare, spare, spare, spare};
    INFO("seed " << seed << ", " << scene.name << ", composition "
                 << static_cast<int>(options.composition) << ", at most "
                 << options.coloring.max_colors << " colors, spare room " << spare);
    Solver solver(scene.scene, options);
    stretch(solver);
    StageFollower follower(solver);
    while (!choices.is_spent()) {
      const TopologyEdit edit = make_stage_edit(solver, choices);
      const TissueChange result = solver.tissue().apply(edit);
      if (choices.below(3) > 0) {
        REQUIRE(follower.follow());
      }
      if (choices.below(3) == 0) {
        solver.tissue().undo();
        if (choices.below(2) == 0) {
          REQUIRE(follower.follow());
        }
      }
    }
    REQUIRE(follower.follow());
    followed_growth += follower.followed_growth;
    made_anew += follower.made_anew;
  }
  CHECK(followed_growth > 400);
  CHECK(made_anew > 100);
}

namespace {

// Two layers of cells: groups are few, and full of what lies elsewhere.
Solver make_plate(PlanComposition composition, const SpareRoom& spare) {
  const TetMesh mesh = pbdsurg::testing::make_box({12, 10, 2}, 4e-3, 0.1);
  Material soft = elastic_material(mesh, 1000, 20e3);
  soft.max_stretch = 1.05F;
  Scene scene;
  scene.add_body("plate", mesh, soft);
  Solver solver(scene, pbdsurg::testing::small_steps({.executor = pbdsurg::testing::fake_device(),
                                                      .composition = composition,
                                                      .spare = spare}));
  stretch(solver);
  return solver;
}

}  // namespace

// Would catch growth that makes all anew each time, and room that grows by steps of one size.
TEST_CASE("cuda growth: a run of cuts makes stages anew a few times only", "[equivalence][long]") {
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  const Index spare = GENERATE(0, 1000);
  INFO("composition " << static_cast<int>(composition) << ", spare room " << spare);
  Solver solver = make_plate(composition, {spare, spare, spare, spare});
  StageFollower follower(solver);
  for (std::uint64_t round = 0; round < 120; ++round) {
    INFO("round " << round);
    solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
    REQUIRE(follower.follow());
  }
  CHECK(follower.made_anew >= (spare == 0 ? 1 : 0));
  CHECK(follower.made_anew < 10);
  CHECK(follower.followed_growth > 100);
  CHECK(follower.has_opened);
}

// Would catch records for the report alone that wait for a group of their own.
TEST_CASE("cuda growth: constraints beside vertex blocks find the records that were asked for",
          "[equivalence]") {
  const TetMesh mesh = pbdsurg::testing::make_box({12, 10, 2}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("plate", mesh, {.model = ElasticModel::neo_hookean});
  Solver solver(scene, pbdsurg::testing::small_steps({.method = SolverMethod::vertex_block,
                                                      .executor = pbdsurg::testing::fake_device(),
                                                      .spare = {200, 2000, 2000, 0}}));
  StageFollower follower(solver);
  for (std::uint64_t round = 0; round < 120; ++round) {
    INFO("round " << round);
    solver.tissue().apply(pbdsurg::testing::small_cut(solver, round));
    REQUIRE(follower.follow());
  }
  CHECK(follower.made_anew == 0);
  CHECK(follower.followed_growth > 100);
}

// Would catch records that an undo leaves behind.
TEST_CASE("cuda growth: undo gives records back", "[equivalence]") {
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  INFO("composition " << static_cast<int>(composition));
  Solver solver = make_plate(composition, {});
  StageFollower follower(solver);
  for (std::uint64_t round = 0; round < 4; ++round) {
    const int made_before = follower.made_anew;
    const TopologyEdit edit = pbdsurg::testing::small_cut(solver, round);
    INFO("round " << round);
    for (int again = 0; again < 400; ++again) {
      const TissueChange result = solver.tissue().apply(edit);
      follower.take_over();
      solver.tissue().undo();
      follower.take_over();
    }
    REQUIRE(follower.follow());
    CHECK(follower.made_anew <= made_before + 2);
  }
}

// Would catch words and multipliers of rounds that go for good when an undo empties them.
TEST_CASE("cuda growth: a cluster's program follows a cut and its undo again and again",
          "[equivalence][long]") {
  const auto room = GENERATE(GrowthRoom::some, GrowthRoom::ample);
  const float height = GENERATE(0.005F, 0.021F);
  Solver solver = make_plate(PlanComposition::separate, {2000, 4000, 8000, 0});
  SolverData& data = inspect(solver);
  const auto edge_at = [&](float at) { return BladeEdge{{at, height, -1}, {at, height, 1}}; };
  const TopologyEdit edit = plan_cut(solver, sweep_blade(std::array{edge_at(-1), edge_at(1)})).edit;
  REQUIRE(edit.new_tets.size() > 300);
  HostStages stages(data);
  auto program = ClusterProgram::make(stages.plan.stages(), stages.records, solver.vertex_count(),
                                      std::vector<PlaceRun>{{0, solver.vertex_count()}}, 16,
                                      data.sets.has_damping, room);
  REQUIRE(program);
  const auto follow = [&] {
    std::vector<WordChange> words;
    REQUIRE(stages.plan.follow(data, data.changes, words));
    REQUIRE(program->follow(words, solver.vertex_count()));
    data.changes.clear();
  };
  data.changes.clear();
  for (int again = 0; again < 100; ++again) {
    INFO("time " << again);
    const TissueChange result = solver.tissue().apply(edit);
    follow();
    solver.tissue().undo();
    follow();
  }
}

// Would catch spare records that nobody asked for, and such that do something.
TEST_CASE("cuda growth: stages have the spare records that were asked for, and no others",
          "[unit]") {
  const Index spare = GENERATE(0, 500);
  const Solver solver = make_plate(PlanComposition::separate, {spare, spare, spare, 0});
  const SolverData& data = inspect(solver);
  const HostStages stages(data);
  const auto check = [&](const auto& records, std::size_t count) {
    const auto works = [](const auto& record) { return record.places[0] >= 0; };
    CHECK(static_cast<std::size_t>(std::ranges::count_if(records, works)) == count);
    CHECK((records.size() > count) == (spare > 0));
    CHECK(records.size() >= count + static_cast<std::size_t>(spare));
  };
  check(stages.records.of<DistanceConstraint>(), solver.tissue().edges().size());
  check(stages.records.of<VolumeConstraint>(), solver.tissue().tets().size());
  check(stages.records.of<StrainLimitConstraint>(), solver.tissue().edges().size());
  CHECK(stages.records.distance_damping.size() == stages.records.of<DistanceConstraint>().size());
  const auto count_empty = [&](std::span<const Stage> all) {
    return std::ranges::count_if(all, [&](const Stage& stage) {
      return stage.kind == PhaseKind::volume &&
             stages.records.of<VolumeConstraint>()[stage.first].places[0] < 0;
    });
  };
  CHECK((count_empty(stages.plan.stages()) > 0) == (spare > 0));
  CHECK(count_empty(stages.plan.open_stages()) == 0);  // no sweep takes time for them
}

// Would catch a stage that nobody launches, because it was empty when the plan was made, although
// an undo brings its constraints back.
TEST_CASE("cuda growth: stages that were empty open for what an undo brings back",
          "[equivalence]") {
  Solver solver = make_plate(PlanComposition::separate, {100, 100, 100, 0});
  const auto& volumes = inspect(solver).sets.of<VolumeConstraint>();
  Index group = 0;  // a small one, for which there is room
  while (volumes.size(group) == 0 || volumes.size(group) > 20) {
    REQUIRE(++group < volumes.group_count());
  }
  const std::span<const Index> ids = volumes.ids(group);
  const TopologyEdit edit{.remove_tets = std::vector<Index>(ids.begin(), ids.end())};
  const TissueChange result = solver.tissue().apply(edit);
  StageFollower follower(solver);  // made now
  solver.tissue().undo();
  REQUIRE(follower.follow());
  CHECK(follower.made_anew == 0);
  CHECK(follower.has_opened);
}

// Would catch stages that take domains apart when constraints come that join two, and vertices that
// no domain has.
TEST_CASE("cuda growth: nested plans follow cuts", "[equivalence]") {
  const TetMesh mesh = pbdsurg::testing::make_box({28, 21, 19}, 4e-3, 0.1);  // four domains
  Scene scene;
  scene.add_body("block", mesh, pbdsurg::testing::kSprings);
  SolverOptions options = pbdsurg::testing::small_steps(
      {.executor = pbdsurg::testing::fake_device(), .composition = PlanComposition::nested});
  options.spare = {100, 1000, 2000, 100};
  Solver solver(scene, options);
  stretch(solver);
  REQUIRE(inspect(solver).sets.domain_counts.size() == 3);
  StageFollower follower(solver);
  for (std::uint64_t round = 0; round < 6; ++round) {
    INFO("round " << round);
    const TopologyEdit edit = pbdsurg::testing::small_cut(solver, round);
    const TissueChange result = solver.tissue().apply(edit);
    REQUIRE(follower.follow());
    if (round % 3 == 2) {
      solver.tissue().undo();
      REQUIRE(follower.follow());
    }
  }
  CHECK(follower.followed_growth > 5);
}

}  // namespace pbdsurg::cuda
