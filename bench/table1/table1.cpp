// SPDX-License-Identifier: Apache-2.0
// Table 1 of Pan et al. 2020: the organ's constraints, coloured by every algorithm.
#include <cstdio>
#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include "bench/support/gpu_times.h"
#include "bench/support/program.h"
#include "bench/table1/gpu_coloring.h"
#include "bench/table1/measure.h"
#include "bench/table1/report.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  bool quick = false;
};

void run(const Arguments& arguments) {
  std::vector<std::string> notes{"CUDA: " + describe_gpu()};
  if (const auto why = why_no_gpu()) {
    notes.push_back("no steps on a gpu: " + *why);
  }
  const std::list<Sample> samples =
      arguments.quick ? make_samples({1}, {Table2Kind::hollow}, notes)
                      : make_samples({2}, {Table2Kind::hollow, Table2Kind::surface_filled}, notes);
  const Repetitions repetitions = arguments.quick ? Repetitions{1, 1} : Repetitions{15, 25};
  std::vector<Row> rows;
  for (const Sample& sample : samples) {
    const std::vector<Row> measured = measure(sample, repetitions);
    rows.insert(rows.end(), measured.begin(), measured.end());
  }
  const Json json = to_json(rows);
  const std::string markdown = to_markdown(json, notes);
  std::fputs(markdown.c_str(), stdout);
  write_table(arguments.out, "table1", json, markdown);
  write_text(arguments.out / "table1_colors.csv", to_csv(colors_of(rows)));
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Table 1: an organ's constraints, coloured by every algorithm.", "table1");
  pbdsurg::bench::Arguments arguments;
  app.add_flag("--quick", arguments.quick, "the smallest mesh, everything once: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
