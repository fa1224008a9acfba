// SPDX-License-Identifier: Apache-2.0
// The demo: a scripted laparoscopic cholecystectomy, without a display.
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/core/error.h"

#include "organ_files.h"
#include "procedure.h"
#include "recorders.h"
#include "report.h"
#include "simulation.h"
#include "surgical_scene.h"
#ifdef PBDSURG_HAS_PICTURES
#include "pictures.h"
#endif

namespace cholecystectomy {
namespace {

struct Arguments {
  bool headless = false;
  std::filesystem::path out = "out";
  std::map<pbdsurg::Organ, std::filesystem::path> organs;
  pbdsurg::LengthUnit unit = pbdsurg::LengthUnit::automatic;
  std::uint64_t seed = 1;
  double time_scale = 1;
  bool paper = false;
  bool no_pictures = false;
};

// Small steps, with the damping of living tissue; or the paper's solver.
pbdsurg::SolverOptions solver_options(bool paper) {
  pbdsurg::SolverOptions options =
      paper ? pbdsurg::SolverOptions::paper() : pbdsurg::SolverOptions{};
  options.damping = 60;
  return options;
}

int run(const Arguments& arguments) {
  std::filesystem::create_directories(arguments.out);
  StageTimes times;
  const auto timed = [&](const char* stage, auto&& make) {
    const StageTimer timer(times, stage);
    return make();
  };
  const LoadedAnatomy loaded =
      timed("anatomy", [&] { return load_anatomy(arguments.organs, arguments.unit); });
  for (const std::string& note : loaded.notes) {
    std::fprintf(stderr, "%s\n", note.c_str());
  }
  const SurgicalScene scene = timed("scene", [&] { return make_scene(loaded.anatomy); });
  Simulation simulation = timed("initialisation", [&] {
    return Simulation(scene, solver_options(arguments.paper), arguments.seed, times);
  });
  for (const pbdsurg::Body& body : scene.scene.bodies()) {
    std::fprintf(stderr, "%-17s %6d vertices %6d tetrahedra\n", body.name.c_str(),
                 body.vertex_count, body.tet_count);
  }

  ForceRecorder forces(arguments.out / "force.csv");
  CauteryRecorder cautery(arguments.out / "cautery.csv");
  SeriesRecorder series(arguments.out / "series.pvd");
  ProgressRecorder progress;
  std::vector<Observer*> observers{&forces, &cautery, &series, &progress};
  std::string pictures = "no pictures";
#ifdef PBDSURG_HAS_PICTURES
  std::optional<PictureRecorder> recorder;
  if (!arguments.no_pictures) {
    try {
      recorder.emplace(arguments.out, loaded.anatomy.abdominal_wall);
      observers.push_back(&*recorder);
    } catch (const pbdsurg::BackendUnavailable& error) {
      pictures += std::string(" (") + error.what() + ")";
    }
  }
#else
  pictures += " (built without EGL, libepoxy or stb)";
#endif

  const Recovery recovery = run_procedure(simulation, observers, arguments.time_scale);
  forces.close();
  cautery.close();
#ifdef PBDSURG_HAS_PICTURES
  if (!arguments.no_pictures) {
    draw_plots(arguments.out, forces, recovery);
  }
  if (recorder) {
    pictures = std::to_string(recorder->files.size()) + " pictures " +
               recorder->files.front().string() + " to " + recorder->files.back().string();
  }
#endif
  const pbdsurg::Index inverted = simulation.totals.inverted_tets_max;
  if (100 * inverted > static_cast<pbdsurg::Index>(scene.scene.tets().size())) {
    std::fprintf(stderr,
                 "warning: up to %d tetrahedra were inverted at one time, more than one in a "
                 "hundred; does `pbdsurg mesh check` find slivers in an organ of yours?\n",
                 inverted);
  }
  const std::filesystem::path report = arguments.out / "report.json";
  write_report(report, simulation, recovery, arguments.seed, loaded.notes);
  std::printf("wrote %s and the report %s\n", pictures.c_str(), report.c_str());
  return 0;
}

}  // namespace
}  // namespace cholecystectomy

int main(int argc, char** argv) {
  using pbdsurg::LengthUnit;
  CLI::App app("A scripted laparoscopic cholecystectomy: drag, burn, separate.");
  cholecystectomy::Arguments arguments;
  std::vector<std::string> organs;
  app.add_flag("--headless", arguments.headless,
               "run the scripted operation without a display (there is no other mode yet)")
      ->required();
  app.add_option("--out", arguments.out, "folder for pictures, report.json, force.csv, series.pvd")
      ->capture_default_str();
  app.add_option("--organ", organs, "NAME=FILE: use this mesh for an organ (repeatable)")
      ->allow_extra_args(false)
      ->type_name("");
  const std::map<std::string, LengthUnit> units{{"auto", LengthUnit::automatic},
                                                {"mm", LengthUnit::millimetre},
                                                {"cm", LengthUnit::centimetre},
                                                {"m", LengthUnit::metre}};
  app.add_option("--unit", arguments.unit, "of these files")
      ->transform(CLI::CheckedTransformer(units).description("auto|mm|cm|m"))
      ->default_str("auto")
      ->type_name("");
  app.add_option("--seed", arguments.seed, "of the hands' tremor")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--time-scale", arguments.time_scale,
                 "length of the operation relative to the full script")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  app.add_flag("--no-pictures", arguments.no_pictures, "leave out pictures and plots");
  app.add_flag(
      "--paper", arguments.paper,
      "the paper's solver: one substep, 30 iterations, stiffness fractions, colours by the "
      "random colouring disc");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    for (const std::string& organ : organs) {
      const std::size_t equals = organ.find('=');
      if (equals == std::string::npos || equals == 0 || equals + 1 == organ.size()) {
        throw pbdsurg::InvalidArgument("--organ " + organ + ": expected NAME=FILE");
      }
      const pbdsurg::Organ name = cholecystectomy::find_organ(organ.substr(0, equals));
      if (!arguments.organs.emplace(name, organ.substr(equals + 1)).second) {
        throw pbdsurg::InvalidArgument("--organ " + organ + ": this organ is given twice");
      }
    }
    return cholecystectomy::run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cholecystectomy: %s\n", error.what());
    return 2;
  }
}
