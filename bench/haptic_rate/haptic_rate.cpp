// SPDX-License-Identifier: Apache-2.0
// A simulation that feeds the servo of a hand itself: steps of 1 ms against the clock, each with
// contact, every second one with heat, for each hollow mesh of table 2. How many steps take longer
// than the millisecond that there is, how late the loop is, and whether the hand feels the force of
// a static solution.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"

#include "apps/support/executors.h"
#include "bench/haptic_rate/machine_control.h"
#include "bench/haptic_rate/rate_loop.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::string executor = "best", heat = "serial";
  double seconds = 15;
  std::vector<int> rows{1, 2, 3, 4, 5};
  bool quick = false;
};

constexpr double kLimit = 0.1;  // %, of steps that may take longer than they last

constexpr double kAbove = 2e-3, kDepth = 5e-3;           // m
constexpr double kQuiet = 1.3, kPress = 0.2, kRest = 2;  // s: until force is let in, and then
constexpr double kReach = 12e-3;                         // m, to either side
constexpr double kSwing = 4;                             // s, to and fro
constexpr double kWalking = 4;                           // s
constexpr double kWarmUp = 1;  // s: room is made, the device's program of heat is loaded

// Waits above until force is let in, presses, and rests. Against no clock.
RateStep press(RateLoop& loop) {
  RateStep last;
  const auto steps = std::lround((kQuiet + kPress + kRest) / RateLoop::kStep);
  for (long i = 0; i < steps; ++i) {
    const double pressed = (static_cast<double>(i) * RateLoop::kStep - kQuiet) / kPress;
    last = loop.step(-kAbove + std::clamp(pressed, 0.0, 1.0) * (kAbove + kDepth), 0, false);
  }
  return last;
}

struct Measured {
  std::vector<double> whole, heat, heated, reading, edit, solver, contact, servo, late;  // ms
  long over = 0, burning = 0, late_heats = 0, touching = 0;
  Index removed_tets = 0;
};

// Slides and burns, a step a millisecond.
Measured slide(RateLoop& loop, double seconds) {
  Measured measured;
  RealClock clock;
  const auto steps = std::lround((kWarmUp + seconds) / RateLoop::kStep);
  for (long i = 0; i < steps; ++i) {
    const double due = static_cast<double>(i) * RateLoop::kStep;
    const double way = kReach * std::sin(2 * std::numbers::pi * due / kSwing);
    clock.wait_until(due);
    const double late = clock.now() - due;
    const RateStep step = loop.step(kDepth, way, true);
    measured.removed_tets += step.removed_tets;
    if (due < kWarmUp) {
      continue;
    }
    measured.late.push_back(1e3 * late);
    measured.whole.push_back(step.whole_ms());
    measured.reading.push_back(step.reading_ms);
    measured.edit.push_back(step.edit_ms);
    measured.solver.push_back(step.solver_ms);
    measured.contact.push_back(step.contact_ms);
    measured.servo.push_back(step.servo_ms);
    if (step.heat_ms > 0) {
      measured.heat.push_back(step.heat_ms);
      measured.heated.push_back(step.heated_ms);
    }
    measured.over += step.whole_ms() > 1e3 * RateLoop::kStep ? 1 : 0;
    measured.burning += step.is_heated ? 1 : 0;
    measured.late_heats += step.is_heat_late ? 1 : 0;
    measured.touching += step.is_touching ? 1 : 0;
  }
  return measured;
}

double percent(long count, std::size_t of) {
  return 100 * static_cast<double>(count) / static_cast<double>(of);
}

Json measure(int row, const Arguments& arguments) {
  const std::vector<double> walks = walk_times(std::min(arguments.seconds, kWalking));
  RateLoop loop(row, programs::executor_named(arguments.executor),
                programs::executor_named(arguments.heat));
  const RateStep resting = press(loop);
  const Eigen::Vector3d force = resting.force.cast<double>();
  const auto [expected, farthest] = loop.rest();
  const Measured measured = slide(loop, arguments.seconds);
  const std::size_t count = measured.whole.size();
  if (2 * measured.touching < static_cast<long>(count) || measured.burning == 0) {
    throw Error("of " + std::to_string(count) + " steps, the tool touches in " +
                std::to_string(measured.touching) + " and heats in " +
                std::to_string(measured.burning));
  }
  const std::string backend = loop.solver().backend_name();
  const double over = percent(measured.over, count);
  const bool is_judged = backend.starts_with("cuda");
  const auto add = [](const std::vector<double>& times, double share) {
    return rounded(quantile(times, share), 1e3);
  };
  return {{"mesh", "table2:" + std::to_string(row)},
          {"tets", loop.solver().tissue().tets().size()},
          {"triangles", loop.triangle_count()},
          {"backend", backend},
          {"steps", count},
          {"step_ms", add(measured.whole, 0.5)},
          {"p99_ms", add(measured.whole, 0.99)},
          {"p999_ms", add(measured.whole, 0.999)},
          {"worst_ms", add(measured.whole, 1)},
          {"over_percent", rounded(over, 1e3)},
          {"limit_percent", kLimit},
          {"ok", is_judged ? Json(over <= kLimit) : Json()},
          {"heat_executor", arguments.heat},
          {"heat_ms", add(measured.heat, 0.5)},
          {"heat_p99_ms", add(measured.heat, 0.99)},
          {"heat_p999_ms", add(measured.heat, 0.999)},
          {"heat_worst_ms", add(measured.heat, 1)},
          {"burning_percent", rounded(percent(measured.burning, measured.heat.size()), 1e1)},
          {"heat_late_percent", rounded(percent(measured.late_heats, count / 2), 1e2)},
          {"heated_p999_ms", add(measured.heated, 0.999)},
          {"heated_worst_ms", add(measured.heated, 1)},
          {"reading_p999_ms", add(measured.reading, 0.999)},
          {"edit_ms", add(measured.edit, 0.5)},
          {"edit_p999_ms", add(measured.edit, 0.999)},
          {"solver_p999_ms", add(measured.solver, 0.999)},
          {"contact_p999_ms", add(measured.contact, 0.999)},
          {"solver_ms", add(measured.solver, 0.5)},
          {"contact_ms", add(measured.contact, 0.5)},
          {"servo_ms", add(measured.servo, 0.5)},
          {"late_ms", add(measured.late, 0.5)},
          {"late_p999_ms", add(measured.late, 0.999)},
          {"late_worst_ms", add(measured.late, 1)},
          {"walk_ms", add(walks, 0.5)},
          {"walk_p99_ms", add(walks, 0.99)},
          {"walk_p999_ms", add(walks, 0.999)},
          {"touching_percent", rounded(percent(measured.touching, count), 1e1)},
          {"removed_tets", measured.removed_tets},
          {"force_n", rounded(force.norm(), 1e4)},
          {"static_n", rounded(expected.norm(), 1e4)},
          {"error_percent", rounded(100 * (force - expected).norm() / expected.norm(), 1e2)},
          {"farthest_mm", rounded(1e3 * farthest, 1e3)},
          {"felt_n", rounded(double{resting.felt.computed.norm()}, 1e4)}};
}

