// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "tests/support/catch.h"
#include "tests/support/edit_trial.h"
#include "tests/support/fake_device.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {

using testing::EditScene;
using testing::EditTrial;

namespace {

// With each number replaced by 1.
std::string with_ones(const std::string& text) {
  std::string ones;
  for (const char letter : text) {
    const bool is_digit = letter >= '0' && letter <= '9';
    if (!is_digit || ones.empty() || ones.back() != '1') {
      ones += is_digit ? '1' : letter;
    }
  }
  return ones;
}

}  // namespace

// Would catch whatever an edit forgets, doubles or leaves behind, in any plan. scripts/soak goes on
// with other seeds.
TEST_CASE("edit equivalence: after any edits all is as if made of what is left", "[property]") {
  for (std::uint64_t seed = 0; seed < PBDSURG_EDIT_TRIALS; ++seed) {
    const std::string wrong =
        testing::run_edit_trial(testing::bytes_of_trial(seed), executor::serial());
    INFO("seed " << seed);
    REQUIRE(wrong == "");
  }
}

// Would catch the same, and what the steps between edits see of it, with threads and vector
// registers: each state is that of the serial backend, bit for bit, whether edits come between
// steps or within them.
TEST_CASE("edit equivalence: threads keep the serial bits through any edits", "[property]") {
  for (std::uint64_t seed = 0; seed < PBDSURG_EDIT_TRIALS / 10; ++seed) {
    const std::string wrong =
        testing::run_edit_trial(testing::bytes_of_trial(seed), executor::threads(2));
    INFO("seed " << seed);
    REQUIRE(wrong == "");
  }
}

// Would catch an edit of which a device does not hear, that its running step feels, or that reads
// what only the device has: each state is that of the serial backend, bit for bit.
TEST_CASE("edit equivalence: a device hears of any edits, within its steps, too", "[property]") {
  for (std::uint64_t seed = 0; seed < PBDSURG_EDIT_TRIALS / 20; ++seed) {
    const std::string wrong =
        testing::run_edit_trial(testing::bytes_of_trial(seed), testing::fake_device(), false);
    INFO("seed " << seed);
    REQUIRE(wrong == "");
  }
}

// Would catch a rule that no longer refuses what it is for, or that no bad edit tries; ^ is where a
// refusal begins.
TEST_CASE("edit equivalence: bad edits break each rule, and change nothing", "[property]") {
  std::set<std::string> rules{
      "^tet 1 does not exist; ids must be in",
      "^tet 1 was removed before",
      "^tet 1 is listed twice in one edit",
      "^edge 1 does not exist; ids must be in",
      "^edge 1 was removed before",
      "^edge 1 is listed twice in one edit",
      "^link 1 does not exist; ids must be in",
      "^link 1 was removed before",
      "^link 1 is listed twice in one edit",
      "^body 1 does not exist; ids must be in",
      "^body 1 was removed before",
      "^body 1 is listed twice in one edit",
      "^tet 1 is of body",
      "^new vertex 1 is of body",
      "^new tet 1 is of body",
      "^there is a body named",
      "is Neo-Hookean, which has moduli and no fraction",
      ": stretch compliance is",
      ": volume compliance is",
      "; it must be positive and finite",
      "belongs to a Neo-Hookean body",
      "belongs to a body without volume constraints",
      "; ids must be in",
      ", which no tetrahedron or triangle has",
      "of different bodies",
      ": the share is",
      ", which is no new copy of it",
      "tet 1 is moved twice",
      "link 1 is moved twice",
      "tet 1 is moved and removed",
      "link 1 is moved and removed",
      "has no corner at vertex",
      "has no end at vertex",
      "is moved or removed by the same edit",
      "refers to a vertex that does not exist",
      "has a vertex that is neither a corner of",
      "of the volume of tet",
      "they must fill it",
      "would have no tetrahedron or triangle",
      "^triangle 1 does not exist; ids must be in",
      "^triangle 1 is listed twice in one edit",
      "^triangle 1 is moved and removed",
      "^triangle 1 is moved twice",
      "^triangle 1 has no corner at vertex",
      "^triangle 1 cannot move from vertex",
      "to itself",
      "has rest length",
      ": fraction is",
      ": compliance is",
      ", which has no tissue left to hold it",
      "^a follower takes no edit",
      "^vertex 1 does not exist; ids must be in",
      "^vertex 1 is fixed already",
      "^vertex 1 is not fixed",
      "^link 1: the new rest length is",
      "times as stiff as its body's material",
      "which is not Neo-Hookean; only such tissue has moduli",
      ": the direction of its fibres has length",
      ": the stiffness of its fibres is",
      "cannot have fibres: only Neo-Hookean tetrahedra do",
  };
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const std::vector<std::uint8_t> bytes = testing::random_bytes(seed, 1000);
    testing::Choices choices(bytes);
    const EditScene& scene = choices.one_of(testing::edit_scenes());
    const std::vector<SolverOptions> options = testing::edit_options(scene);
    EditTrial trial(scene, choices.one_of(options));
    trial.edit(choices);
    for (int i = 0; i < 10; ++i) {
      INFO("seed " << seed << ", edit " << i);
      REQUIRE(trial.try_bad_edit(choices) == "");
      const std::string refusal = "^" + with_ones(trial.refusal());
      std::erase_if(
          rules, [&](const std::string& rule) { return refusal.find(rule) != std::string::npos; });
    }
  }
  CHECK(rules == std::set<std::string>{});
}

