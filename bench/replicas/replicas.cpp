// SPDX-License-Identifier: Apache-2.0
// Copies of a scene that one solver steps on several threads, against as many processes with as
// many copies together, each on one thread: what nothing that threads share can beat.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/program.h"
#include "bench/support/subject.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::bench {
namespace {

using Clock = std::chrono::steady_clock;  // the same in all processes

struct Arguments {
  std::filesystem::path out = "out/tables";
  double seconds = 2;  // a run
  int threads = 0;
  bool quick = false;
  // of a process that steps some of the copies
  Index worker_copies = 0;
  Index worker_vertices = 0;
  std::int64_t worker_start = 0;  // ns of the clock
};

// Of all copies, 1/s.
double rate_of(Solver& solver, Clock::time_point start, double seconds) {
  while (Clock::now() < start) {
  }
  const Clock::time_point end =
      start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  std::int64_t steps = 0;
  Clock::time_point now = start;
  for (; now < end; now = Clock::now()) {
    solver.step(5e-3F);
    ++steps;
  }
  return static_cast<double>(steps * solver.options().copies) /
         std::chrono::duration<double>(now - start).count();
}

void work(const Arguments& arguments) {
  Solver solver(
      make_sagging_liver(arguments.worker_vertices),
      testing::small_steps({.copies = arguments.worker_copies, .executor = executor::threads(1)}));
  solver.step(5e-3F);
  const Clock::time_point start{std::chrono::nanoseconds(arguments.worker_start)};
  if (Clock::now() > start) {
    throw Error("the processes were not ready in time");
  }
  std::printf("%.17g\n", rate_of(solver, start, arguments.seconds));
}

// Of as many processes, together.
double rate_of_processes(Index vertices, Index copies, int processes, double seconds) {
  const std::chrono::milliseconds time_to_begin(1000 + vertices);
  const Clock::time_point start = Clock::now() + time_to_begin;
  const std::string command =
      "'" + std::filesystem::read_symlink("/proc/self/exe").string() + "' --worker-vertices " +
      std::to_string(vertices) + " --worker-start " +
      std::to_string(std::chrono::nanoseconds(start.time_since_epoch()).count()) + " --seconds " +
      std::to_string(seconds) + " --worker-copies ";
  const auto close = [](std::FILE* pipe) { pclose(pipe); };
  std::vector<std::unique_ptr<std::FILE, decltype(close)>> pipes;
  for (int p = 0; p < processes; ++p) {
    const Index part = copies * (p + 1) / processes - copies * p / processes;
    pipes.emplace_back(popen((command + std::to_string(part)).c_str(), "r"), close);
  }
  double sum = 0;
  for (const auto& pipe : pipes) {
    double rate = 0;
    if (pipe == nullptr || std::fscanf(pipe.get(), "%lf", &rate) != 1) {
      throw Error("a process of copies failed");
    }
    sum += rate;
  }
  return sum;
}

Json measure(Index vertices, Index copies, int threads, double seconds) {
  const Scene scene = make_sagging_liver(vertices);
  Solver solver(scene,
                testing::small_steps({.copies = copies, .executor = executor::threads(threads)}));
  solver.step(5e-3F);
  constexpr int kRounds = 3;  // by turns, as machines drift
  std::vector<double> shared, apart, ratios;
  for (int round = 0; round < kRounds; ++round) {
    shared.push_back(rate_of(solver, Clock::now(), seconds));
    apart.push_back(rate_of_processes(vertices, copies, threads, seconds));
    ratios.push_back(shared.back() / apart.back());
  }
  std::fprintf(stderr, "%d tetrahedra, %d copies, %d threads: %.0f and %.0f steps/s\n",
               static_cast<int>(scene.tets().size()), copies, threads, median(shared),
               median(apart));
  return {{"tets", scene.tets().size()},
          {"copies", copies},
          {"threads", threads},
          {"threads_per_s", rounded(median(shared), 10)},
          {"processes_per_s", rounded(median(apart), 10)},
          {"ratio", rounded(median(ratios), 1e3)}};
}

void run(const Arguments& arguments) {
  if (arguments.worker_copies > 0) {
    work(arguments);
    return;
  }
  const std::vector<Column> columns{{"copies", "copies", 0},
                                    {"threads", "threads or processes", 0},
                                    {"threads_per_s", "one solver, steps of copies/s", 0},
                                    {"processes_per_s", "processes, steps of copies/s", 0},
                                    {"ratio", "ratio (aim 0.9)", 2}};
  std::string text =
      "# Replicas\n\n- copies of a liver that sags, steps of 5 ms with default options: of one "
      "solver on threads, and shared out to as many processes of one thread\n\n" +
      markdown_header("tets", columns);
  const int most = thread_count(arguments.threads);
  std::vector<int> thread_counts{1};
  for (int threads = 2; threads < most; threads *= 2) {
    thread_counts.push_back(threads);
  }
  if (most > 1) {
    thread_counts.push_back(most);
  }
  const std::vector<Index> sizes =
      arguments.quick ? std::vector<Index>{150} : std::vector<Index>{150, 1500, 5000};
  Json rows = Json::array();
  for (const Index vertices : sizes) {
    for (const int threads : thread_counts) {
      const Index copies = std::max(16, threads);
      rows.push_back(measure(vertices, copies, threads, arguments.quick ? 0.3 : arguments.seconds));
      text += markdown_line(text_of(rows.back()["tets"]), rows.back(), columns);
    }
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "replicas", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Copies of a scene on threads, against processes of their own.", "replicas");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  app.add_option("--seconds", arguments.seconds, "a run")->check(CLI::PositiveNumber);
  app.add_flag("--quick", arguments.quick, "the smallest mesh, 0.3 s: to see it work");
  app.add_option("--worker-copies", arguments.worker_copies)->group("");
  app.add_option("--worker-vertices", arguments.worker_vertices)->group("");
  app.add_option("--worker-start", arguments.worker_start)->group("");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
