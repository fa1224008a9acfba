// SPDX-License-Identifier: Apache-2.0
// Time of a potential whose contact moves by a tenth of an edge a frame and warms the tissue under
// it, as an electrode does; of the same with an edit a frame that takes a tetrahedron there away;
// and of one whose region is found afresh. Ground is the lower face, so that the region is the
// whole block, or the ball around the contact.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/tissue/library.h"

#include "apps/support/executors.h"
#include "tests/support/meshes.h"
#include "tests/support/scenes.h"

namespace pbdsurg {
namespace {

constexpr double kEdge = 1e-3;  // m

struct Block {
  Block(Index cells_a_side, const Executor& executor)
      : cells(cells_a_side),
        shape(testing::make_box({cells_a_side, cells_a_side, cells_a_side}, kEdge, 0.1)),
        tissue(testing::scene_of(shape)),
        mesh(tissue, std::array{ThermalBody{0, tissues::liver().heat}}),
        conductivities(shape.tets().size(), 0.3),
        field(mesh, {.executor = executor, .device_rows = 0}),
        side(kEdge * cells_a_side) {}

  void ground_lower_face() {
    std::vector<Index> ground;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.rest_positions()[v].z() < 0.5 * kEdge) {
        ground.push_back(v);
      }
    }
    field.set_ground(ground);
  }

  // The contact of a frame, on a circle around the middle of the upper face.
  void touch(int frame) {
    const double turn = 0.1 * frame / 3;
    const Eigen::Vector3d middle(side / 2 + 3 * kEdge * std::cos(turn),
                                 side / 2 + 3 * kEdge * std::sin(turn), side);
    std::vector<PatchVertex> patch;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d& x = mesh.rest_positions()[v];
      const double distance = (x - middle).norm() / kEdge;
      if (x.z() > side - 0.5 * kEdge && distance < 1.5) {
        patch.push_back({v, std::min(1.0, 2 * (1.5 - distance))});
        mesh.for_each_element(v, [&](Index t) { conductivities[t] *= 1.01; });
      }
    }
    field.set_patch(patch, std::numbers::pi * 1.44 * kEdge * kEdge);
  }

  // Takes away a tetrahedron under the contact of a frame.
  void burn(int frame) {
    const double turn = 2.4 * frame;
    const auto x = static_cast<Index>(cells / 2 + 4 * std::cos(turn));
    const auto y = static_cast<Index>(cells / 2 + 4 * std::sin(turn));
    TopologyEdit edit;
    mesh.for_each_element(((cells + 1) * cells + y) * (cells + 1) + x,
                          [&](Index t) { edit.remove_tets = {t}; });
    tissue.apply(edit);
  }

  Index cells;
  TetMesh shape;
  Tissue tissue;
  ThermalMesh mesh;
  std::vector<double> conductivities;  // [tet_count] S/m
  PotentialField field;
  double side;  // m
};

enum class Edit { none, tissue, ground };

constexpr int kFrames = 100;  // then a fresh block

void run(benchmark::State& state, bool is_whole, Edit edit) {
  std::unique_ptr<Block> block;
  int frame = 0;
  double iterations = 0;
  for (auto _ : state) {
    state.PauseTiming();
    if (frame % kFrames == 0) {
      try {
        block = std::make_unique<Block>(static_cast<Index>(state.range(0)),
                                        state.range(2) != 0
                                            ? programs::device()
                                            : executor::threads(static_cast<int>(state.range(1))));
      } catch (const BackendUnavailable& error) {
        state.SkipWithError(error.what());
        return;
      }
    }
    if (is_whole && (frame % kFrames == 0 || edit == Edit::ground)) {
      block->ground_lower_face();
    }
    block->touch(frame % kFrames);
    if (frame % kFrames == 0) {
      block->field.solve(block->conductivities);
    }
    if (edit == Edit::tissue) {
      block->burn(frame % kFrames);
    }
    ++frame;
    state.ResumeTiming();
    double conductance = block->field.solve(block->conductivities).conductance;
    benchmark::DoNotOptimize(conductance);
    iterations += block->field.report().iterations;
  }
  state.counters["tets"] = block->mesh.tet_count();
  state.counters["vertices"] = block->field.report().vertex_count;
  state.counters["iterations"] = iterations / frame;
}

void measure_block(benchmark::State& state) {
  run(state, true, Edit::none);
}
void measure_ball(benchmark::State& state) {
  run(state, false, Edit::none);
}
void measure_edits(benchmark::State& state) {
  run(state, true, Edit::tissue);
}
void measure_new_region(benchmark::State& state) {
  run(state, true, Edit::ground);
}

// 6.0, 20 and 64 thousand tetrahedra, on the CPU and on a device
void sizes(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"cells", "threads", "device"})
      ->ArgsProduct({{10, 15, 22}, {1, 2}, {0}})
      ->ArgsProduct({{10, 15, 22}, {1}, {1}})
      ->Unit(benchmark::kMillisecond)
      ->MinTime(0.3)
      ->UseRealTime();
}

BENCHMARK(measure_block)->Name("moving_contact/whole_block")->Apply(sizes);
BENCHMARK(measure_ball)->Name("moving_contact/ball")->Apply(sizes);
BENCHMARK(measure_edits)->Name("edit_a_frame/whole_block")->Apply(sizes);
BENCHMARK(measure_new_region)->Name("new_region/whole_block")->Apply(sizes);

}  // namespace
}  // namespace pbdsurg

BENCHMARK_MAIN();
