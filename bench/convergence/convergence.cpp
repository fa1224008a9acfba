// SPDX-License-Identifier: Apache-2.0
// How fast methods bring a bar of soft tissue to rest, against its equilibrium in double precision.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bench/convergence/methods.h"
#include "bench/convergence/report.h"
#include "bench/support/program.h"
#include "bench/support/static_energy.h"

namespace pbdsurg::bench {
namespace {

struct Arguments {
  std::filesystem::path out = "out/tables";
  int threads = 0;
  bool quick = false;
};

// s, until the block is at rest
constexpr double kDuration = 0.12;
constexpr double kQuickDuration = 0.04;

// s: the first lets thirty sweeps hold the tip, the last is the demo's
const std::vector<float> kTimeSteps{1e-3F, 2e-3F, 5e-3F};

const std::vector<int> kSweeps{1,  2,  3,  4, 5, 6, 8, 10, 12, 15, 20, 25, kReferenceSweeps,
                               40, 60, 100};

std::vector<std::string> make_notes(const Cantilever& bar,
                                    const std::vector<Eigen::Vector3d>& equilibrium, double damping,
                                    double duration) {
  const auto text = [](const char* format, double value) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), format, value);
    return std::string(buffer.data());
  };
  std::vector<Eigen::Vector3d> rounded_positions;
  for (const Eigen::Vector3d& x : equilibrium) {
    rounded_positions.emplace_back(x.cast<float>().cast<double>());
  }
  return {
      std::to_string(bar.scene.tets().size()) + " tetrahedra, " +
          std::to_string(bar.scene.vertex_count()) +
          " vertices; stable Neo-Hookean, 10 kPa, 0.45, 1060 kg/m^3; held at one side, the other "
          "sags by " +
          text("%.1f %% of the length",
               100 * tip_displacement(bar, equilibrium).norm() / bar.length),
      "drag " + text("%.0f 1/s", damping) + ": critical for the lowest mode, the same for all",
      "residual of one step: from a stretch of 10 %, what the last substep leaves of implicit "
      "Euler's equation, as the sum of the vertices' forces over the weight, in double precision; "
      "timed to what one substep of 30 sweeps leaves",
      "to rest: from rest shape under gravity; tip error of the free side's mean displacement "
      "against a static solution by Newton's method; time until it stays below 1 %",
      "residual in the end: the sum of the vertices' out-of-balance forces over the weight; the "
      "equilibrium itself, rounded to float, leaves " +
          text("%.4f", StaticEnergy(bar.scene).imbalance(rounded_positions) / bar.weight),
      "sweeps, small_steps, vertex_block, the same with over-relaxation of 1.7: the solver's "
      "methods on its threaded backend, "
      "projections in a nested plan; jacobi: "
      "the same projections all at once, in a plain loop on one thread, so compare what it reaches "
      "before its ms",
      "bold: the setting of a method that is first at 1 %; - is never within " +
          text("%.2f s", duration),
  };
}

void run(const Arguments& arguments) {
  const int threads = thread_count(arguments.threads);
  const Cantilever bar(arguments.quick ? std::array<Index, 3>{3, 4, 4}
                                       : std::array<Index, 3>{12, 16, 20});
  const std::span<const Eigen::Vector3d> rest = bar.scene.positions();
  const Positions equilibrium =
      find_equilibrium(StaticEnergy(bar.scene), {rest.begin(), rest.end()});
  const double damping = 2 * lowest_frequency(bar.scene, equilibrium);
  const std::vector<Method> methods = make_methods(bar, static_cast<float>(damping), threads);
  const double duration = arguments.quick ? kQuickDuration : kDuration;
  std::vector<Comparison> comparisons;
  for (const float dt : kTimeSteps) {
    const Problem problem{bar,
                          equilibrium,
                          damping,
                          dt,
                          static_cast<int>(std::lround(duration / dt)),
                          arguments.quick ? 1 : 3};
    comparisons.push_back(
        {dt, measure_step(problem, methods, kSweeps), measure_rest(problem, methods)});
  }

  const Json rows = to_json(comparisons);
  const std::string markdown = to_markdown(rows, make_notes(bar, equilibrium, damping, duration));
  std::fputs(markdown.c_str(), stdout);
  write_text(arguments.out / "convergence.md", markdown);
  write_text(arguments.out / "convergence.csv", to_csv(points_of(comparisons)));
  merge_into_json(arguments.out / "tables.json", "convergence", rows);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("How fast methods bring a sagging bar to rest.", "convergence");
  pbdsurg::bench::Arguments arguments;
  pbdsurg::bench::add_threads_option(app, arguments.threads);
  app.add_flag("--quick", arguments.quick, "a small bar, few steps: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
