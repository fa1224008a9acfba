// SPDX-License-Identifier: Apache-2.0
// Steps on a machine that others use, too: with one thread, with as many as the library chooses,
// and with all of them, beside threads that never rest.
#include <atomic>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "bench/support/program.h"
#include "bench/support/subject.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  double seconds = 20;  // a row
  int neighbours = 2;
  bool quick = false;
};

/// Threads that never rest, while it lives.
class Neighbours {
 public:
  explicit Neighbours(int count) {
    for (int i = 0; i < count; ++i) {
      threads_.emplace_back([this] {
        while (!stop_.load(std::memory_order_relaxed)) {
        }
      });
    }
  }
  ~Neighbours() { stop_ = true; }
  Neighbours(const Neighbours&) = delete;
  Neighbours& operator=(const Neighbours&) = delete;

 private:
  std::atomic<bool> stop_{false};
  std::vector<std::jthread> threads_;
};

/// A fixed liver that sags, with default options but for the threads.
class Contender {
 public:
  Contender(const Scene& scene, int threads)
      : solver_(scene, {.executor = executor::threads(threads)}) {}

  /// Steps for some time, so that the scheduler's slices are seen as they come.
  void run(double seconds) {
    for (double spent = 0; spent < 1e3 * seconds; spent += times_.back()) {
      times_.push_back(time_of([&] { solver_.step(5e-3F); }));
    }
  }

  [[nodiscard]] StepStatistics times() const { return statistics(times_); }
  [[nodiscard]] std::size_t steps() const { return times_.size(); }

 private:
  Solver solver_;
  std::vector<double> times_;  // ms
};

Json measure(const Scene& scene, int neighbours, double seconds) {
  Contender one(scene, 1), chosen(scene, 0), all(scene, thread_count(0));
  {
    const Neighbours others(neighbours);
    constexpr int kRounds = 8;  // by turns, as machines drift
    for (int round = 0; round < kRounds; ++round) {
      for (Contender* const contender : {&one, &chosen, &all}) {
        contender->run(seconds / (3 * kRounds));
      }
    }
  }
  const StepStatistics base = one.times(), times = chosen.times(), forced = all.times();
  std::fprintf(stderr, "%d tetrahedra, %d neighbours: %.2f, %.2f, %.2f ms\n",
               static_cast<int>(scene.tets().size()), neighbours, base.median_ms, times.median_ms,
               forced.median_ms);
  return {{"tets", scene.tets().size()},
          {"neighbours", neighbours},
          {"one_ms", rounded(base.median_ms, 1e3)},
          {"one_p99_ms", rounded(base.p99_ms, 1e3)},
          {"chosen_ms", rounded(times.median_ms, 1e3)},
          {"chosen_p99_ms", rounded(times.p99_ms, 1e3)},
          {"all_ms", rounded(forced.median_ms, 1e3)},
          {"all_p99_ms", rounded(forced.p99_ms, 1e3)},
          {"ratio", rounded(times.median_ms / base.median_ms, 1e3)},
          {"ratio_p99", rounded(times.p99_ms / base.p99_ms, 1e3)},
          {"steps", chosen.steps()}};
}

void run(const Arguments& arguments) {
  const std::vector<Column> columns{{"neighbours", "neighbours", 0},
                                    {"one_ms", "one thread, ms", 2},
                                    {"one_p99_ms", "p99", 2},
                                    {"chosen_ms", "default, ms", 2},
                                    {"chosen_p99_ms", "p99", 2},
                                    {"all_ms", "all threads, ms", 2},
                                    {"all_p99_ms", "p99", 2},
                                    {"ratio", "default / one (aim 1.1)", 2},
                                    {"ratio_p99", "p99 / p99 (aim 2)", 2}};
  std::string text =
      "# Busy neighbours\n\n- a liver that sags, steps of 5 ms with default options, on one "
      "thread, "
      "on as many as are chosen, and on all " +
      std::to_string(thread_count(0)) + "; beside threads that never rest; medians of a step\n\n" +
      markdown_header("tets", columns);
  Json rows = Json::array();
  const std::vector<Index> sizes =
      arguments.quick ? std::vector<Index>{150} : std::vector<Index>{150, 1500, 5000};
  for (const Index vertices : sizes) {
    const Scene scene = make_sagging_liver(vertices);
    for (int neighbours = 0; neighbours <= arguments.neighbours; ++neighbours) {
      rows.push_back(measure(scene, neighbours, arguments.quick ? 0.5 : arguments.seconds));
      text += markdown_line(text_of(rows.back()["tets"]), rows.back(), columns);
    }
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "neighbours", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Steps on a machine that others use, too.", "neighbours");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--seconds", arguments.seconds, "a row")->check(CLI::PositiveNumber);
  app.add_option("--neighbours", arguments.neighbours, "at most")->check(CLI::NonNegativeNumber);
  app.add_flag("--quick", arguments.quick, "the smallest mesh, half a second: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
