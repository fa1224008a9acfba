// SPDX-License-Identifier: Apache-2.0
// Time and size of a file of the demo's world, after some steps and after 1000 edits of one
// tetrahedron each: written, and read.
#include <cstdint>
#include <filesystem>
#include <string>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include "pbdsurg/world/world_file.h"

#include "apps/cholecystectomy/organ_files.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/surgical_scene.h"

namespace pbdsurg {
namespace {

World make_world(Index edits) {
  const cholecystectomy::SurgicalScene scene =
      cholecystectomy::make_scene(cholecystectomy::load_anatomy({}), ElasticModel::neo_hookean);
  World world(scene.scene, scene.tissues, scene.connections,
              cholecystectomy::solver_options(executor::serial(), false));
  world.add_cautery(world.add_tool({}), {BodyId(0), BodyId(1)});
  world.record();
  world.step(5e-3);
  const Index stride = static_cast<Index>(world.tissue().tets().size()) / 1000;
  for (Index i = 0; i < edits; ++i) {
    world.tissue().apply({.remove_tets = {stride * i}});
  }
  world.step(5e-3);
  return world;
}

std::filesystem::path file() {
  return std::filesystem::temp_directory_path() /
         ("world_file_bench." + std::to_string(getpid()) + ".world");
}

void write(benchmark::State& state) {
  const World world = make_world(static_cast<Index>(state.range(0)));
  const WorldState saved = world.save();
  for (auto step : state) {
    write_world(file(), saved);
  }
  state.counters["bytes"] = static_cast<double>(std::filesystem::file_size(file()));
  std::filesystem::remove(file());
}
BENCHMARK(write)->Arg(0)->Arg(1000)->Unit(benchmark::kMillisecond);

void read(benchmark::State& state) {
  write_world(file(), make_world(static_cast<Index>(state.range(0))).save());
  for (auto step : state) {
    benchmark::DoNotOptimize(read_world(file(), executor::serial()));
  }
  std::filesystem::remove(file());
}
BENCHMARK(read)->Arg(0)->Arg(1000)->Unit(benchmark::kMillisecond)->Iterations(2);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
