// SPDX-License-Identifier: Apache-2.0
// What it costs to delete tetrahedra while a scene is stepped, by backend, size of mesh and rate;
// and to cut them.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <list>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/support/executors.h"
#include "bench/edits/report.h"
#include "bench/support/gpu_times.h"
#include "bench/support/neo_hookean.h"
#include "bench/support/program.h"
#include "bench/support/sample.h"
#include "bench/support/subject.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  int threads = 0;
  int frames = 120;
  std::vector<std::string> methods{"paper", "vertex blocks"};
  std::vector<std::string> executors{"threaded", "cuda"};
  bool quick = false;
};

struct NamedMesh {
  std::string name;
  TetMesh tets;
  EditEffort effort;
};

std::list<NamedMesh> make_meshes(const Arguments& arguments, std::vector<std::string>& notes) {
  std::list<NamedMesh> meshes;
  EditEffort effort{{0, 100, 1000, 10000}, arguments.frames};
  effort.cut_frames = arguments.frames;
  const std::vector<int> rows = arguments.quick ? std::vector{1} : std::vector{2, 5};
  for (const Sample& sample : make_samples(rows, {Table2Kind::hollow}, notes)) {
    meshes.push_back({"hollow " + std::to_string(sample.row), sample.mesh, effort});
  }
  if (!arguments.quick) {
    constexpr int kFewFrames = 20;  // a step takes long
    meshes.push_back({"lattice", make_large_liver(), {{0, 1000}, kFewFrames}});
  }
  return meshes;
}

struct Method {
  std::string name;
  Material material;
  SolverOptions options;
};

std::vector<Method> make_methods(const Executor& executor) {
  SolverOptions paper = SolverOptions::paper();
  paper.executor = executor;
  paper.coloring = {.repair = true};
  paper.composition = PlanComposition::automatic;
  return {{"paper", {.model = ElasticModel::springs}, paper},
          {"vertex blocks",
           neo_hookean(1e4, 0.45),
           {.method = SolverMethod::vertex_block,
            .substeps = 1,
            .iterations = 10,
            .executor = executor}}};
}

void run(const Arguments& arguments) {
  const int threads = thread_count(arguments.threads);
  std::vector<std::string> notes{"threads: " + std::to_string(threads)};
  const auto is_wanted = [&](const char* name) {
    return std::ranges::find(arguments.executors, name) != arguments.executors.end();
  };
  std::vector<std::pair<std::string, Executor>> executors;
  if (is_wanted("threaded")) {
    executors.emplace_back("threaded", executor::threads(threads));
  }
  if (const std::optional<std::string> why_not = why_no_gpu(); why_not && is_wanted("cuda")) {
    notes.push_back("no cuda: " + *why_not);
  } else if (is_wanted("cuda")) {
    executors.emplace_back("cuda", programs::device());
  }
  if (executors.empty()) {
    throw BackendUnavailable(notes.back());
  }
  const std::list<NamedMesh> meshes = make_meshes(arguments, notes);
  std::vector<Measured> all;
  for (const auto& [name, executor] : executors) {
    for (const auto& [method, material, options] : make_methods(executor)) {
      if (std::ranges::find(arguments.methods, method) == arguments.methods.end()) {
        continue;
      }
      for (const NamedMesh& mesh : meshes) {
        all.push_back({mesh.name, name, method, mesh.tets.tet_count(),
                       measure_edits(mesh.tets, material, options, mesh.effort)});
        std::fprintf(stderr, "%s, %s, %s: done\n", name.c_str(), method.c_str(), mesh.name.c_str());
      }
    }
    notes.push_back(name + ": " + all.back().run.backend);
  }
  for (std::string& line : verdicts(all)) {
    notes.push_back(std::move(line));
  }
  const Json json = to_json(all);
  const std::string markdown = to_markdown(json, notes);
  write_table(arguments.out, "edits", json, markdown);
  std::fputs(markdown.c_str(), stdout);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Edits: what it costs to delete or cut tetrahedra while a scene is stepped.",
               "edits");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  app.add_option("--frames", arguments.frames, "at each rate, of all meshes but the largest")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--method", arguments.methods, "what steps with")
      ->check(CLI::IsMember(arguments.methods));
  app.add_option("--executor", arguments.executors, "who steps; cuda where there is a GPU")
      ->check(CLI::IsMember(arguments.executors));
  app.add_flag("--quick", arguments.quick, "the smallest mesh alone: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
