// SPDX-License-Identifier: Apache-2.0
// Tools that meet surfaces, by each method, against closed forms and fine meshes, and what contact
// costs.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/support/executors.h"
#include "bench/contact/cases.h"
#include "bench/contact/cost.h"
#include "bench/contact/grasp_cases.h"
#include "bench/contact/hook_cases.h"
#include "bench/contact/rest_cases.h"
#include "bench/contact/sheet_cases.h"
#include "bench/support/gpu_times.h"
#include "bench/support/paper_step.h"
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

struct Table {
  Json rows;
  std::string text;
};

Table compare_with_closed_forms(const Arguments& arguments) {
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
  std::ranges::move(sheet_cases(), std::back_inserter(cases));
  std::ranges::move(grasp_cases(), std::back_inserter(cases));
  std::ranges::move(hook_cases(), std::back_inserter(cases));
  std::ranges::move(rest_cases(), std::back_inserter(cases));
  for (const ContactCase& each : cases) {
    if (arguments.quick && !each.is_quick) {
      continue;
    }
    for (const Method& method : kMethods) {
      SolverOptions options = method.options;
      options.executor = programs::executor_named(arguments.executor);
      ContactOutcome outcome;
      try {
        outcome = each.run(options);
      } catch (const BackendUnavailable& error) {
        std::fprintf(stderr, "left out: %s, %s: %s\n", each.name.c_str(), method.name,
                     error.what());
        continue;
      }
      const double limit =
          each.limit_percent *
          (method.options.method == SolverMethod::projection ? each.of_projections : 1);
      rows.push_back({{"case", each.name},
                      {"method", method.name},
                      {"backend", options.executor.name()},
                      {"unit", each.unit},
                      {"value", rounded(outcome.value, 1e7)},
                      {"expected", rounded(outcome.expected, 1e7)},
                      {"error_percent", rounded(outcome.error_percent, 1e4)},
                      {"limit_percent", limit},
                      {"is_within", std::abs(outcome.error_percent) <= limit ? "yes" : "no"},
                      {"source", each.source}});
      const std::string line = markdown_line(each.name, rows.back(), columns);
      std::fputs(line.c_str(), stdout);
      std::fflush(stdout);
      text += line;
    }
  }
  return {rows, text};
}

Table time_contact(const Arguments& arguments) {
  const std::vector<Column> columns{{"method", "method", 0},
                                    {"backend", "backend", 0},
                                    {"us", "us", 0},
                                    {"share_of_step", "share of the step", 2},
                                    {"contacts", "contacts", 0}};
  Json rows = Json::array();
  std::string text = "\n# What contact adds to a step of liver and gallbladder\n\n" +
                     markdown_header("stage", columns);
  std::fputs(text.c_str(), stdout);
  std::vector<Executor> executors{executor::threads(1)};
  if (!why_no_gpu()) {
    executors.push_back(programs::device());
  }
  const std::array subjects{
      CostSubject{"default", {}, ElasticModel::neo_hookean, 5e-3F},
      CostSubject{"paper", SolverOptions::paper(), ElasticModel::springs, kPaperTimeStep}};
  for (CostSubject subject : subjects) {
    for (const Executor& executor : executors) {
      subject.options.executor = executor;
      for (const ContactCost& cost : contact_costs(subject, arguments.quick ? 5 : 60)) {
        rows.push_back({{"scene", "liver and gallbladder"},
                        {"stage", cost.stage},
                        {"method", subject.method},
                        {"backend", executor.name()},
                        {"us", rounded(cost.us, 10)},
                        {"share_of_step", rounded(cost.share, 1e3)},
                        {"contacts", cost.contacts}});
        const std::string line = markdown_line(cost.stage, rows.back(), columns);
        std::fputs(line.c_str(), stdout);
        std::fflush(stdout);
        text += line;
      }
    }
  }
  return {rows, text};
}

void run(const Arguments& arguments) {
  const Table forms = compare_with_closed_forms(arguments), costs = time_contact(arguments);
  write_table(arguments.out, "contact", forms.rows, forms.text + costs.text);
  merge_into_json(arguments.out / "tables.json", "contact_cost", costs.rows);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Tools that meet surfaces, against closed forms and fine meshes, and what contact costs.",
      "contact");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor, "such as serial, threads or threads:1");
  app.add_flag("--quick", arguments.quick, "cases of seconds");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
