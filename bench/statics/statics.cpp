// SPDX-License-Identifier: Apache-2.0
// What tissue does at rest, against a static solution of the same mesh.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/statics/cases.h"
#include "bench/statics/measure.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  bool quick = false;
};

constexpr double kStepOfSweeps = 5;  // ms, with which numbers of sweeps are compared
constexpr double kShortestNamed =
    1;                        // ms, of what is not the default: its numbers fit no shorter one
constexpr int kFadings = 20;  // times in which the slowest mode fades by a factor of e
constexpr int kFadingsOfSweeps = 80;  // half the sweeps take longer to come to rest
constexpr double kMostSpread = 2;     // %, of stiffness at rest
constexpr const char* kDefault = "default";

struct NamedOptions {
  std::string name;
  SolverOptions options;
};

std::vector<NamedOptions> named_options() {
  const auto corrected = [](int substeps, int sweeps) {
    return SolverOptions{.method = SolverMethod::vertex_block,
                         .substeps = substeps,
                         .iterations = sweeps,
                         .coarse_correction = CoarseCorrection::on};
  };
  return {{"small steps, 10 x 1",
           {.method = SolverMethod::projection, .substeps = 10, .iterations = 1}},
          {"vertex blocks, 1 x 10",
           {.method = SolverMethod::vertex_block, .substeps = 1, .iterations = 10}},
          {"coarse correction, 1 x 2", corrected(1, 2)},
          {"coarse correction, 4 x 2", corrected(4, 2)}};
}

// With half to four times the sweeps of a step that the default chose: half of them in each
// substep, or in half of the substeps where these have the fewest that they can.
std::vector<NamedOptions> numbers_of_sweeps(const Outcome& chosen) {
  const auto with = [&](int substeps, int sweeps) {
    return SolverOptions{.method = chosen.method,
                         .substeps = substeps,
                         .iterations = sweeps,
                         .coarse_correction = chosen.correction};
  };
  const auto [substeps, sweeps] = chosen.division;
  const int fewest = chosen.correction == CoarseCorrection::on ? 2 : 1;
  std::vector<NamedOptions> result;
  if (sweeps >= 2 * fewest) {
    result.push_back({"half the default's sweeps", with(substeps, sweeps / 2)});
  } else if (substeps > 1) {
    result.push_back({"half the default's sweeps", with(substeps / 2, sweeps)});
  }
  result.push_back({"the default's sweeps", with(substeps, sweeps)});
  result.push_back({"twice the default's sweeps", with(substeps, 2 * sweeps)});
  result.push_back({"four times the default's sweeps", with(substeps, 4 * sweeps)});
  return result;
}

const char* name_of(SolverMethod method) {
  switch (method) {
    case SolverMethod::automatic:
      break;
    case SolverMethod::projection:
      return "projections";
    case SolverMethod::vertex_block:
      return "vertex blocks";
    case SolverMethod::explicit_steps:
      return "explicit steps";
  }
  return "automatic";
}

// A case with its static solution, and the rows of it.
class CaseRows {
 public:
  explicit CaseRows(const Case& each) : case_(each), expected_(expected_value(each)) {}

  Outcome add(const NamedOptions& how, double step_ms, int fadings = kFadings) {
    const double seconds = fadings * std::max(0.01, 2 / case_.drag);
    const Outcome outcome = measure(case_, how.options, 1e-3 * step_ms, seconds);
    std::optional<double> mesh;
    if (case_.closed_form) {
      mesh = 100 * (expected_ / *case_.closed_form - 1);
    }
    rows_.push_back({{"case", case_.name},
                     {"options", how.name},
                     {"method", name_of(outcome.method)},
                     {"step_ms", step_ms},
                     {"seconds", rounded(seconds, 1e2)},
                     {"substeps", outcome.division.substeps},
                     {"sweeps", outcome.division.sweeps},
                     {"unit", case_.unit()},
                     {"value", rounded(outcome.value, 1e5)},
                     {"expected", rounded(expected_, 1e5)},
                     {"closed_form", rounded(case_.closed_form, 1e5)},
                     {"error_percent", rounded(100 * (outcome.value / expected_ - 1), 1e2)},
                     {"mesh_percent", rounded(mesh, 1e2)},
                     {"drift_percent", rounded(100 * outcome.change, 1e2)}});
    return outcome;
  }

