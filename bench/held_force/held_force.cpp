// SPDX-License-Identifier: Apache-2.0
// The force with which tissue pulls at the demo's grasper at the end of the drag, against the
// static solution of the same scene, with what is held where it is then.
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/surgical_scene.h"
#include "apps/support/executors.h"
#include "bench/support/program.h"
#include "bench/support/static_energy.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::Simulation;

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::string executor = "best";
};

// Ends the procedure at the moment that is compared.
struct Held {};

class HoldRecorder final : public cholecystectomy::Observer {
 public:
  void step(const Simulation& simulation, double /*progress*/) override {
    const double solved = simulation.times["solve"];
    step_times.push_back(solved - solved_);
    solved_ = solved;
  }
  void moment(const Simulation& /*simulation*/, const std::string& name) override {
    if (name == "drag_000ms") {
      throw Held{};
    }
  }

  std::vector<double> step_times;  // ms

 private:
  double solved_ = 0;
};

void run(const Arguments& arguments) {
  const cholecystectomy::SurgicalScene scene =
      cholecystectomy::make_scene(cholecystectomy::load_anatomy({}), ElasticModel::neo_hookean);
  cholecystectomy::StageTimes times;
  Simulation simulation(
      scene, cholecystectomy::solver_options(programs::executor_named(arguments.executor), false),
      1, times);
  simulation.world.clear_contact(
      cholecystectomy::body_of(Organ::gallbladder),
      cholecystectomy::body_of(Organ::liver));  // the static solution has none
  HoldRecorder recorder;
  cholecystectomy::Observer* const observers[] = {&recorder};
  bool is_held = false;
  try {
    cholecystectomy::run_procedure(simulation, observers, 1);
  } catch (const Held&) {
    is_held = true;
  }
  if (!is_held || simulation.totals.links_cut > 0) {
    throw Error("the drag did not come to its end with all strands whole");
  }

  const auto [expected, farthest] =
      rest_with_held(scene.scene, simulation.grasper.held, simulation.solver.positions());
  const Eigen::Vector3d force = simulation.world.force(simulation.grasper.tool).cast<double>();

  const std::vector<Column> columns{{"tets", "tets", 0},
                                    {"links", "links", 0},
                                    {"step_ms", "a step, ms", 2},
                                    {"force_n", "force, N", 3},
                                    {"static_n", "static solution, N", 3},
                                    {"error_percent", "off by, %", 1},
                                    {"farthest_mm", "farthest vertex off, mm", 2}};
  const Json row{{"tets", scene.scene.tets().size()},
                 {"links", scene.scene.links().size()},
                 {"plan", simulation.solver.plan().name},
                 {"backend", simulation.solver.backend_name()},
                 {"step_ms", rounded(median(recorder.step_times), 1e3)},
                 {"force_n", rounded(force.norm(), 1e4)},
                 {"static_n", rounded(expected.norm(), 1e4)},
                 {"error_percent", rounded(100 * (force - expected).norm() / expected.norm(), 1e2)},
                 {"farthest_mm", rounded(1e3 * farthest, 1e3)}};
  const std::string text =
      "# Held force\n\n- force of tissue on the demo's grasper at the end of the drag, after half "
      "a "
      "second at rest, and that in the static solution by Newton's method in double precision; off "
      "by: the difference of the two vectors\n- a step of 5 ms: the solver alone, the median of "
      "the "
      "demo until then\n\n" +
      markdown_header("scene", columns) + markdown_line("the demo's", row, columns);
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "held_force", Json::array({row}), text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("The demo's force on its grasper, against a static solution.", "held_force");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor, "who steps, as the demo's option has it")
      ->capture_default_str();
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