// Would catch the same where plans have domains, which small scenes have not.
TEST_CASE("edit equivalence: nested domains follow edits", "[property]") {
  const TetMesh mesh = testing::make_box({24, 18, 15}, 2e-3, 0.1);
  EditScene block{"block", {}};
  block.scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  const std::vector<std::uint8_t> bytes = testing::random_bytes(GENERATE(1, 2), 1000);
  testing::Choices choices(bytes);
  EditTrial trial(block, testing::small_steps(
                             {.math = MathMode::strict, .composition = PlanComposition::nested}));
  const auto levels = trial.solver().plan().phases.back().level;
  REQUIRE(levels > 0);
  while (!choices.is_spent()) {
    trial.edit(choices);
  }
  CHECK(trial.try_bad_edit(choices) == "");
  CHECK(trial.step() == "");
  CHECK(trial.difference() == "");
}

// Would catch what piles up edit by edit: memory, phases, masses that rounding leaves behind; and
// an undo that fails where little or nothing is left.
TEST_CASE("edit equivalence: an organ is deleted tetrahedron by tetrahedron", "[property]") {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = PBDSURG_EDIT_TRIALS / 4;
  const TetMesh mesh = tetrahedralize(recipe.shape, recipe.options).mesh;
  EditScene organ{"organ", {}};
  organ.scene.add_body("organ", mesh, elastic_material(mesh, 1000, 20e3));
  organ.scene.fix_vertices(0, std::vector<Index>{0, 1, 2});
  const PlanComposition composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  EditTrial trial(organ, testing::small_steps({.substeps = 2,
                                               .executor = executor::threads(2),
                                               .math = MathMode::strict,
                                               .composition = composition}));
  std::vector<Index> order(static_cast<std::size_t>(mesh.tet_count()));
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(),
            [](Index a, Index b) { return random_bits(9, a) < random_bits(9, b); });
  const std::size_t memory = trial.solver().memory_bytes();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const TopologyEdit edit{.remove_tets = {order[i]}};
    const std::size_t left = order.size() - i;
    if (left % 500 == 0 || left < 10) {
      REQUIRE(trial.edit_and_undo(edit) == "");
      REQUIRE(trial.edit_and_undo(edit, true) == "");
    }
    trial.edit(edit);
    if (left % 10 == 0 || left < 100) {
      REQUIRE(trial.step() == "");
    }
    if (left % 1000 == 0) {
      REQUIRE(trial.difference() == "");
    }
  }
  CHECK(trial.difference() == "");
  CHECK(trial.step() == "");
  CHECK(trial.solver().plan().phases.empty());
  // what a joint plan hands over may make a group larger than it was
  CHECK(static_cast<double>(trial.solver().memory_bytes()) < 1.1 * static_cast<double>(memory));
}

}  // namespace pbdsurg