  void measure_all() {
    for (const double step_ms : case_.steps_ms) {
      const Outcome chosen = add({kDefault, {}}, step_ms);
      if (step_ms == kStepOfSweeps) {
        for (const NamedOptions& how : numbers_of_sweeps(chosen)) {
          add(how, step_ms, kFadingsOfSweeps);
        }
      }
    }
    for (const NamedOptions& how : named_options()) {
      for (const double step_ms : case_.steps_ms) {
        if (step_ms >= kShortestNamed) {
          add(how, step_ms);
        }
      }
    }
  }

  [[nodiscard]] const Json& rows() const { return rows_; }

  // %, of the values of some rows; nothing of one value.
  template <class IsIn>
  [[nodiscard]] double spread(const IsIn& is_in) const {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Json& row : rows_) {
      if (is_in(row)) {
        least = std::min(least, row["error_percent"].get<double>());
        most = std::max(most, row["error_percent"].get<double>());
      }
    }
    return most - least;
  }

 private:
  const Case& case_;
  double expected_;
  Json rows_ = Json::array();
};

// The largest spread of all cases, as a line of the table's text.
class Check {
 public:
  explicit Check(std::string what) : what_(std::move(what)) {}

  void add(const std::string& name, double spread) {
    if (spread > worst_) {
      worst_ = spread;
      name_ = name;
    }
  }

  [[nodiscard]] std::string text() const {
    char number[32];
    std::snprintf(number, sizeof number, "%.2f", worst_);
    return "- " + std::string(worst_ <= kMostSpread ? "met" : "missed") +
           ": stiffness at rest is the same within 2 % " + what_ + ": " + number +
           " % at most, of " + name_ + "\n";
  }

 private:
  std::string what_;
  std::string name_;
  double worst_ = -1;
};

void run(const Arguments& arguments) {
  const std::vector<Column> columns{{"options", "options", 0},
                                    {"method", "method", 0},
                                    {"step_ms", "step, ms", 1},
                                    {"substeps", "substeps", 0},
                                    {"sweeps", "sweeps", 0},
                                    {"unit", "unit", 0},
                                    {"value", "value", 3},
                                    {"expected", "static solution", 3},
                                    {"closed_form", "closed form", 3},
                                    {"error_percent", "error, %", 2},
                                    {"mesh_percent", "of the mesh, %", 2},
                                    {"drift_percent", "in motion still, %", 2}};
  Json rows = Json::array();
  Check steps("in steps of 0.2 to 16 ms");
  Check sweeps("for half to four times the default's sweeps");
  for (const Case& each : make_cases(arguments.quick)) {
    CaseRows measured(each);
    measured.measure_all();
    rows.insert(rows.end(), measured.rows().begin(), measured.rows().end());
    steps.add(each.name, measured.spread([](const Json& row) {
      return row["options"] == kDefault && row["step_ms"] <= 16;
    }));
    sweeps.add(each.name, measured.spread([](const Json& row) {
      return text_of(row["options"]).ends_with("the default's sweeps");
    }));
    std::fprintf(stderr, "%s: done\n", each.name.c_str());
  }
  std::string text =
      "# Statics\n\n- value: how far what hangs has sagged, in mm, the force on a tool along its "
      "way, in N, or the moment that turns, in mN mm; the mean of the last tenth of a run\n"
      "- static solution: by Newton's method in double precision, on the same mesh, of the same "
      "energy; error: of the value\n- closed form: of the body that the mesh stands for, at small "
      "strain; of the mesh: how far the static solution is from it\n- in motion still: by how "
      "much the last tenth differs from the tenth before\n- a run takes 20 times that in which the "
      "slowest mode fades by a factor of e; where numbers of sweeps are compared, 80 times\n- drag "
      "near critical; what rests does "
      "not feel it\n" +
      steps.text() + sweeps.text() + "\n" + markdown_header("case", columns);
  for (const Json& row : rows) {
    text += markdown_line(text_of(row["case"]), row, columns);
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "statics", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("What tissue does at rest, against a static solution of the same mesh.", "statics");
  pbdsurg::bench::Arguments arguments;
  app.add_flag("--quick", arguments.quick, "three bars: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
