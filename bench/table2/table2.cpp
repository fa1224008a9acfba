// SPDX-License-Identifier: Apache-2.0
// Table 2 of Pan et al. 2020: the time of a step for each size of mesh, on the CPU and on a CUDA
// device.
#include <cstdio>
#include <filesystem>
#include <utility>

#include "bench/support/effort.h"
#include "bench/support/program.h"
#include "bench/table2/report.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  int threads = 0;
  int cpu_rounds = kCpuRounds;
  bool quick = false;
};

// A row for the paper's plan, and one for the plan that is fastest on all threads.
std::vector<Row> measure(const Subject& subject, int threads, const Effort& effort, bool has_gpu) {
  std::optional<GpuTimes> gpu;
  if (has_gpu) {
    gpu = measure_on_gpu(subject.scene, effort.gpu);
  }
  std::vector<Row> rows;
  for (const SolverOptions& plan :
       {SolverOptions::paper(), find_fastest_cpu_plan(subject.scene, threads, effort.cpu)}) {
    rows.push_back({&subject, measure_on_cpu(subject.scene, plan, threads, effort.cpu), gpu});
    const Row& row = rows.back();
    std::fprintf(stderr, "%s %s, %d tetrahedra: %.2f ms on %d threads (%s)", subject.kind.c_str(),
                 subject.row ? std::to_string(*subject.row).c_str() : "",
                 static_cast<int>(subject.scene.tets().size()), row.cpu.all_threads.median_ms,
                 threads, row.cpu.plan.c_str());
    if (gpu) {
      std::fprintf(stderr, ", %.3f ms on the gpu (%s; %s)", gpu->fastest.median_ms,
                   gpu->strategy.c_str(), gpu->plan.c_str());
    }
    std::fprintf(stderr, "\n");
  }
  return rows;
}

// After each mesh, so that a run that is broken off leaves what it has.
std::string write_tables(const Arguments& arguments, const std::vector<Row>& rows,
                         std::vector<std::string> notes) {
  notes.push_back("backend of the columns with threads: " + rows.at(0).cpu.backend);
  if (rows.at(0).gpu) {
    notes.push_back("backend of the gpu columns, in the first row: " + rows.at(0).gpu->backend);
  }
  const Json json = to_json(rows);
  const std::string markdown = to_markdown(json, notes);
  write_table(arguments.out, "table2", json, markdown);
  return markdown;
}

void run(const Arguments& arguments) {
  const int threads = thread_count(arguments.threads);
  std::vector<std::string> notes{"all threads: " + std::to_string(threads)};
  const std::optional<std::string> why_no_device = why_no_gpu();
  if (why_no_device) {
    notes.push_back("no gpu columns: " + *why_no_device);
  }
  const std::vector<Subject> subjects = make_table2_subjects(arguments.quick, notes);
  std::vector<Row> rows;
  std::string markdown;
  for (const Subject& subject : subjects) {
    const Effort effort = arguments.quick             ? kQuickEffort
                          : subject.kind == "lattice" ? large_effort(arguments.cpu_rounds)
                                                      : full_effort(arguments.cpu_rounds);
    for (Row& row : measure(subject, threads, effort, !why_no_device)) {
      rows.push_back(std::move(row));
    }
    markdown = write_tables(arguments, rows, notes);
  }
  std::fputs(markdown.c_str(), stdout);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Table 2: how long a step takes, by size of mesh and backend.", "table2");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  pbdsurg::bench::add_cpu_rounds_option(app, arguments.cpu_rounds);
  app.add_flag("--quick", arguments.quick, "the smallest mesh, few steps: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
