// SPDX-License-Identifier: Apache-2.0
#include "bench/support/gpu_columns.h"

namespace pbdsurg::bench {

const char* const kGpuLegend =
    R"(- gpu: from the start of a step to its report, which brings the positions of up to 200 vertices around a tool; the state stays on the device, and the step that is timed is the second from the start; the fastest of greedy + repair, separate or joint, balanced or not, by each strategy
- with copies: the same, all positions written before the step and read after it
- stream: the paper's way: types coloured separately by the random disc, one launch a phase
- each step's end state on the device is hashed: runs agree, and strict ones with the serial backend's; from strict: how far fast steps end from there at most, in mean lengths of edges
- rate: consecutive steps of 1 ms, one after another; missed: those that took longer than that
- GB: asked of memory by the sweeps of one step, as computed: 30 times every record (16 bytes a distance, 32 a volume, 80 a tetrahedron with its edges), its vertices read and written at 16 bytes each
)";

void add_times(Json& row, const std::string& name, const std::optional<StepStatistics>& times) {
  row[name + "_ms"] = times ? rounded(times->median_ms, 1e3) : Json();
  row[name + "_p99_ms"] = times ? rounded(times->p99_ms, 1e3) : Json();
}

void add_gpu_columns(Json& row, const std::optional<GpuTimes>& gpu, const CpuTimes& cpu) {
  const auto value = [&](auto&& of) { return gpu ? Json(of(*gpu)) : Json(); };
  const auto number = [&](double steps, auto&& of) {
    return rounded(gpu ? std::optional<double>(of(*gpu)) : std::nullopt, steps);
  };
  add_times(row, "gpu", gpu ? std::optional(gpu->fastest) : std::nullopt);
  add_times(row, "gpu_copy", gpu ? std::optional(gpu->with_copies) : std::nullopt);
  add_times(row, "gpu_stream", gpu ? std::optional(gpu->stream) : std::nullopt);
  row["gpu_plan"] = value([](const GpuTimes& times) { return times.plan; });
  row["gpu_strategy"] = value([](const GpuTimes& times) { return times.strategy; });
  row["gpu_is_automatic"] = value([](const GpuTimes& times) { return times.is_automatic; });
  row["gpu_backend"] = value([](const GpuTimes& times) { return times.backend; });
  row["gpu_colors"] = value([](const GpuTimes& times) { return times.colors; });
  row["gpu_stream_colors"] = value([](const GpuTimes& times) { return times.stream_colors; });
  row["gpu_steps"] = value([](const GpuTimes& times) { return times.steps; });
  row["gpu_watched"] = value([](const GpuTimes& times) { return times.watched; });
  row["gpu_from_strict"] =
      number(1e9, [](const GpuTimes& times) { return times.distance_from_strict; });
  row["stream_over_gpu"] =
      number(1e3, [](const GpuTimes& times) { return times.stream_over_fastest; });
  row["cpu_over_gpu"] = number(1e3, [&](const GpuTimes& times) {
    return cpu.all_threads.median_ms / times.fastest.median_ms;
  });
  row["serial_over_gpu"] = number(
      1e3, [&](const GpuTimes& times) { return cpu.serial.median_ms / times.fastest.median_ms; });
  row["gpu_steps_per_second"] =
      number(1e1, [](const GpuTimes& times) { return 1e3 / times.fastest.median_ms; });
  const bool has_bytes = gpu && gpu->bytes;
  row["gpu_gb"] = has_bytes ? rounded(1e-9 * *gpu->bytes, 1e4) : Json();
  row["gpu_gb_per_s"] =
      has_bytes ? rounded(1e-6 * *gpu->bytes / gpu->fastest.median_ms, 1e0) : Json();
  row["rate_steps"] = value([](const GpuTimes& times) { return times.rate.steps; });
  row["rate_missed_1ms"] = value([](const GpuTimes& times) { return times.rate.missed; });
  add_times(row, "rate", gpu ? std::optional(gpu->rate.time) : std::nullopt);
  row["rate_max_ms"] = number(1e3, [](const GpuTimes& times) { return times.rate.max_ms; });
}

const std::vector<Column>& gpu_columns() {
  static const std::vector<Column> all{{"gpu_ms", "gpu, ms", 3},
                                       {"gpu_p99_ms", "p99", 3},
                                       {"gpu_strategy", "strategy", 0},
                                       {"gpu_plan", "plan", 0},
                                       {"gpu_colors", "colours", 0},
                                       {"gpu_copy_ms", "with copies, ms", 3},
                                       {"gpu_stream_ms", "stream, ms", 3},
                                       {"gpu_stream_colors", "colours", 0},
                                       {"stream_over_gpu", "stream / gpu", 2},
                                       {"cpu_over_gpu", "all threads / gpu", 2},
                                       {"serial_over_gpu", "serial / gpu", 2},
                                       {"rate_ms", "rate: ms", 3},
                                       {"rate_p99_ms", "p99", 3},
                                       {"rate_max_ms", "max", 3},
                                       {"rate_missed_1ms", "missed", 0},
                                       {"rate_steps", "of", 0},
                                       {"gpu_from_strict", "from strict", 6},
                                       {"gpu_gb", "GB", 2},
                                       {"gpu_gb_per_s", "GB/s", 0}};
  return all;
}

}  // namespace pbdsurg::bench
