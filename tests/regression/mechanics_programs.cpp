// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstddef>
#include <utility>

#include "tests/regression/programs.h"
#include "tests/support/copies_program.h"
#include "tests/support/edits_within_steps.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {
namespace {

constexpr ProjectionMode kFraction = ProjectionMode::fraction;
constexpr PlanComposition kJoint = PlanComposition::joint;
constexpr PlanComposition kNested = PlanComposition::nested;
constexpr SolverMethod kVertexBlock = SolverMethod::vertex_block;

struct NamedVariant {
  const char* name;
  Variant variant;
};

const std::array kVariants{
    NamedVariant{"separate", {}},
    NamedVariant{"joint", {.composition = kJoint}},
    NamedVariant{"nested", {.composition = kNested}},
    NamedVariant{"separate-damped", {.damping = 0.01F}},
    NamedVariant{"joint-damped", {.composition = kJoint, .damping = 0.01F}},
    NamedVariant{"nested-damped", {.composition = kNested, .damping = 0.01F}},
    NamedVariant{"separate-overflow", {.max_colors = 5}},
    NamedVariant{"joint-overflow", {.composition = kJoint, .max_colors = 9, .damping = 0.01F}},
    NamedVariant{"nested-overflow", {.composition = kNested, .max_colors = 5}},
    NamedVariant{"fraction-separate", {.mode = kFraction}},
    NamedVariant{"fraction-joint", {.mode = kFraction, .composition = kJoint}},
    NamedVariant{"fraction-nested", {.mode = kFraction, .composition = kNested}},
    NamedVariant{"fraction-separate-overflow", {.mode = kFraction, .max_colors = 9}},
    NamedVariant{"fraction-joint-overflow",
                 {.mode = kFraction, .composition = kJoint, .max_colors = 9}},
    NamedVariant{"few-contacts", {.contact_capacity = 3}},
    NamedVariant{"vertex-block", {.method = kVertexBlock}},
    NamedVariant{"vertex-block-damped", {.method = kVertexBlock, .damping = 0.01F}},
    NamedVariant{"vertex-block-over-relaxed",
                 {.method = kVertexBlock, .iterations = 4, .over_relaxation = 1.3F}},
    NamedVariant{"vertex-block-few-contacts", {.method = kVertexBlock, .contact_capacity = 3}}};

// Those for copies, and for edits within steps.
const std::array kFewVariants{
    NamedVariant{"separate-overflow", {.max_colors = 5, .contact_capacity = 20}},
    NamedVariant{"joint-damped", {.composition = kJoint, .damping = 0.01F}},
    NamedVariant{"fraction-nested", {.mode = kFraction, .composition = kNested}},
    NamedVariant{"vertex-block", {.method = kVertexBlock}},
    NamedVariant{"vertex-block-damped", {.method = kVertexBlock, .damping = 0.01F}}};

// Those with forces, and gravity that changes.
const std::array kLoadedVariants{
    NamedVariant{"separate-damped", {.damping = 0.01F}},
    NamedVariant{"fraction-separate", {.mode = kFraction}},
    NamedVariant{"vertex-block", {.method = kVertexBlock}},
    NamedVariant{"vertex-block-bdf2",
                 {.method = kVertexBlock, .integration = TimeIntegration::bdf2}}};

struct NamedColoring {
  const char* name;
  PlanComposition composition;
  ColoringOptions coloring;
};

const std::array kColorings{
    NamedColoring{"unrepaired", PlanComposition::separate, {}},
    NamedColoring{"largest-valence", kJoint, {.order = GreedyOrder::largest_valence}},
    NamedColoring{
        "smallest-last", PlanComposition::separate, {.order = GreedyOrder::smallest_last}},
    NamedColoring{"saturation", PlanComposition::separate, {.order = GreedyOrder::saturation}},
    NamedColoring{"balanced", kJoint, {.repair = true, .balance = true}},
    NamedColoring{
        "luby", PlanComposition::separate, {.algorithm = ColoringAlgorithm::luby, .seed = 3}},
    NamedColoring{"jones-plassmann",
                  PlanComposition::separate,
                  {.algorithm = ColoringAlgorithm::jones_plassmann, .repair = true, .seed = 3}},
    NamedColoring{"random-disc",
                  PlanComposition::separate,
                  {.algorithm = ColoringAlgorithm::random_disc, .repair = true, .seed = 3}}};

// For a nested plan, of more than 6000 vertices, which are two domains and what joins them.
Scene make_scene(const Variant& variant) {
  return variant.composition == kNested
             ? make_eventful_scene(variant.mode, variant.damping, {18, 18, 16})
             : make_eventful_scene(variant.mode, variant.damping);
}

// Steps of large scenes take a hundred times as long.
int rounds_of(const Scene& scene, int rounds) {
  return scene.vertex_count() > 6000 ? rounds / 3 : rounds;
}

// All that can be done to a solver, choices by seed and state.
void run_eventful(const Scene& scene, const SolverOptions& options, const Executor& executor,
                  Record& record, bool has_loads = false) {
  const int rounds = rounds_of(scene, 60), interval = rounds / 3;
  Driver driver(scene, options, executor);
  const EventfulProgram program(scene, 1);
  program.begin(driver.solver());
  for (int round = 0; round < rounds; ++round) {
    program.act(driver.solver(), round);
    if (has_loads) {
      program.load(driver.solver(), round);
    }
    driver.step(kEventfulTimeStep);
    if (round % interval == interval - 1) {
      driver.look(record, round + 1);
    }
  }
  driver.solver().watch({});
  driver.compact();
  driver.step(kEventfulTimeStep);
  driver.look(record, rounds + 1);
}

// Copies that each do something else.
void run_copies(const Variant& variant, const Executor& executor, Record& record,
                bool has_loads = false) {
  constexpr Index kCopies = 3;
  const Scene scene = make_scene(variant);
  const int rounds = rounds_of(scene, 36), interval = rounds / 2;
  SolverOptions options = options_of(variant);
  options.copies = kCopies;
  Driver driver(scene, options, executor);
  const CopiesProgram program(scene);
  program.begin(driver.solver());
  for (int round = 0; round < rounds; ++round) {
    for (Index copy = 0; copy < kCopies; ++copy) {
      program.act(driver.solver(), round, copy, copy);
      if (has_loads) {
        program.load(driver.solver(), round, copy, copy);
      }
    }
    if (round % 4 >= 2) {
      program.edit(driver.solver(), round);
    }
    driver.step(kEventfulTimeStep);
    if (round % interval == interval - 1) {
      driver.look(record, round + 1);
    }
  }
  driver.solver().watch({});
  driver.compact();
  driver.step(kEventfulTimeStep);
  driver.look(record, rounds + 1);
}

// Edits between the beginning of a step and its end, some of which are taken back there.
void run_within_steps(const Variant& variant, const Executor& executor, Record& record) {
  const Scene scene = make_scene(variant);
  const int rounds = rounds_of(scene, 30), interval = rounds / 2;
  Driver driver(scene, options_of(variant), executor);
  Solver& solver = driver.solver();
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  solver.add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
  solver.watch(std::array<Index, 3>{5, 1, 40});
  for (Index round = 0; round < rounds; ++round) {
    const Surroundings held = some_surroundings(solver, static_cast<std::uint64_t>(round));
    solver.release(ToolId{0});
    solver.grasp(ToolId{0}, std::array{held.vertex}, 1e-4F);
    driver.start_step(kEventfulTimeStep);
    driver.edit(edit_within_step(solver, round, held));
    if (round % 6 == 1) {
      driver.undo();
    }
    driver.finish_step();
    if (round % 6 == 2) {
      driver.undo();
    }
    if (round % interval == interval - 1) {
      driver.look(record, round + 1);
    }
  }
}

// A block of several domains, under a tool, with a hole, a cut and an undo.
void run_block(const SolverOptions& options, const Executor& executor, Record& record) {
  constexpr double kBlockEdge = 2e-3;  // m
  const TetMesh block = make_box({24, 24, 11}, kBlockEdge, 0.1);
  Scene scene;
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kBlockEdge; });
  Driver driver(scene, options, executor);
  const Capsule capsule{{0.03F, 0, 0.01F}, {0.03F, 0.05F, 0.01F}, 4e-3F};
  driver.solver().add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
  driver.step(kEventfulTimeStep);
  driver.look(record, 1);
  TopologyEdit hole;
  for (Index t = 0; t < block.tet_count(); t += 7) {
    hole.remove_tets.push_back(t);
  }
  driver.edit(hole);
  driver.step(kEventfulTimeStep);
  driver.undo();
  driver.edit(eventful_edit(driver.solver(), 1));
  const std::array way{BladeEdge{{0.02F, 0.01F, 0.03F}, {0.02F, 0.03F, 0.03F}},
                       BladeEdge{{0.025F, 0.01F, 0.01F}, {0.022F, 0.03F, 0.01F}}};
  driver.cut(sweep_blade(way), CutStyle::through_tets);
  driver.step(kEventfulTimeStep);
  driver.look(record, 2);
  driver.compact();
  driver.step(kEventfulTimeStep);
  driver.look(record, 3);
}

