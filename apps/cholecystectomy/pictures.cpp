// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
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

using BurnLayers = std::vector<Eigen::Vector4f>;

// Where a cut or a burn has opened tissue: moist, darker, redder, without the vessels of its skin.
pbdsurg::TissueLook look_inside(const pbdsurg::TissueLook& skin) {
  const Eigen::Vector3f flesh(0.50F, 0.13F, 0.10F);
  pbdsurg::TissueLook look = skin;
  look.color += 0.25F * (flesh - skin.color);
  look.mottle += 0.45F * (0.8F * flesh - skin.mottle);
  look.gloss = std::max(skin.gloss, 0.85F);
  look.relief = std::min(1.0F, skin.relief + 0.3F);
  look.detail_size = 0.6F * skin.detail_size;
  look.vessels = 0;
  return look;
}

std::vector<Eigen::Vector4f> burns_of(const pbdsurg::Surface& skin, const BurnLayers& burns) {
  std::vector<Eigen::Vector4f> result;
  for (const Index v : skin.vertices()) {
    result.push_back(burns[v]);
  }
  return result;
}

// The surface of an organ before anything has been cut.
Surface make_surface(const Simulation& simulation, Organ organ) {
  const pbdsurg::Surface& skin = simulation.surface(organ);
  Surface surface;
  surface.name = pbdsurg::name_of(organ);
  surface.look = tissue_of(organ).look;
  surface.inner_look = look_inside(surface.look);
  surface.positions.assign(skin.positions().begin(), skin.positions().end());
  surface.rest_positions.assign(skin.rest_positions().begin(), skin.rest_positions().end());
  surface.triangles.assign(skin.triangles().begin(), skin.triangles().end());
  return surface;
}

Surface make_wall(const pbdsurg::MeshData& mesh) {
  Surface wall;
  wall.name = "abdominal_wall";
  wall.look = pbdsurg::tissues::abdominal_wall().look;
  wall.triangles = mesh.triangles;
  for (const Eigen::Vector3d& x : mesh.points) {
    wall.positions.push_back(x.cast<float>());
  }
  return wall;
}

// Between the two ends of a link, in whose middle a membrane has its vertex: connective tissue is
// not heated by itself. The colour counts by its cover.
Eigen::Vector4f burn_between(const BurnLayers& burns, const pbdsurg::Link& link) {
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
void add_connections(const Simulation& simulation, const BurnLayers& burns, SceneView& view) {
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
  view.sheets.push_back(std::move(sheet));
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    if (solver.tissue().is_link_alive(l)) {
      const pbdsurg::Link& link = solver.tissue().links()[l];
      const Eigen::Vector4f burn = burn_between(burns, link);
      Eigen::Vector4f color(0.93F, 0.86F, 0.78F, 0.6F);
      color.head<3>() += burn.w() * (burn.head<3>() - color.head<3>());
      view.strands.push_back({positions[link.first], positions[link.second], color, 0.0003F});
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

// The first moment keeps all surfaces; later ones say what has changed of them.
void PictureRecorder::show_surfaces(const Simulation& simulation, const BurnLayers& burns) {
  if (seen_.empty()) {
    std::vector<Surface> surfaces;
    for (const Organ organ : pbdsurg::kOrgans) {
      Surface& surface = surfaces.emplace_back(make_surface(simulation, organ));
      surface.burn = burns_of(simulation.surface(organ), burns);
      seen_.push_back(
          {surface.triangles, surface.positions.size(), simulation.surface(organ).version()});
    }
    surfaces.push_back(make_wall(backdrop_));
    renderer_.set_surfaces(surfaces);
    return;
  }
  for (std::size_t i = 0; i < pbdsurg::kOrgans.size(); ++i) {
    const pbdsurg::Surface& skin = simulation.surface(pbdsurg::kOrgans[i]);
    Seen& seen = seen_[i];
    SurfaceChange change;
    change.positions.assign(skin.positions().begin(), skin.positions().end());
    const auto rest = skin.rest_positions().subspan(seen.vertex_count);
    change.new_rest_positions.assign(rest.begin(), rest.end());
    std::vector<pbdsurg::SlotRange> ranges;
    skin.collect_changes(seen.version, ranges);
    for (const pbdsurg::SlotRange& range : ranges) {
      SurfaceChange::Triangles& run = change.triangles.emplace_back();
      run.first = range.first;
      for (Index slot = range.first; slot < range.end; ++slot) {
        run.values.push_back(skin.triangles()[slot]);
        // a triangle keeps its slot for as long as it exists
        const bool was_there = static_cast<std::size_t>(slot) < seen.skin.size() &&
                               seen.skin[slot] == run.values.back();
        run.is_inner.push_back(was_there ? 0 : 1);
      }
    }
    change.burns = {{0, burns_of(skin, burns)}};
    renderer_.update(i, change);
    seen.vertex_count = change.positions.size();
    seen.version = skin.version();
  }
}

void PictureRecorder::moment(const Simulation& simulation, const std::string& name) {
  const StageTimer timer(simulation.times, "pictures");
  const BurnLayers burns = burn_layers(simulation);
  show_surfaces(simulation, burns);
  SceneView view;
  view.tools = {draw_grasper(simulation.grasper.pose(), !simulation.grasper.held.empty()),
                draw_hook(simulation.hook.pose())};
  add_connections(simulation, burns, view);
  view.smoke = smoke_;
  view.camera = camera_for(name);

  char number[8];
  std::snprintf(number, sizeof number, "%02zu_", files.size() + 1);
  const std::filesystem::path path = directory_ / (number + name + ".png");
  write_png(path, renderer_.render(view));
  files.push_back(path);
}

}  // namespace cholecystectomy
