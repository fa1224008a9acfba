// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/pictures.h"

#include <cstdio>
#include <utility>

#include "apps/viewer/instruments.h"
#include "apps/viewer/png.h"

namespace cholecystectomy {
namespace {

// Each part of the operation is seen from where a surgeon's assistant would hold the scope.
Camera camera_for(const std::string& moment) {
  Camera camera;
  camera.up = {0, 0, 1};
  if (moment.starts_with("burn")) {
    camera.eye = {0.074F, -0.040F, -0.055F};
    camera.target = {0.082F, 0.014F, 0.004F};
  } else if (moment == "separate_bed") {  // into the gap, from the fundus
    camera.eye = {-0.060F, -0.020F, -0.020F};
    camera.target = {0.015F, 0.0F, 0.010F};
  } else if (moment.starts_with("separate")) {
    camera.eye = {-0.055F, -0.085F, -0.045F};
    camera.target = {0.012F, 0.0F, 0.008F};
  } else {
    camera.eye = {0.015F, -0.12F, -0.085F};
    camera.target = {0.035F, 0.0F, 0.003F};
  }
  return camera;
}

}  // namespace

PictureRecorder::PictureRecorder(const std::filesystem::path& directory,
                                 const pbdsurg::MeshData& backdrop)
    : directory_(directory),
      backdrop_(backdrop),
      renderer_({.width = 960, .height = 720}),
      smoke_(Smoke::of_scene()) {}

void PictureRecorder::step(const Simulation& simulation, double) {
  if (!feed_) {
    feed_.emplace(simulation, backdrop_, 1);
  }
  const double power = simulation.last_burn.energy / simulation.time_step;
  smoke_.advance(simulation.time_step, simulation.pose_of(simulation.hook).translation(), power,
                 Smoke::kSuction);
}

void PictureRecorder::moment(const Simulation& simulation, const std::string& name) {
  const StageTimer timer(simulation.times, "pictures");
  SceneState state;
  feed_->fill(state, {});
  RenderSnapshot snapshot;
  snapshot.surfaces = std::move(state.whole);
  snapshot.sheets = std::move(state.sheets);
  snapshot.tools = {
      draw_grasper(simulation.pose_of(simulation.grasper), !simulation.grasper.held.empty()),
      draw_hook(simulation.pose_of(simulation.hook))};
  snapshot.smoke.assign(smoke_.puffs().begin(), smoke_.puffs().end());
  snapshot.haze = smoke_.haze();
  snapshot.camera = camera_for(name);

  char number[8];
  std::snprintf(number, sizeof number, "%02zu_", files.size() + 1);
  const std::filesystem::path path = directory_ / (number + name + ".png");
  write_png(path, renderer_.render(snapshot));
  files.push_back(path);
}

}  // namespace cholecystectomy
