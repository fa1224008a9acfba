// SPDX-License-Identifier: Apache-2.0
// What tissue does at rest, against a static solution of the same mesh.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/statics/cases.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  bool quick = false;
};

struct NamedOptions {
  const char* name;
  SolverOptions options;
};

std::vector<NamedOptions> all_options() {
  return {{"default", {}},
          {"small steps, 10 x 1",
           {.method = SolverMethod::projection, .substeps = 10, .iterations = 1}},
          {"vertex blocks, 1 x 10",
           {.method = SolverMethod::vertex_block, .substeps = 1, .iterations = 10}}};
}

Json to_row(const Case& each, const NamedOptions& how, double step_ms, double expected,
            const Outcome& outcome) {
  return {{"case", each.name},
          {"options", how.name},
          {"step_ms", step_ms},
          {"unit", each.unit()},
          {"value", rounded(outcome.value, 1e5)},
          {"expected", rounded(expected, 1e5)},
          {"error_percent", rounded(100 * (outcome.value / expected - 1), 1e2)},
          {"drift_percent", rounded(100 * outcome.change, 1e2)}};
}

void run(const Arguments& arguments) {
  const std::vector<Column> columns{{"options", "options", 0},
                                    {"step_ms", "step, ms", 1},
                                    {"unit", "unit", 0},
                                    {"value", "value", 3},
                                    {"expected", "static solution", 3},
                                    {"error_percent", "error, %", 2},
                                    {"drift_percent", "in motion still, %", 2}};
  std::string text =
      "# Statics\n\n- value: how far what hangs has sagged, in mm, or the force on a tool along "
      "its "
      "way, in N; the mean of the last tenth of a run\n- static solution: by Newton's method in "
      "double precision, on the same mesh, of the same energy\n- in motion still: by how much the "
      "last tenth differs from the tenth before\n- drag near critical; what rests does not feel "
      "it\n\n" +
      markdown_header("case", columns);
  Json rows = Json::array();
  for (const Case& each : make_cases(arguments.quick)) {
    const double expected = expected_value(each);
    // twenty times what the slowest mode takes to fade by a factor of e
    const double seconds = std::max(0.2, 40 / each.drag);
    for (const NamedOptions& how : all_options()) {
      for (const double step_ms : each.steps_ms) {
        rows.push_back(to_row(each, how, step_ms, expected,
                              measure(each, how.options, 1e-3 * step_ms, seconds)));
        text += markdown_line(each.name, rows.back(), columns);
      }
    }
    std::fprintf(stderr, "%s: done\n", each.name.c_str());
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "statics", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("What tissue does at rest, against a static solution of the same mesh.", "statics");
  pbdsurg::bench::Arguments arguments;
  app.add_flag("--quick", arguments.quick, "one bar: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
