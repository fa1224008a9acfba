// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/pictures.h"

#include <cstdint>
#include <cstdio>
#include <span>
#include <utility>

#include "pbdsurg/tissue/library.h"

#include "apps/viewer/instruments.h"
#include "apps/viewer/png.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

constexpr double kSuction = 0.3;  // a valve that stands a little open
constexpr std::uint64_t kSmokeSeed = 7;

// The hook works from below, so that smoke cannot rise: it flows along the organs, to the scope.
const Eigen::Vector3f kSmokeFlow(0, -1, 0.3F);

using BurnLayers = std::vector<Eigen::Vector4f>;

// The living surface of an organ, with its burn marks.
Surface make_surface(const Simulation& simulation, const BurnLayers& burns, Organ organ) {
  const pbdsurg::Surface& skin = simulation.surface(organ);
  Surface surface;
  surface.name = pbdsurg::name_of(organ);
  surface.look = tissue_of(organ).look;
  surface.positions.assign(skin.positions().begin(), skin.positions().end());
  surface.rest_positions.assign(skin.rest_positions().begin(), skin.rest_positions().end());
  for (const pbdsurg::Triangle& triangle : skin.triangles()) {
    if (triangle[0] != triangle[1]) {  // else an empty slot
      surface.triangles.push_back(triangle);
    }
  }
  for (const Index v : skin.vertices()) {
    surface.burn.push_back(burns[v]);
  }
  return surface;
}

// Sheets are small and translucent: of a kind of their own, which the renderer does not draw yet.
void add_sheets(std::span<const Surface> sheets, RenderSnapshot& snapshot) {
  std::vector<Surface>& drawn = snapshot.surfaces;  // snapshot.sheets, once they are drawn
  drawn.insert(drawn.end(), sheets.begin(), sheets.end());
}

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

PictureRecorder::PictureRecorder(const std::filesystem::path& directory, const SurgicalScene& scene,
                                 const pbdsurg::MeshData& backdrop)
    : directory_(directory),
      backdrop_(backdrop),
      renderer_({.width = 960, .height = 720}),
      sheets_(scene),
      smoke_(kSmokeSeed, kSmokeFlow) {}

void PictureRecorder::step(const Simulation& simulation, double) {
  const double power = simulation.last_burn.energy / Simulation::kTimeStep;
  smoke_.advance(Simulation::kTimeStep, simulation.hook.tip, power, kSuction);
}

void PictureRecorder::moment(const Simulation& simulation, const std::string& name) {
  const StageTimer timer(simulation.times, "pictures");
  RenderSnapshot snapshot;
  const BurnLayers burns = burn_layers(simulation);
  for (const Organ organ : pbdsurg::kOrgans) {
    snapshot.surfaces.push_back(make_surface(simulation, burns, organ));
  }
  Surface wall;
  wall.name = "abdominal_wall";
  wall.look = pbdsurg::tissues::abdominal_wall().look;
  wall.triangles = backdrop_.triangles;
  for (const Eigen::Vector3d& x : backdrop_.points) {
    wall.positions.push_back(x.cast<float>());
  }
  snapshot.surfaces.push_back(std::move(wall));
  snapshot.tools = {draw_grasper(simulation.grasper.pose(), !simulation.grasper.held.empty()),
                    draw_hook(simulation.hook.pose())};
  sheets_.update(simulation, burns);
  add_sheets(sheets_.surfaces(), snapshot);
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
