// SPDX-License-Identifier: Apache-2.0
// How exact a motion is for its time.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"

#include "apps/support/executors.h"
#include "bench/accuracy/peers.h"
#include "bench/accuracy/scenario.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

std::vector<std::string> all_methods() {
  std::vector<std::string> methods;
  for (const Setting& setting : make_settings()) {
    if (std::ranges::find(methods, setting.method) == methods.end()) {
      methods.emplace_back(setting.method);
    }
  }
  return methods;
}

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::vector<std::string> executors{"threads:1", "threads:2"};
  std::vector<int> rows{2, 5};  // of table 2
  std::vector<int> kilopascals{10, 250};
  std::vector<int> away{0, 1};  // m
  std::vector<double> steps_ms{0.2, 1, 5};
  std::vector<std::string> methods = all_methods();
  bool quick = false;
};

// Of substeps or sweeps.
Json number_of(int count) {
  return count == kAutomatic ? Json("automatic") : Json(count);
}

const char* integration_of(const SolverOptions& options) {
  return options.method == SolverMethod::explicit_steps ? "leapfrog"
         : options.integration == TimeIntegration::bdf2 ? "BDF2"
                                                        : "implicit Euler";
}

Json to_row(const Scenario& scenario, const Setting& setting, const std::string& executor,
            double step_ms, const Accuracy& measured) {
  return {{"scenario", scenario.name},
          {"mesh", scenario.mesh},
          {"away_m", scenario.away},
          {"step_ms", step_ms},
          {"method", setting.method},
          {"integration", integration_of(setting.options)},
          {"backend", executor},
          {"substeps", number_of(setting.options.substeps)},
          {"sweeps", number_of(setting.options.iterations)},
          {"over_relaxation", rounded(setting.options.over_relaxation, 100)},
          {"ms", rounded(measured.ms, 1e3)},
          {"error_mm", rounded(measured.error_mm, 1e6)},
          {"tip_mm", rounded(measured.tip_mm, 1e6)},
          {"energy", rounded(measured.energy, 1e3)},
          {"ours", true}};
}

std::string label_of(const Json& row) {
  return text_of(row["scenario"]) + ", " + text_of(row["mesh"]) + ", " + text_of(row["away_m"]) +
         " m away";
}

// Those of all meshes, materials and places. References take a core each.
std::vector<Scenario> make_scenarios(const Arguments& arguments) {
  std::vector<std::future<Scenario>> at_origin;
  for (const int row : arguments.rows) {
    for (const int kilopascals : arguments.kilopascals) {
      at_origin.push_back(std::async(std::launch::async, [=, quick = arguments.quick] {
        const double substep = quick ? 1e-5 : kilopascals > 10 ? 2e-6 : 5e-6;
        return Scenario(table2_mesh(row, Table2Kind::hollow), "table2:" + std::to_string(row),
                        1e3 * kilopascals, substep, quick);
      }));
    }
  }
  std::vector<Scenario> scenarios;
  for (std::future<Scenario>& each : at_origin) {
    const Scenario scenario = each.get();
    std::fprintf(stderr, "reference of %s, %s: done\n", scenario.name.c_str(),
                 scenario.mesh.c_str());
    for (const int away : arguments.away) {
      scenarios.push_back(scenario.moved(away));
    }
  }
  return scenarios;
}

std::vector<Setting> chosen_settings(const Arguments& arguments) {
  std::vector<Setting> settings = make_settings();
  std::erase_if(settings, [&](const Setting& setting) {
    return std::ranges::find(arguments.methods, setting.method) == arguments.methods.end();
  });
  return settings;
}

void leave_out(const Scenario& scenario, const Setting& setting, double step_ms,
               const InvalidArgument& refused) {
  std::fprintf(stderr, "%s, %s, %s, steps of %g ms: left out: %s\n", scenario.name.c_str(),
               scenario.mesh.c_str(), setting.method, step_ms, refused.what());
}

Json measure_all(const Arguments& arguments) {
  const std::vector<Setting> settings = chosen_settings(arguments);
  Json rows = Json::array();
  for (const Scenario& scenario : make_scenarios(arguments)) {
    for (const double step_ms : arguments.steps_ms) {
      if (step_ms > 1e3 * scenario.seconds) {
        continue;
      }
      for (const Setting& setting : settings) {
        for (const std::string& name : arguments.executors) {
          SolverOptions options = setting.options;
          options.executor = programs::executor_named(name);
          try {
            rows.push_back(to_row(scenario, setting, name, step_ms,
                                  measure(scenario, options, 1e-3 * step_ms)));
          } catch (const InvalidArgument& refused) {  // explicit substeps that are too long
            leave_out(scenario, setting, step_ms, refused);
          }
        }
      }
    }
    std::fprintf(stderr, "%s, %s, %.0f m away: done\n", scenario.name.c_str(),
                 scenario.mesh.c_str(), scenario.away);
  }
  if (rows.empty()) {
    throw InvalidArgument("all steps are longer than the motion");
  }
  return rows;
}

void run(Arguments arguments) {
  if (arguments.quick) {
    arguments.rows = {1};
    arguments.kilopascals = {10};
    arguments.away = {0};
  }
  const std::vector<Column> columns{{"step_ms", "step, ms", 1},
                                    {"method", "method", 0},
                                    {"integration", "integration", 0},
                                    {"substeps", "substeps", 0},
                                    {"sweeps", "sweeps", 0},
                                    {"over_relaxation", "over-relaxation", 1},
                                    {"backend", "executor", 0},
                                    {"ms", "ms a step", 2},
                                    {"error_mm", "RMS error, mm", 3},
                                    {"tip_mm", "tip, mm", 3},
                                    {"energy", "energy over the start's", 2}};
  Json rows = measure_all(arguments);
  const Peers peers = peers_beside(rows);
  rows.insert(rows.end(), peers.rows.begin(), peers.rows.end());
  std::string text =
      "# Accuracy\n\n- a hollow gallbladder of table 2, stretched by 10 %, is let go and swings "
      "under its weight for 40 ms, without drag; Poisson's ratio 0.45\n- error: RMS distance of "
      "all vertices from velocity Verlet in double precision on the same mesh; it moves by some 10 "
      "mm\n- tip: distance of the mean of the twentieth that is furthest from the hold\n- do not "
      "tune by the error of one row: two errors may cancel\n" +
      peers.notes + "\n" + markdown_header("scenario", columns);
  for (const Json& row : rows) {
    text += markdown_line(label_of(row), row, columns);
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "accuracy", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("How exact a motion is for its time.", "accuracy");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executors, "such as threads:1 or cuda; may be several");
  app.add_option("--row", arguments.rows, "meshes of table 2")->check(CLI::Range(1, 5));
  app.add_option("--kpa", arguments.kilopascals, "Young's moduli")->check(CLI::IsMember({10, 250}));
  app.add_option("--away", arguments.away, "distances from the origin along each axis, m")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--step-ms", arguments.steps_ms, "lengths of a step")->check(CLI::PositiveNumber);
  app.add_option("--method", arguments.methods, "those of all settings")
      ->check(CLI::IsMember(arguments.methods));
  app.add_flag("--quick", arguments.quick, "row 1, 10 kPa, at the origin, 4 ms: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
