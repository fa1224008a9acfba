// SPDX-License-Identifier: Apache-2.0
// Table 2 of Pan et al. 2020: the time of a step for each size of mesh, here on the CPU.
#include <cstdio>
#include <filesystem>

#include "measure.h"
#include "report.h"
#include "support/program.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  int threads = 0;
  bool quick = false;
};

// p99 needs a hundred steps; small meshes take more of them.
constexpr Effort kFull{100, 8, 9};
constexpr Effort kQuick{3, 0, 1};

void run(const Arguments& arguments) {
  const int threads = thread_count(arguments.threads);
  std::vector<std::string> notes{"all threads: " + std::to_string(threads)};
  const std::vector<Subject> subjects = make_subjects(arguments.quick, notes);
  std::vector<Row> rows;
  for (const Subject& subject : subjects) {
    for (Row& row : measure(subject, threads, arguments.quick ? kQuick : kFull)) {
      std::fprintf(stderr, "%s %s, %d tetrahedra: %.2f ms on %d threads (%s)\n",
                   subject.kind.c_str(), subject.row ? std::to_string(*subject.row).c_str() : "",
                   static_cast<int>(subject.scene.tets().size()), row.all_threads.median_ms,
                   threads, row.plan.c_str());
      rows.push_back(std::move(row));
    }
  }
  notes.push_back("backend of the columns with threads: " + rows.at(0).backend);
  const Json json = to_json(rows);
  const std::string markdown = to_markdown(json, notes);
  std::fputs(markdown.c_str(), stdout);
  write_text(arguments.out / "table2.md", markdown);
  write_text(arguments.out / "table2.csv", to_csv(json));
  merge_into_json(arguments.out / "tables.json", "table2", json);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Table 2: how long a step takes, by size of mesh and backend.", "table2");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  app.add_flag("--quick", arguments.quick, "the smallest mesh, few steps: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
