// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/instruments.h"
#include "apps/viewer/png.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

constexpr double kSmokeEvery = 0.04;  // s
constexpr double kSmokeLife = 0.9;    // s

using Layers = std::span<const Eigen::Vector4f>;  // [vertex_count of the tissue]

// The living surface of an organ, with its burn marks.
Surface make_surface(const Simulation& simulation, Layers burns, Organ organ) {
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

// Between the two ends of a link, in whose middle a membrane has its vertex: connective tissue is
// not heated by itself. The colour counts by its cover.
Eigen::Vector4f burn_between(Layers burns, const pbdsurg::Link& link) {
  const Eigen::Vector4f& a = burns[link.first];
  const Eigen::Vector4f& b = burns[link.second];
  const float cover = a.w() + b.w();
  Eigen::Vector4f layer = Eigen::Vector4f::Zero();
  if (cover > 0) {
    layer.head<3>() = (a.w() * a.head<3>() + b.w() * b.head<3>()) / cover;
    layer.w() = cover / 2;
  }
  return layer;
}

// The membrane between gallbladder and liver as a sheet where it holds, and every link as a strand.
void add_connections(const Simulation& simulation, Layers burns, RenderSnapshot& snapshot) {
  const pbdsurg::Solver& solver = simulation.solver;
  const auto positions = solver.positions();
  Surface sheet;
  sheet.name = "membrane";
  sheet.look = pbdsurg::tissues::membrane().look;
  for (Index l = 0; l < simulation.scene.membrane_link_count; ++l) {
    const pbdsurg::Link& link = solver.tissue().links()[l];
    sheet.positions.push_back(0.5F * (positions[link.first] + positions[link.second]));
    sheet.burn.push_back(burn_between(burns, link));
  }
  for (const pbdsurg::Triangle& triangle : simulation.scene.membrane.triangles) {
    if (std::all_of(triangle.begin(), triangle.end(),
                    [&](Index l) { return solver.tissue().is_link_alive(l); })) {
      sheet.triangles.push_back(triangle);
    }
  }
  snapshot.surfaces.push_back(std::move(sheet));
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    if (solver.tissue().is_link_alive(l)) {
      const pbdsurg::Link& link = solver.tissue().links()[l];
      const Eigen::Vector4f burn = burn_between(burns, link);
      Eigen::Vector4f color(0.93F, 0.86F, 0.78F, 0.6F);
      color.head<3>() += burn.w() * (burn.head<3>() - color.head<3>());
      snapshot.strands.push_back({positions[link.first], positions[link.second], color, 0.0003F});
    }
  }
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

PictureRecorder::PictureRecorder(const std::filesystem::path& directory,
                                 const pbdsurg::MeshData& backdrop)
    : directory_(directory), backdrop_(backdrop), renderer_({.width = 960, .height = 720}) {}

// Smoke rises from the hook while it heats; each puff lives for kSmokeLife.
void PictureRecorder::step(const Simulation& simulation, double) {
  constexpr float kStep = static_cast<float>(Simulation::kTimeStep);
  for (std::size_t i = 0; i < smoke_.size(); ++i) {
    smoke_[i].center += kStep * smoke_velocities_[i];
    smoke_[i].radius += 0.006F * kStep;
    smoke_[i].opacity -= 0.35F * kStep / static_cast<float>(kSmokeLife);
  }
  if (!smoke_.empty() && smoke_.front().opacity <= 0) {
    smoke_.erase(smoke_.begin());
    smoke_velocities_.erase(smoke_velocities_.begin());
  }
  const auto every = static_cast<std::int64_t>(kSmokeEvery / kStep + 0.5);
  if (simulation.hook_power > 0 && simulation.totals.steps % every == 0) {
    const auto random = [&](std::uint64_t axis) {
      return static_cast<float>(
          pbdsurg::random_unit(7, static_cast<std::uint64_t>(simulation.totals.steps), axis) - 0.5);
    };
    smoke_.push_back({simulation.hook.tip, 0.002F, 0.35F});
    smoke_velocities_.push_back({0.02F * random(0), 0.02F * random(1), 0.015F + 0.02F * random(2)});
  }
}

void PictureRecorder::moment(const Simulation& simulation, const std::string& name) {
  const StageTimer timer(simulation.times, "pictures");
  RenderSnapshot snapshot;
  BurnLayers burn_layers(simulation);
  burn_layers.update();
  const Layers burns = burn_layers.layers();
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
  add_connections(simulation, burns, snapshot);
  snapshot.smoke = smoke_;
  snapshot.camera = camera_for(name);

  char number[8];
  std::snprintf(number, sizeof number, "%02zu_", files.size() + 1);
  const std::filesystem::path path = directory_ / (number + name + ".png");
  write_png(path, renderer_.render(snapshot));
  files.push_back(path);
}

}  // namespace cholecystectomy
