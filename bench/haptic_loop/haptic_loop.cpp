// SPDX-License-Identifier: Apache-2.0
// A loop of 1 kHz: a tool drags an organ around for minutes. Once in each of these it stops, and
// the force on it is compared with that of the static solution, of the same mesh and energy, with
// what is held where it is then. Would find what drifts, heats up or bursts in half a million
// steps.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/solver/solver.h"

#include "apps/support/executors.h"
#include "bench/support/neo_hookean.h"
#include "bench/support/paper_step.h"
#include "bench/support/program.h"
#include "bench/support/static_energy.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::string executor = "best";
  double minutes = 10;
  int row = 2;
  bool quick = false;
};

constexpr float kStep = 1e-3F;        // s
constexpr double kMinute = 60;        // s
constexpr double kStop = 3;           // s, at the end of each minute, or a half of what there is
constexpr double kReach = 0.012;      // m
constexpr double kGraspReach = 6e-3;  // m, from the organ's tip
constexpr float kDrag = 20;           // 1/s, as in the demo: it stands for the organs around

// m, where the tool is after it has moved for so long: the same way again after 100 s.
Eigen::Vector3d way_after(double seconds) {
  const auto swing = [&](double hertz) { return std::sin(2 * std::numbers::pi * hertz * seconds); };
  return kReach * Eigen::Vector3d(swing(0.37), swing(0.53), swing(0.71));
}

std::vector<Index> vertices_at_tip(const Scene& scene) {
  Index tip = 0;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    tip = scene.positions()[v].x() > scene.positions()[tip].x() ? v : tip;
  }
  std::vector<Index> vertices;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if ((scene.positions()[v] - scene.positions()[tip]).norm() < kGraspReach) {
      vertices.push_back(v);
    }
  }
  return vertices;
}

Json compare(Solver& solver, const Scene& scene, ToolId tool, const std::vector<Index>& held) {
  const auto [expected, farthest] = rest_with_held(scene, held, solver.positions());
  const Eigen::Vector3d force = solver.tool_force(tool).cast<double>();
  return {{"force_n", rounded(force.norm(), 1e4)},
          {"static_n", rounded(expected.norm(), 1e4)},
          {"error_percent", rounded(100 * (force - expected).norm() / expected.norm(), 1e2)},
          {"farthest_mm", rounded(1e3 * farthest, 1e3)}};
}

void run(const Arguments& arguments) {
  const Scene scene =
      make_organ_scene(table2_mesh(arguments.row, Table2Kind::hollow), neo_hookean(10e3, 0.45));
  SolverOptions options{.damping = kDrag};
  options.executor = programs::executor_named(arguments.executor);
  Solver solver(scene, options);
  const std::vector<Index> held = vertices_at_tip(scene);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, held);

  const double seconds = kMinute * std::min(1.0, arguments.minutes);  // to a stop and from it
  const double stop = std::min(kStop, seconds / 2);
  const auto rounds = std::max(1L, std::lround(arguments.minutes));
  const auto steps_of_round = std::lround(seconds / double{kStep});
  Json rows = Json::array();
  double moved = 0;  // s, for which the tool has moved
  for (long round = 1; round <= rounds; ++round) {
    std::vector<double> times;
    Index non_finite = 0;
    for (long i = 1; i <= steps_of_round; ++i) {
      // slows down within a tenth of the stop
      const double left = seconds - stop - static_cast<double>(i) * double{kStep};
      moved += double{kStep} * std::clamp(1 + 10 * left / stop, 0.0, 1.0);
      ToolPose pose = ToolPose::Identity();
      pose.translation() = way_after(moved).cast<float>();
      times.push_back(time_of([&] {
        solver.move_tool(tool, pose);
        non_finite = std::max(non_finite, solver.step(kStep).non_finite_vertices);
      }));
    }
    Json row = compare(solver, scene, tool, held);
    row["mesh"] = "table2:" + std::to_string(arguments.row);
    row["plan"] = solver.plan().name;
    row["backend"] = solver.backend_name();
    row["minutes"] = rounded(static_cast<double>(round) * seconds / kMinute, 1e3);
    row["step_ms"] = rounded(median(times), 1e3);
    row["p99_ms"] = rounded(quantile(times, 0.99), 1e3);
    row["non_finite"] = non_finite;
    rows.push_back(row);
    std::fprintf(stderr, "%.3g minutes: done\n", static_cast<double>(round) * seconds / kMinute);
  }

  const std::vector<Column> columns{
      {"step_ms", "a step, ms", 3},      {"p99_ms", "p99", 3},
      {"force_n", "force, N", 4},        {"static_n", "static solution, N", 4},
      {"error_percent", "off by, %", 2}, {"farthest_mm", "farthest vertex off, mm", 3}};
  std::string text =
      "# Haptic loop\n\n- a tool drags an organ of 10 kPa around in steps of 1 ms, by default "
      "options and a drag of 20/s; after each minute, or the time there is, it has stood still for "
      "3 s, or half of that\n- force on the tool, and that in the static solution by Newton's "
      "method in double precision; off by: the difference of the two vectors\n\n" +
      markdown_header("minutes", columns);
  for (const Json& row : rows) {
    text += markdown_line(text_of(row["minutes"]), row, columns);
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "haptic_loop", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("The force on a tool in a loop of 1 kHz, against a static solution.", "haptic_loop");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor, "best, threads:N or cuda")
      ->capture_default_str();
  app.add_option("--minutes", arguments.minutes, "simulated; a part of one, or whole ones")
      ->check(CLI::PositiveNumber)
      ->check([](const std::string& text) {
        const double minutes = std::stod(text);
        return minutes > 1 && minutes != std::floor(minutes)
                   ? text + " is more than one and not whole"
                   : std::string();
      })
      ->capture_default_str();
  app.add_flag("--quick", arguments.quick, "row 1, 3 s: to see it work");
  app.add_option("--row", arguments.row, "mesh of table 2")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out, [&] {
    if (arguments.quick) {
      arguments.row = 1;
      arguments.minutes = 0.05;
    }
    pbdsurg::bench::run(arguments);
  });
}