// The paper's tables: stretched by 10 %, thirty sweeps, types coloured separately by random disc.
void run_paper(const Executor& executor, Record& record) {
  constexpr double kPaperEdge = 4e-3;  // m
  Scene scene;
  scene.add_body("bar", make_box({12, 5, 3}, kPaperEdge, 0.1), testing::kSprings);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kPaperEdge; });
  Driver driver(scene, SolverOptions::paper(), executor);
  std::vector<Eigen::Vector3f> stretched = driver.solver().positions();
  for (Eigen::Vector3f& x : stretched) {
    x.x() *= 1.1F;
  }
  driver.solver().write_positions(stretched);
  for (int step = 1; step <= 6; ++step) {
    driver.step(2e-4F);
    if (step % 3 == 0) {
      driver.look(record, step);
      driver.edit({.remove_tets = {1, 100, 500}});
      driver.undo();
      driver.edit(eventful_edit(driver.solver(), step));
    }
  }
}

}  // namespace

std::vector<Program> mechanics_programs() {
  std::vector<Program> programs;
  const auto add = [&](const std::string& name, auto run) { programs.push_back({name, run}); };
  for (const NamedVariant& named : kVariants) {
    add(std::string("eventful-") + named.name, [&named](const Executor& executor, Record& record) {
      run_eventful(make_scene(named.variant), testing::options_of(named.variant), executor, record);
    });
  }
  for (const NamedColoring& named : kColorings) {
    add(std::string("eventful-") + named.name, [named](const Executor& executor, Record& record) {
      SolverOptions options = testing::options_of({.composition = named.composition});
      options.coloring = named.coloring;
      run_eventful(make_eventful_scene(options.mode, 0), options, executor, record);
    });
  }
  for (const bool is_of_blocks :
       {false, true}) {  // spare room changes nothing but where things lie
    add(is_of_blocks ? "eventful-vertex-block-spare" : "eventful-separate-spare",
        [is_of_blocks](const Executor& executor, Record& record) {
          SolverOptions options = testing::options_of(
              {.method = is_of_blocks ? kVertexBlock : SolverMethod::projection});
          options.spare = {.vertices = 300, .tets = 900, .edges = 1500, .links = 100};
          run_eventful(make_eventful_scene(options.mode, 0), options, executor, record);
        });
  }
  for (const NamedVariant& named : kFewVariants) {
    add(std::string("copies-") + named.name, [&named](const Executor& executor, Record& record) {
      run_copies(named.variant, executor, record);
    });
    add(std::string("within-steps-") + named.name,
        [&named](const Executor& executor, Record& record) {
          run_within_steps(named.variant, executor, record);
        });
  }
  for (const NamedVariant& named : kLoadedVariants) {
    add(std::string("loaded-") + named.name, [&named](const Executor& executor, Record& record) {
      run_eventful(make_scene(named.variant), testing::options_of(named.variant), executor, record,
                   true);
    });
    add(std::string("loaded-copies-") + named.name,
        [&named](const Executor& executor, Record& record) {
          run_copies(named.variant, executor, record, true);
        });
  }
  add("block-separate", [](const Executor& executor, Record& record) {
    run_block(plain_options(PlanComposition::separate), executor, record);
  });
  add("block-nested", [](const Executor& executor, Record& record) {
    run_block(plain_options(kNested), executor, record);
  });
  add("block-nested-overflow", [](const Executor& executor, Record& record) {
    SolverOptions options = plain_options(kNested);
    options.coloring = {.max_colors = 9};
    run_block(options, executor, record);
  });
  add("block-vertex-block", [](const Executor& executor, Record& record) {
    SolverOptions options = plain_options(PlanComposition::separate);
    options.method = kVertexBlock;
    run_block(options, executor, record);
  });
  add("paper", run_paper);
  return programs;
}

}  // namespace pbdsurg::testing
