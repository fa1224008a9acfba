// SPDX-License-Identifier: Apache-2.0
// The demo: a laparoscopic cholecystectomy, played in a window or scripted without a display.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/cholecystectomy/arguments.h"
#include "apps/cholecystectomy/interruption.h"
#include "apps/cholecystectomy/outcome.h"
#include "apps/cholecystectomy/output_folder.h"
#include "apps/cholecystectomy/play/rig_check.h"
#include "apps/cholecystectomy/play/virtual_play.h"
#include "apps/cholecystectomy/procedure.h"
#include "apps/cholecystectomy/recorders.h"
#include "apps/cholecystectomy/report.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/surgical_scene.h"
#include "apps/support/executors.h"
#ifdef PBDSURG_HAS_PICTURES
#include "apps/cholecystectomy/pictures.h"
#endif
#ifdef PBDSURG_HAS_WINDOW
#include "apps/cholecystectomy/play/play.h"
#endif

namespace cholecystectomy {
namespace {

void print(const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings) {
    std::fprintf(stderr, "warning: %s\n", warning.text.c_str());
  }
}

// Runs the operation and writes all but the report.
// @param pictures  becomes what the last line says of them
Course operate(const Arguments& arguments, Simulation& simulation, const OutputFolder& folder,
               [[maybe_unused]] const pbdsurg::MeshData& backdrop, std::string& pictures) {
  ForceRecorder forces(folder.part() / "force.csv");
  CauteryRecorder cautery(folder.part() / "cautery.csv");
  SeriesRecorder series(folder.part() / "series.pvd");
  ProgressRecorder progress;
  std::vector<Observer*> observers{&forces, &cautery, &series, &progress};
  pictures = "no pictures";
#ifdef PBDSURG_HAS_PICTURES
  std::optional<PictureRecorder> recorder;
  if (!arguments.no_pictures) {
    try {
      recorder.emplace(folder.part(), backdrop);
      observers.push_back(&*recorder);
    } catch (const pbdsurg::BackendUnavailable& error) {
      pictures += std::string(" (") + error.what() + ")";
    }
  }
#else
  pictures += " (built without EGL, libepoxy or stb)";
#endif

  Course course = run_procedure(simulation, observers, arguments.time_scale);
  forces.close();
  cautery.close();
  write_recovery(folder.part() / "recovery.csv", course.recovery);
#ifdef PBDSURG_HAS_PICTURES
  if (recorder && !recorder->files.empty()) {
    pictures = std::to_string(recorder->files.size()) + " pictures " +
               (arguments.out / recorder->files.front().filename()).string() + " to " +
               (arguments.out / recorder->files.back().filename()).string();
  }
#endif
  return course;
}

int run_script(const Arguments& arguments) {
  const pbdsurg::SolverOptions options =
      solver_options(pbdsurg::programs::executor_named(arguments.executor), arguments.paper);
  OutputFolder folder(arguments.out);
  StageTimes times;
  const auto timed = [&](const char* stage, auto&& make) {
    const StageTimer timer(times, stage);
    return make();
  };
  const LoadedAnatomy loaded = timed("anatomy", [&] {
    return load_anatomy(arguments.organs, arguments.detail.value_or(Detail::full));
  });
  for (const std::string& note : loaded.notes) {
    std::fprintf(stderr, "%s\n", note.c_str());
  }
  const SurgicalScene scene = timed("scene", [&] {
    return make_scene(loaded, arguments.paper ? pbdsurg::ElasticModel::springs
                                              : pbdsurg::ElasticModel::neo_hookean);
  });
  Simulation simulation =
      timed("initialisation", [&] { return Simulation(scene, options, arguments.seed, times); });
  for (const pbdsurg::Body& body : scene.scene.bodies()) {
    std::fprintf(stderr, "%-17s %6d vertices %6d tetrahedra\n", body.name.c_str(),
                 body.vertex_count, body.tet_count);
  }
  ReportNotes notes{arguments.seed, loaded.notes, loaded.warnings, {}};
  notes.warnings.insert(notes.warnings.end(), scene.warnings.begin(), scene.warnings.end());
  print(notes.warnings);  // before minutes are spent

  note_interrupt();
  folder.open();
  std::string pictures;
  const Course course =
      operate(arguments, simulation, folder, loaded.anatomy.abdominal_wall, pictures);
  const std::vector<Warning> judged = judge(simulation, course);
  notes.warnings.insert(notes.warnings.end(), judged.begin(), judged.end());
  notes.files = folder.files();
  write_report(folder.part() / kReportName, simulation, course, notes);
  folder.publish();

  print(notes.warnings);
  if (course.is_interrupted) {
    std::fprintf(stderr, "interrupted at %.3f s\n", simulation.time());
  }
  std::printf("wrote %s and the report %s\n", pictures.c_str(),
              (arguments.out / kReportName).c_str());
  if (std::fflush(stdout) != 0) {
    throw pbdsurg::FileError("the standard output cannot be written");
  }
  const bool is_failure = std::any_of(judged.begin(), judged.end(),
                                      [](const Warning& warning) { return warning.is_failure; });
  return course.is_interrupted ? kInterruptedStatus : is_failure ? 1 : 0;
}

int run(const Arguments& arguments) {
  if (arguments.is_headless) {
    end_on_interrupt();
    return run_script(arguments);
  }
  if (arguments.is_rig_check) {
    return check_rig_at_terminal({arguments.devices, arguments.is_virtual});
  }
  if (arguments.is_virtual) {
    end_on_interrupt();
    return play_in_virtual_time({arguments.out, arguments.organs,
                                 arguments.detail.value_or(Detail::full), arguments.executor,
                                 arguments.paper, arguments.devices, arguments.seconds,
                                 !arguments.no_pictures, arguments.is_recorded});
  }
#ifdef PBDSURG_HAS_WINDOW
  return play({arguments.out, arguments.organs, arguments.detail, arguments.executor,
               arguments.paper, arguments.devices, arguments.is_recorded, arguments.settings,
               arguments.pictures});
#else
  throw pbdsurg::BackendUnavailable(
      "this build has no window (it needs libglfw3-dev and libimgui-dev); --headless runs the "
      "script");
#endif
}

}  // namespace
}  // namespace cholecystectomy

int main(int argument_count, char** values) {
  try {
    const auto arguments = cholecystectomy::parse_arguments(argument_count, values);
    return arguments ? cholecystectomy::run(*arguments) : 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cholecystectomy: %s\n", error.what());
    return 2;
  }
}
