// SPDX-License-Identifier: Apache-2.0
// Table 3 of Pan et al. 2020: liver and gallbladder in one scene, whole steps of the solver and
// whole frames.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>

#include "apps/support/executors.h"
#include "bench/support/effort.h"
#include "bench/support/paper_step.h"
#include "bench/support/program.h"
#include "bench/table3/report.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  int threads = 0;
  int cpu_rounds = kCpuRounds;
  bool quick = false;
};

// As the demo steps on a CPU.
SolverOptions vertex_blocks() {
  return {.method = SolverMethod::vertex_block,
          .substeps = 1,
          .iterations = 4,
          .over_relaxation = 1.2F,
          .coarse_correction = CoarseCorrection::on};
}

constexpr double kCpuFrame = 10e-3;  // s, of the default method
constexpr double kGpuFrame = 5e-3;

// Whole frames, until no picture can be drawn: then there are none, and why.
class Frames {
 public:
  Frames(const Arguments& arguments, int threads) : arguments_(arguments), threads_(threads) {}

  RowFrames measure(const OrganPair& organs, const SolverOptions& cpu_plan, bool has_gpu) {
    RowFrames frames;
    SolverOptions cpu_paper = cpu_plan;
    // a picture has a thread of its own, which waits busily for a GPU
    const Executor beside = executor::threads(threads_ > 2 ? threads_ - 1 : threads_);
    cpu_paper.executor = beside;
    const SolverOptions cpu_default{.executor = beside};
    const Scene springs = make_liver_and_gallbladder(organs);
    const Scene tissue = make_liver_and_gallbladder(organs, ElasticModel::neo_hookean);
    frames.cpu_paper = measure(springs, cpu_paper, kPaperTimeStep, false, "cpu_paper");
    frames.cpu_default = measure(tissue, cpu_default, kCpuFrame, false, "cpu_default");
    if (has_gpu) {
      SolverOptions gpu_paper = SolverOptions::paper();
      gpu_paper.coloring = {.repair = true, .balance = true};
      gpu_paper.executor = programs::device();
      const SolverOptions gpu_default{.executor = programs::device()};
      frames.gpu_paper = measure(springs, gpu_paper, kPaperTimeStep, true, "gpu_paper");
      frames.gpu_default = measure(tissue, gpu_default, kGpuFrame, true, "gpu_default");
    }
    return frames;
  }

  [[nodiscard]] const std::optional<std::string>& why_none() const { return why_none_; }

 private:
  std::optional<FrameTimes> measure(const Scene& scene, const SolverOptions& options, double step,
                                    bool is_gpu, const std::string& name) {
    if (why_none_) {
      return std::nullopt;
    }
    FrameWorld world(scene, options, step), apart(scene, options, step, FrameContact::none);
    std::unique_ptr<FramePicture> picture;
    try {
      picture = make_frame_picture(world);
    } catch (const BackendUnavailable& error) {
      why_none_ = error.what();
      return std::nullopt;
    }
    return measure_frames(world, apart, picture.get(),
                          frame_effort(picture->is_software(), is_gpu, arguments_.quick),
                          arguments_.out / ("table3_" + name + ".png"));
  }

  const Arguments& arguments_;
  int threads_;
  std::optional<std::string> why_none_;
};

Row measure(const Table3Line& line, int threads, const Effort& effort, bool has_gpu,
            Frames& frames) {
  const OrganPair organs = make_organ_pair(line.size);
  const Scene scene = make_liver_and_gallbladder(organs);
  std::optional<GpuTimes> gpu;
  if (has_gpu) {
    gpu = measure_on_gpu(scene, effort.gpu);
  }
  const SolverOptions plan = find_fastest_cpu_plan(scene, threads, effort.cpu);
  return {&line,
          scene.body(scene.find_body("liver")).tet_count,
          scene.body(scene.find_body("gallbladder")).tet_count,
          static_cast<Index>(scene.links().size()),
          measure_on_cpu(scene, plan, threads, effort.cpu),
          measure_on_cpu(make_liver_and_gallbladder(organs, ElasticModel::neo_hookean),
                         vertex_blocks(), threads, effort.cpu),
          gpu,
          frames.measure(organs, plan, has_gpu)};
}

void run(const Arguments& arguments) {
  const int threads = thread_count(arguments.threads);
  std::vector<std::string> notes{"all threads: " + std::to_string(threads)};
  const std::optional<std::string> why_no_device = why_no_gpu();
  if (why_no_device) {
    notes.push_back("no gpu columns: " + *why_no_device);
  }
  const Effort effort = arguments.quick ? kQuickEffort : full_effort(arguments.cpu_rounds);
  std::vector<Row> rows;
  Frames frames(arguments, threads);
  for (const Table3Line& line : std::span(kTable3).first(arguments.quick ? 1 : kTable3.size())) {
    rows.push_back(measure(line, threads, effort, !why_no_device, frames));
    const Row& row = rows.back();
    std::fprintf(stderr, "%d + %d tetrahedra: %.2f ms on %d threads, by vertex blocks %.2f ms\n",
                 row.liver_tets, row.gallbladder_tets, row.cpu.all_threads.median_ms, threads,
                 row.vertex_blocks.all_threads.median_ms);
    if (const auto& times = row.frames.best()) {
      std::fprintf(stderr, "whole frames: %.1f a second, %s\n", times->frames_per_s,
                   times->renderer.c_str());
    }
  }
  if (frames.why_none()) {
    notes.push_back("no whole frames: " + *frames.why_none());
  }
  notes.push_back("backend of all threads: " + rows.at(0).cpu.backend);
  if (rows.at(0).gpu) {
    notes.push_back("backend of the gpu columns, in the first row: " + rows.at(0).gpu->backend);
  }
  const Json json = to_json(rows);
  const std::string markdown = to_markdown(json, notes);
  std::fputs(markdown.c_str(), stdout);
  write_table(arguments.out, "table3", json, markdown);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Table 3: how long a step of liver and gallbladder takes.", "table3");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  pbdsurg::bench::add_cpu_rounds_option(app, arguments.cpu_rounds);
  app.add_flag("--quick", arguments.quick, "the smallest scene, few steps: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
