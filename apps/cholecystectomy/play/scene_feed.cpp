// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/scene_feed.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/library.h"

#include "apps/cholecystectomy/skin_changes.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::SlotRange;
using pbdsurg::Triangle;

// Of a surface, whose triangles name places in its vertices.
Triangle scene_triangle(const pbdsurg::Surface& surface, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  return {surface.vertices()[a], surface.vertices()[b], surface.vertices()[c]};
}

// Of all organs, scene vertices.
std::vector<Triangle> skin_of(const Simulation& simulation) {
  std::vector<Triangle> skin;
  for (const Organ organ : pbdsurg::kOrgans) {
    const pbdsurg::Surface& surface = simulation.surface(organ);
    for (const Triangle& triangle : surface.triangles()) {
      skin.push_back(scene_triangle(surface, triangle));
    }
  }
  return skin;
}

// Where a cut or a burn has opened tissue: moist, darker, redder, without the vessels of its skin.
pbdsurg::TissueLook inside_of(const pbdsurg::TissueLook& skin) {
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

Surface backdrop_surface(const pbdsurg::MeshData& mesh) {
  Surface wall;
  wall.name = "abdominal_wall";
  wall.look = pbdsurg::tissues::abdominal_wall().look;
  wall.casts_shadow = false;
  wall.triangles = mesh.triangles;
  for (const Eigen::Vector3d& x : mesh.points) {
    wall.positions.push_back(x.cast<float>());
  }
  return wall;
}

Surface named_surface(Organ organ) {
  Surface surface;
  surface.name = pbdsurg::name_of(organ);
  surface.look = tissue_of(organ).look;
  surface.inner_look = inside_of(surface.look);
  return surface;
}

}  // namespace

std::vector<Surface> rest_surfaces(const SurgicalScene& scene, const pbdsurg::MeshData& backdrop) {
  std::vector<Surface> surfaces;
  for (const Organ organ : pbdsurg::kOrgans) {
    const pbdsurg::Body& body = scene.scene.bodies()[static_cast<std::size_t>(body_of(organ))];
    Surface surface = named_surface(organ);
    for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
      surface.positions.push_back(scene.scene.positions()[v].cast<float>());
    }
    surface.rest_positions = surface.positions;
    for (const pbdsurg::BoundaryTriangle& triangle :
         pbdsurg::find_boundary(scene.scene.tets().subspan(body.first_tet, body.tet_count))) {
      const auto& [a, b, c] = triangle.vertices;
      surface.triangles.push_back(
          {a - body.first_vertex, b - body.first_vertex, c - body.first_vertex});
    }
    surfaces.push_back(std::move(surface));
  }
  surfaces.push_back(backdrop_surface(backdrop));
  return surfaces;
}

SceneFeed::SceneFeed(const Simulation& simulation, const pbdsurg::MeshData& backdrop,
                     std::uint32_t generation)
    : simulation_(&simulation),
      backdrop_(backdrop),
      generation_(generation),
      burns_(std::in_place, simulation),
      sheets_(simulation.scene),
      skin_(simulation.solver.tissue(), skin_of(simulation)) {}

void SceneFeed::begin_anew(const Simulation& simulation, const SkinRecord& skin) {
  simulation_ = &simulation;
  skin_ = skin;
  simulation.solver.tissue().add_follower(skin_);
  ++generation_;
  burns_.emplace(simulation);  // strands that are back left no stumps
}

void SceneFeed::fill(SceneState& state, const Seen& seen) {
  burns_->update();
  sheets_.update(*simulation_, burns_->layers());
  state.sheets.assign(sheets_.surfaces().begin(), sheets_.surfaces().end());
  state.generation = generation_;
  state.whole.clear();
  const bool is_new = seen.generation != generation_;
  for (std::size_t i = 0; i < kOrganCount; ++i) {
    const Organ organ = pbdsurg::kOrgans[i];
    if (is_new) {
      state.whole.push_back(whole_surface(organ));
    }
    const std::size_t count = simulation_->surface(organ).vertices().size();
    // what is whole has all vertices
    fill(organ, state.changes[i], is_new ? count : seen.vertex_counts[i], seen.triangle_versions[i],
         seen.burn_versions[i]);
    state.vertex_counts[i] = count;
    state.triangle_versions[i] = simulation_->surface(organ).version();
    state.burn_versions[i] = burns_->version(organ);
  }
  if (is_new) {
    state.whole.push_back(backdrop_surface(backdrop_));
  }
}

void SceneFeed::fill(Organ organ, SurfaceChange& change, std::size_t seen_vertices,
                     std::uint64_t seen_triangles, std::uint64_t seen_burns) {
  const pbdsurg::Surface& surface = simulation_->surface(organ);
  collect_skin_changes(surface, seen_vertices, seen_triangles, ranges_, change);
  for (SurfaceChange::Triangles& run : change.triangles) {
    run.is_inner.clear();
    for (const Triangle& triangle : run.values) {
      run.is_inner.push_back(is_inner(surface, triangle) ? 1 : 0);
    }
  }
  burns_->collect_changes(organ, seen_burns, ranges_);
  change.burns.resize(ranges_.size());
  for (std::size_t r = 0; r < ranges_.size(); ++r) {
    SurfaceChange::Burns& run = change.burns[r];
    run.first = ranges_[r].first;
    run.values.clear();
    for (Index place = ranges_[r].first; place < ranges_[r].end; ++place) {
      run.values.push_back(burns_->layers()[surface.vertices()[place]]);
    }
  }
}

bool SceneFeed::is_inner(const pbdsurg::Surface& surface, const Triangle& triangle) const {
  return !skin_.has(scene_triangle(surface, triangle));
}

Surface SceneFeed::whole_surface(Organ organ) const {
  const pbdsurg::Surface& skin = simulation_->surface(organ);
  Surface surface = named_surface(organ);
  surface.positions.assign(skin.positions().begin(), skin.positions().end());
  surface.rest_positions.assign(skin.rest_positions().begin(), skin.rest_positions().end());
  surface.triangles.assign(skin.triangles().begin(), skin.triangles().end());
  for (const Triangle& triangle : skin.triangles()) {
    surface.is_inner.push_back(is_inner(skin, triangle) ? 1 : 0);
  }
  for (const Index v : skin.vertices()) {
    surface.burn.push_back(burns_->layers()[v]);
  }
  return surface;
}

}  // namespace cholecystectomy