constexpr const char* kLegend = R"(# Haptic rate

- steps of 1 ms against the clock, by default options and a drag of 20/s: a ball of 4 mm presses 5 mm deep into a hollow gallbladder of 15 kPa and slides 12 mm to either side in 4 s, with 30 W in every second step; the first second is not counted
- a step: from its start to the force that a hand gets; solver: with the edit that heat asks for, which a device hides; late: a step's start after it was due; the limit of the share above 1 ms is a GPU's
- heat: in a thread beside the steps, every second one starts it, but for those that take an edit of the last; where it is not ready (late, % of the times it was due), the next stands for a longer stretch; reading: positions for it; edit: of the solver's time; four tetrahedra shrink at most
- walk: 50,000 places in 1 MiB of memory, one every 2 ms before the steps begin: always the same work, whose long ones are the machine's
- force on the ball after it has rested for 2 s, before it burns, and that of the static solution of the same mesh by Newton's method in double precision; off by: the difference of the two vectors; felt: what the servo computes of it
)";

void run(const Arguments& arguments) {
  const std::vector<Column> columns{{"tets", "tets", 0},
                                    {"steps", "steps", 0},
                                    {"step_ms", "a step, ms", 3},
                                    {"p99_ms", "p99", 3},
                                    {"p999_ms", "p99.9", 3},
                                    {"worst_ms", "worst", 3},
                                    {"over_percent", "above 1 ms, %", 3},
                                    {"limit_percent", "limit, %", 1},
                                    {"ok", "ok", 0},
                                    {"heat_ms", "heat, ms", 3},
                                    {"heat_p99_ms", "p99", 3},
                                    {"heat_p999_ms", "p99.9", 3},
                                    {"heat_worst_ms", "worst", 3},
                                    {"heat_late_percent", "late, %", 2},
                                    {"heated_worst_ms", "longest stretch, ms", 1},
                                    {"reading_p999_ms", "reading p99.9, ms", 3},
                                    {"edit_p999_ms", "edit p99.9, ms", 3},
                                    {"solver_ms", "solver, ms", 3},
                                    {"solver_p999_ms", "p99.9", 3},
                                    {"contact_ms", "contact, ms", 3},
                                    {"contact_p999_ms", "p99.9", 3},
                                    {"servo_ms", "servo, ms", 3},
                                    {"late_ms", "late, ms", 3},
                                    {"late_p999_ms", "p99.9", 3},
                                    {"late_worst_ms", "worst", 3},
                                    {"walk_ms", "walk, ms", 3},
                                    {"walk_p99_ms", "p99", 3},
                                    {"walk_p999_ms", "p99.9", 3},
                                    {"removed_tets", "tets removed", 0},
                                    {"force_n", "force, N", 4},
                                    {"static_n", "static solution, N", 4},
                                    {"error_percent", "off by, %", 2},
                                    {"felt_n", "felt, N", 4}};
  Json rows = Json::array();
  std::string text;
  for (const int row : arguments.rows) {
    rows.push_back(measure(row, arguments));
    text = std::string(kLegend) + "- backend: " + text_of(rows[0]["backend"]) + "\n\n" +
           markdown_header("mesh", columns);
    for (const Json& each : rows) {
      text += markdown_line(text_of(each["mesh"]), each, columns);
    }
    write_table(arguments.out, "haptic_rate", rows, text);  // what there is, if one fails
    std::fprintf(stderr, "row %d: done\n", row);
  }
  std::fputs(text.c_str(), stdout);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("A simulation that feeds a servo at 1000 Hz, against the clock.", "haptic_rate");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor, "best, serial, threads:N or cuda")
      ->capture_default_str();
  app.add_option("--heat", arguments.heat, "who computes heat, as --executor")
      ->capture_default_str();
  app.add_option("--seconds", arguments.seconds, "against the clock, of each row")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--row", arguments.rows, "meshes of table 2")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  app.add_flag("--quick", arguments.quick, "row 1, 1 s: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out, [&] {
    if (arguments.quick) {
      arguments.rows = {1};
      arguments.seconds = 1;
    }
    pbdsurg::bench::run(arguments);
  });
}
