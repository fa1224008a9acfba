// SPDX-License-Identifier: Apache-2.0
// Tools that meet surfaces, by each method, against closed forms and fine meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "apps/support/executors.h"
#include "bench/contact/cases.h"
#include "bench/contact/grasp_cases.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::string executor = "threads";
  bool quick = false;
};

struct Method {
  const char* name;
  SolverOptions options;
};

const std::array kMethods{Method{"default", {}},
                          Method{"projections", {.method = SolverMethod::projection}}};

void run(const Arguments& arguments) {
  const std::vector<Column> columns{{"method", "method", 0},
                                    {"backend", "backend", 0},
                                    {"unit", "unit", 0},
                                    {"value", "value", 5},
                                    {"expected", "expected", 5},
                                    {"error_percent", "error, %", 3},
                                    {"limit_percent", "limit, %", 1},
                                    {"is_within", "within", 0},
                                    {"source", "expected by", 0}};
  Json rows = Json::array();
  std::string text = "# Contact\n\n" + markdown_header("case", columns);
  std::fputs(text.c_str(), stdout);
  std::vector<ContactCase> cases = contact_cases();
  std::ranges::move(grasp_cases(), std::back_inserter(cases));
  for (const ContactCase& each : cases) {
    if (arguments.quick && !each.is_quick) {
      continue;
    }
    for (const Method& method : kMethods) {
      SolverOptions options = method.options;
      options.executor = programs::executor_named(arguments.executor);
      const ContactOutcome outcome = each.run(options);
      rows.push_back(
          {{"case", each.name},
           {"method", method.name},
           {"backend", options.executor.name()},
           {"unit", each.unit},
           {"value", rounded(outcome.value, 1e7)},
           {"expected", rounded(outcome.expected, 1e7)},
           {"error_percent", rounded(outcome.error_percent, 1e4)},
           {"limit_percent", each.limit_percent},
           {"is_within", std::abs(outcome.error_percent) <= each.limit_percent ? "yes" : "no"},
           {"source", each.source}});
      const std::string line = markdown_line(each.name, rows.back(), columns);
      std::fputs(line.c_str(), stdout);
      std::fflush(stdout);
      text += line;
    }
  }
  write_table(arguments.out, "contact", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Tools that meet surfaces, against closed forms and fine meshes.", "contact");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor, "such as serial, threads or threads:1");
  app.add_flag("--quick", arguments.quick, "cases of seconds");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
