// SPDX-License-Identifier: Apache-2.0
// One picture of the demo's organs in motion: all positions are new, then the scene is drawn until
// the device has finished; then the median of what it takes for each pass. Without reading the
// picture back. LP_NUM_THREADS=1 keeps Mesa's software renderer on the calling thread and one more,
// which draws.
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/instruments.h"
#include "apps/viewer/offscreen_renderer.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::OffscreenOptions;
using cholecystectomy::OffscreenRenderer;
using cholecystectomy::PassTime;
using cholecystectomy::RenderQuality;
using cholecystectomy::SceneView;
using cholecystectomy::SurfaceChange;

constexpr int kTimedPictures = 11;  // pass by pass, after the others

const TissueRecord& tissue_of(Organ organ) {
  switch (organ) {
    case Organ::gallbladder:
      return tissues::gallbladder_wall();
    case Organ::liver:
      return tissues::liver();
    case Organ::cystic_artery:
      return tissues::artery();
    case Organ::calot_fat:
      return tissues::fat();
    default:
      return tissues::bile_duct();
  }
}

// Six organs and the wall behind them.
const std::vector<cholecystectomy::Surface>& surfaces() {
  static const std::vector<cholecystectomy::Surface> all = [] {
    const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy();
    std::vector<cholecystectomy::Surface> result;
    for (const Organ organ : kOrgans) {
      const TetMesh& mesh = anatomy.organs.at(organ);
      cholecystectomy::Surface& surface = result.emplace_back();
      surface.name = name_of(organ);
      surface.look = tissue_of(organ).look;
      for (const Eigen::Vector3d& x : mesh.positions()) {
        surface.positions.push_back(x.cast<float>());
      }
      for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
        surface.triangles.push_back(triangle.vertices);
      }
      surface.rest_positions = surface.positions;
      surface.burn.assign(surface.positions.size(), Eigen::Vector4f::Zero());
    }
    cholecystectomy::Surface& wall = result.emplace_back();
    wall.name = "abdominal_wall";
    wall.look = tissues::abdominal_wall().look;
    wall.casts_shadow = false;
    wall.triangles = anatomy.abdominal_wall.triangles;
    for (const Eigen::Vector3d& x : anatomy.abdominal_wall.points) {
      wall.positions.push_back(x.cast<float>());
    }
    return result;
  }();
  return all;
}

SceneView operation_view() {
  SceneView view;
  view.camera.up = {0, 0, 1};
  view.camera.eye = {-0.055F, -0.085F, -0.045F};
  view.camera.target = {0.012F, 0, 0.008F};
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.linear() = Eigen::AngleAxisf(2.2F, Eigen::Vector3f::UnitX()).toRotationMatrix();
  pose.translation() = Eigen::Vector3f(0.01F, -0.025F, 0);
  view.tools = {cholecystectomy::draw_hook(pose)};
  return view;
}

void run_pictures(benchmark::State& state, const RenderQuality& quality, int width, int height) {
  std::optional<OffscreenRenderer> renderer;
  try {
    renderer.emplace(OffscreenOptions{.width = width, .height = height, .quality = quality});
  } catch (const BackendUnavailable& error) {
    state.SkipWithError(error.what());
    return;
  }
  state.SetLabel(renderer->device_name());
  renderer->set_surfaces(surfaces());
  const SceneView view = operation_view();
  std::size_t triangles = 0;
  std::vector<SurfaceChange> changes;
  for (const cholecystectomy::Surface& surface : surfaces()) {
    triangles += surface.triangles.size();
    changes.emplace_back().positions = surface.positions;
  }
  renderer->draw(view);  // shaders are compiled with the first picture
  int picture = 0;
  double submission = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const float shift = 1e-4F * std::sin(0.3F * static_cast<float>(++picture));
    for (std::size_t s = 0; s + 1 < changes.size(); ++s) {
      for (std::size_t v = 0; v < changes[s].positions.size(); ++v) {
        changes[s].positions[v].z() = surfaces()[s].positions[v].z() + shift;
      }
    }
    state.ResumeTiming();
    for (std::size_t s = 0; s + 1 < changes.size(); ++s) {
      renderer->update(s, changes[s]);
    }
    submission += time_of([&] { renderer->start(view); });
    renderer->finish();
  }
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["submission_ms"] = submission / static_cast<double>(state.iterations());
  std::map<std::string, std::vector<double>> passes;
  for (int i = 0; i < kTimedPictures; ++i) {
    for (const PassTime& pass : renderer->time_passes(view)) {
      passes[pass.name].push_back(pass.milliseconds);
    }
  }
  for (auto& [name, milliseconds] : passes) {
    state.counters[name + "_ms"] = median(milliseconds);
  }
}

BENCHMARK_CAPTURE(run_pictures, quick_640x480, RenderQuality::quick(), 640, 480)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(run_pictures, full_640x480, RenderQuality::full(), 640, 480)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(run_pictures, quick_1280x720, RenderQuality::quick(), 1280, 720)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(run_pictures, full_1280x720, RenderQuality::full(), 1280, 720)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
