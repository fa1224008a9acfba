// SPDX-License-Identifier: Apache-2.0
// Figure 12 of Pan et al. 2020: what the tasks take, before the first frame and in a frame.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/support/executors.h"
#include "bench/frames/measure.h"
#include "bench/frames/report.h"
#include "bench/support/gpu_times.h"
#include "bench/support/paper_step.h"
#include "bench/support/program.h"
#include "bench/support/subject.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::string executor;
  bool quick = false;
};

struct Stage {
  std::string name;
  bool online;
  std::optional<double> ms;
  std::optional<double> paper_ms{};
};

struct Measured {
  std::vector<Stage> stages;
  Index liver_tets, gallbladder_tets;
  std::string backend;
  std::string renderer;  ///< empty where no picture can be drawn
  std::string why_no_picture{};
};

Measured measure(const SceneSize& size, const Executor& executor, bool quick) {
  std::optional<OrganPair> organs;
  const double tets_ms = time_of([&] { organs.emplace(make_organ_pair(size)); });
  std::optional<Scene> scene;
  const double scene_ms = time_of([&] { scene.emplace(make_liver_and_gallbladder(*organs)); });
  SolverOptions options = SolverOptions::paper();
  options.coloring.repair = true;
  options.executor = executor;
  FrameWorld world(*scene, options, kPaperTimeStep);
  const auto& making = world.making();
  Measured measured{{{"tetrahedra", false, tets_ms, 2886},
                     {"scene", false, scene_ms},
                     {"solver and colours", false, making.solver},
                     {"heat", false, making.heat},
                     {"surfaces", false, making.surfaces}},
                    organs->liver.tet_count(),
                    organs->gallbladder.tet_count(),
                    world.world().solver().backend_name(),
                    ""};
  std::unique_ptr<FramePicture> picture;
  try {
    const double start_ms = time_of([&] { picture = make_frame_picture(world); });
    measured.stages.push_back({"OpenGL and first picture", false, start_ms});
    measured.renderer = picture->renderer();
  } catch (const BackendUnavailable& error) {
    measured.stages.push_back({"OpenGL and first picture", false, std::nullopt});
    measured.why_no_picture = error.what();
  }
  const bool is_gpu = executor.kind() == ExecutorKind::device;
  FrameWorld apart(*scene, options, kPaperTimeStep, FrameContact::none);
  const FrameTimes times = measure_frames(
      world, apart, picture.get(), frame_effort(!picture || picture->is_software(), is_gpu, quick));
  const FrameStages& stages = times.stages;
  const auto drawn = [&](double ms) { return picture ? std::optional(ms) : std::nullopt; };
  for (const Stage& stage :
       {Stage{"solver", true, stages.solver, 16.5}, Stage{"contact", true, stages.contact},
        Stage{"heat", true, stages.heat}, Stage{"edit", true, stages.edit},
        Stage{"readback", true, stages.readback}, Stage{"upload", true, drawn(stages.upload)},
        Stage{"picture", true, drawn(stages.picture)}}) {
    measured.stages.push_back(stage);
  }
  return measured;
}

Json to_json(const Measured& measured) {
  double sums[2] = {0, 0};
  for (const Stage& stage : measured.stages) {
    sums[stage.online ? 1 : 0] += stage.ms.value_or(0);
  }
  Json rows = Json::array();
  for (const Stage& stage : measured.stages) {
    const auto share =
        stage.ms ? std::optional(100 * *stage.ms / sums[stage.online ? 1 : 0]) : std::nullopt;
    rows.push_back({{"stage", stage.name},
                    {"online", stage.online},
                    {"phase", stage.online ? "in a frame" : "before the first"},
                    {"ms", rounded(stage.ms, 1e3)},
                    {"share_percent", rounded(share, 1e1)},
                    {"paper_ms", stage.paper_ms ? Json(*stage.paper_ms) : Json()},
                    {"liver_tets", measured.liver_tets},
                    {"gallbladder_tets", measured.gallbladder_tets},
                    {"backend", measured.backend},
                    {"renderer", measured.renderer.empty() ? Json() : Json(measured.renderer)}});
  }
  return rows;
}

// What a plot needs, without texts that have commas.
Json of_stages(const Json& rows) {
  Json stages = Json::array();
  for (const Json& row : rows) {
    Json stage;
    for (const char* key : {"stage", "online", "ms", "paper_ms"}) {
      stage[key] = row[key];
    }
    stages.push_back(stage);
  }
  return stages;
}

std::string to_markdown(const Json& rows, const Measured& measured) {
  std::string text = "# Figure 12\n\n- liver and gallbladder of " +
                     std::to_string(measured.liver_tets) + " and " +
                     std::to_string(measured.gallbladder_tets) +
                     " tetrahedra; steps of 0.2 ms in paper mode, " + measured.backend + "\n";
  text += measured.why_no_picture.empty() ? "- pictures of 1280x720 by " + measured.renderer + "\n"
                                          : "- no pictures: " + measured.why_no_picture + "\n";
  text +=
      "- offline: once each, before the first frame. online: medians of a frame with two "
      "instruments on the liver and current, as table 3 has them\n"
      "- solver and colours: tissue, constraints, their colours, the plan\n"
      "- contact: what a step takes more than one by turns without instruments, of organs that do "
      "not meet; solver: the rest\n"
      "- printed: the two that the paper names, on its machine (GTX 980 Ti)\n";
  const std::vector<Column> columns{
      {"ms", "ms", 3}, {"share_percent", "%", 1}, {"paper_ms", "printed, ms", 1}};
  for (const bool online : {false, true}) {
    text += std::string("\n") + markdown_header(online ? "online" : "offline", columns);
    for (const Json& row : rows) {
      if (row["online"] == online) {
        text += markdown_line(text_of(row["stage"]), row, columns);
      }
    }
  }
  return text;
}

void run(const Arguments& arguments) {
  const std::string name = !arguments.executor.empty() ? arguments.executor
                           : why_no_gpu()              ? "threads"
                                                       : "cuda";
  const Measured measured = measure(arguments.quick ? SceneSize{176, 146} : kLargestScene,
                                    programs::executor_named(name), arguments.quick);
  const Json rows = to_json(measured);
  const std::string markdown = to_markdown(rows, measured);
  std::fputs(markdown.c_str(), stdout);
  write_table(arguments.out, "figure12", rows, markdown);
  write_text(arguments.out / "figure12_stages.csv", to_csv(of_stages(rows)));
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Figure 12 of the paper: what each task takes, before the first frame and in one.",
               "figure12");
  pbdsurg::bench::Arguments arguments;
  app.add_option("--executor", arguments.executor,
                 "who steps, in place of cuda where there is one, else threads: as those, serial, "
                 "threads:N or cuda:N")
      ->type_name("NAME");
  app.add_flag("--quick", arguments.quick, "the smallest scene, three frames: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
