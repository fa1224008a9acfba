// SPDX-License-Identifier: Apache-2.0
// Colouring on a CUDA device, constraints and colours in its memory: wall time until it is done,
// with the host's part. And once with the copies to and from the device.
#include <cstdio>

#include <benchmark/benchmark.h>

#include "pbdsurg/cuda/coloring.h"
#include "pbdsurg/cuda/device.h"

#include "bench/support/coloring_samples.h"

namespace pbdsurg::bench {
namespace {

void color(benchmark::State& state, const ColoringSample& sample, const ColoringOptions& options) {
  const ConstraintVertices constraints = sample.constraints();
  cuda::DeviceColoring device(constraints);
  device.color(options);  // allocates
  for (auto _ : state) {
    device.color(options);
  }
  report_coloring(state, constraints, device.download());
}

void color_with_copies(benchmark::State& state, const ColoringSample& sample,
                       const ColoringOptions& options) {
  const ConstraintVertices constraints = sample.constraints();
  Coloring coloring;
  for (auto _ : state) {
    coloring = cuda::color_constraints(constraints, options);
  }
  report_coloring(state, constraints, coloring);
}

void register_all() {
  for (const ColoringSample& sample : coloring_samples()) {
    for (const NamedColoring& coloring : parallel_colorings()) {
      benchmark::RegisterBenchmark((sample.name() + "/" + coloring.name).c_str(), color, sample,
                                   coloring.options)
          ->Unit(benchmark::kMillisecond)
          ->MinTime(0.05)
          ->UseRealTime();
    }
    const NamedColoring last = parallel_colorings().back();
    benchmark::RegisterBenchmark((sample.name() + "/" + last.name + "/with_copies").c_str(),
                                 color_with_copies, sample, last.options)
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.05)
        ->UseRealTime();
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  const pbdsurg::cuda::DeviceList devices = pbdsurg::cuda::find_devices();
  if (devices.devices.empty()) {
    std::printf("no benchmark: %s\n", devices.reason.c_str());
    return 0;
  }
  pbdsurg::bench::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
}
