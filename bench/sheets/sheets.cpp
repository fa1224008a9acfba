// SPDX-License-Identifier: Apache-2.0
// What sheets come to at rest, by each method, against closed forms, and what a sweep costs.
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/support/executors.h"
#include "bench/sheets/cases.h"
#include "bench/sheets/cost.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::vector<std::string> executors{"serial", "threads:1", "threads:2"};
  bool quick = false;
};

struct Table {
  Json rows;
  std::string text;
};

struct Method {
  const char* name;
  SolverOptions options;
};

const std::array kMethods{Method{"default", {}},
                          Method{"projections", {.method = SolverMethod::projection}}};

Table compare_with_closed_forms(const Arguments& arguments) {
  const std::vector<Column> columns{{"method", "method", 0},     {"backend", "backend", 0},
                                    {"unit", "unit", 0},         {"value", "value", 4},
                                    {"expected", "expected", 4}, {"error_percent", "error, %", 2},
                                    {"source", "closed form", 0}};
  Json rows = Json::array();
  std::string text = "# Sheets at rest\n\n" + markdown_header("case", columns);
  for (const SheetCase& each : sheet_cases()) {
    for (const Method& method : kMethods) {
      for (const std::string& executor : arguments.executors) {
        SolverOptions options = method.options;
        options.executor = programs::executor_named(executor);
        const SheetOutcome outcome = each.run(options);
        rows.push_back(
            {{"case", each.name},
             {"method", method.name},
             {"backend", options.executor.name()},
             {"unit", each.unit},
             {"value", rounded(outcome.value, 1e5)},
             {"expected", rounded(outcome.expected, 1e5)},
             {"error_percent", rounded(100 * (outcome.value / outcome.expected - 1), 1e3)},
             {"source", each.source}});
        text += markdown_line(each.name, rows.back(), columns);
      }
    }
  }
  return {rows, text};
}

Table time_sweeps(const Arguments& arguments) {
  const std::vector<Column> columns{{"backend", "backend", 0},
                                    {"tetrahedron_ns", "tetrahedron, ns", 2},
                                    {"triangle", "triangle, tetrahedra", 2},
                                    {"bent", "bent at rest", 2},
                                    {"damped", "with inner friction", 2},
                                    {"without_hinge", "without hinges", 2}};
  Json rows = Json::array();
  std::string text = "\n# A sweep over sheets\n\n" + markdown_header("method", columns);
  for (const Method& method : kMethods) {
    for (const std::string& executor : arguments.executors) {
      SolverOptions options = method.options;
      options.executor = programs::executor_named(executor);
      const SheetCost cost = sheet_cost(options);
      rows.push_back({{"method", method.name},
                      {"backend", options.executor.name()},
                      {"tetrahedron_ns", rounded(cost.tetrahedron_ns, 1e2)},
                      {"triangle", rounded(cost.triangle, 1e2)},
                      {"bent", rounded(cost.bent_triangle, 1e2)},
                      {"damped", rounded(cost.damped_triangle, 1e2)},
                      {"without_hinge", rounded(cost.triangle_without_hinge, 1e2)}});
      text += markdown_line(method.name, rows.back(), columns);
    }
  }
  return {rows, text};
}

void run(Arguments arguments) {
  if (arguments.quick) {
    arguments.executors = {"threads:1"};
  }
  const Table forms = compare_with_closed_forms(arguments), costs = time_sweeps(arguments);
  const std::string text = forms.text + costs.text;
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "sheets", forms.rows, text);
  merge_into_json(arguments.out / "tables.json", "sheet_cost", costs.rows);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app(
      "What sheets come to at rest, against closed forms, and what a sweep over them costs.",
      "sheets");
  pbdsurg::bench::Arguments arguments;
  auto* const executors = app.add_option("--executor", arguments.executors,
                                         "such as threads:1 or cuda; may be several");
  app.add_flag("--quick", arguments.quick, "one thread")->excludes(executors);
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
