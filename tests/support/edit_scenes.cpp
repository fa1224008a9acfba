// SPDX-License-Identifier: Apache-2.0
#include "tests/support/edit_scenes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/base/random.h"

#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::testing {
namespace {

constexpr double kEdge = 4e-3;  // m
constexpr Stiffness kLink{0.5F, 1e-3F};

Index index_of(std::size_t i) {
  return static_cast<Index>(i);
}

// A box of which some tetrahedra were split around a vertex within, again and again: vertices have
// from three to many neighbours.
TetMesh make_irregular_mesh(int splits, std::uint64_t seed) {
  const TetMesh box = make_box({2, 1, 1}, 2 * kEdge, 0.1, seed);
  std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
  std::vector<Tet> tets(box.tets().begin(), box.tets().end());
  for (int i = 0; i < splits; ++i) {
    const std::size_t split = random_bits(seed, i) % tets.size();
    const Tet parent = tets[split];
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Index v : parent) {
      middle += points[v] / 4;
    }
    const Index added = index_of(points.size());
    points.push_back(middle);
    for (std::size_t corner = 0; corner < 4; ++corner) {
      Tet part = parent;
      part[corner] = added;
      if (corner == 0) {
        tets[split] = part;
      } else {
        tets.push_back(part);
      }
    }
  }
  return {std::move(points), std::move(tets)};
}

TetMesh make_small_organ() {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = 90;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

EditScene make_one_body(const char* name, const TetMesh& mesh) {
  Scene scene;
  scene.add_body(name, mesh, elastic_material(mesh, 1000, 20e3));
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  scene.fix_where(
      0, [&](const Eigen::Vector3d& x) { return x.x() < box.min().x() + 0.1 * box.sizes().x(); });
  return {name, std::move(scene)};
}

EditScene make_linked_bodies() {
  const TetMesh block = make_box({2, 2, 2}, kEdge, 0.1);
  const TetMesh tube = make_box({3, 1, 1}, kEdge, 0.1, 2);
  Material soft = elastic_material(block, 1000, 20e3);
  soft.max_stretch = 1.2F;
  soft.damping = 1e-3F;
  Material walls = elastic_material(tube, 1000, 20e3);
  walls.has_volume_constraints = false;
  Scene scene;
  scene.add_body("block", block, soft);
  scene.add_body("tube", tube, walls);
  for (Index v = 0; v < tube.vertex_count(); ++v) {
    scene.add_link({v, block.vertex_count() + v, 1e-3F, kLink});
    scene.add_link({v + 3, block.vertex_count() + v, 2e-3F, kLink});
  }
  scene.fix_vertices(0, std::array<Index, 3>{0, 1, 2});
  return {"linked bodies", std::move(scene)};
}

EditScene make_solids() {
  const TetMesh solid = make_box({2, 2, 1}, kEdge, 0.1, 3);
  const TetMesh block = make_box({2, 1, 1}, kEdge, 0.1, 4);
  Scene scene;
  scene.add_body("solid", solid, {.model = ElasticModel::neo_hookean, .max_stretch = 1.3F});
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  const std::array<Eigen::Vector3d, 3> thread{
      {{0, 0, -kEdge}, {kEdge, 0, -kEdge}, {2 * kEdge, 0, -kEdge}}};
  const Index particles = scene.add_particles("thread", thread, 1e-5);
  for (Index i = 0; i < 3; ++i) {
    const Index particle = scene.body(particles).first_vertex + i;
    scene.add_link({2 * i, particle, 1e-3F, kLink});
    scene.add_link({particle, scene.body(1).first_vertex + i, 1e-3F, kLink});
  }
  scene.add_link({scene.body(particles).first_vertex, scene.body(particles).first_vertex + 1,
                  static_cast<float>(kEdge), kLink});
  return {"solids and a thread", std::move(scene)};
}

EditScene make_hinged_bodies() {
  const TetMesh plate = make_box({3, 3, 1}, kEdge, 0.1, 6);
  const TetMesh tube = make_box({2, 1, 1}, kEdge, 0.1, 7);
  Material walls = elastic_material(tube, 1000, 20e3);
  walls.has_volume_constraints = false;
  Scene scene;
  scene.add_body("plate", plate, {.model = ElasticModel::neo_hookean, .damping = 1e-3F});
  scene.add_body("tube", tube, walls);
  scene.add_hinges(0, 1e-5F);
  scene.add_hinges(1, 1e-6F);
  for (Index v = 0; v < tube.vertex_count(); ++v) {
    scene.add_link({v, plate.vertex_count() + v, 1e-3F, kLink});
  }
  scene.fix_vertices(0, std::array<Index, 3>{0, 1, 2});
  return {"hinged bodies", std::move(scene)};
}

EditScene make_sheets() {
  const TetMesh block = make_box({2, 1, 1}, kEdge, 0.1, 8);
  const SheetMesh sheet = make_sheet({4, 3}, kEdge, 0.2), disc = make_disc(2, 2 * kEdge);
  Scene scene;
  scene.add_body("block", block, {.model = ElasticModel::neo_hookean});
  const Index wide = scene.add_sheet("sheet", sheet.positions, sheet.triangles,
                                     {.youngs_modulus = 50e3F, .damping = 1e-3F});
  const Index round = scene.add_sheet("disc", disc.positions, disc.triangles, {.thickness = 5e-4F});
  for (Index i = 0; i < 3; ++i) {
    scene.add_link({i, scene.body(wide).first_vertex + i, 1e-3F, kLink});
    scene.add_link({scene.body(wide).first_vertex + 4 + i, scene.body(round).first_vertex + 2 * i,
                    1e-3F, kLink});
  }
  scene.fix_vertices(wide, std::array<Index, 2>{0, 5});
  return {"sheets", std::move(scene)};
}

EditScene make_fibres() {
  const TetMesh muscle = make_box({2, 2, 2}, kEdge, 0.1, 9);
  const TetMesh plain = make_box({2, 1, 1}, kEdge, 0.1, 10);
  Scene scene;
  scene.add_body("muscle", muscle, {.model = ElasticModel::neo_hookean, .damping = 1e-3F});
  scene.add_body("plain", plain, {.model = ElasticModel::neo_hookean, .max_stretch = 1.3F});
  std::vector<Fibre> fibres(muscle.tets().size());
  for (std::size_t t = 0; t < fibres.size(); ++t) {  // of two directions, and a third without
    fibres[t] = {t % 2 == 0 ? Eigen::Vector3f(0, 0.6F, 0.8F) : Eigen::Vector3f(1, 0, 0),
                 t % 3 == 0 ? 0 : 1e3F * static_cast<float>(t % 5 + 1)};
  }
  scene.set_fibres(0, fibres);
  for (Index v = 0; v < 4; ++v) {
    scene.add_link({v, muscle.vertex_count() + v, 1e-3F, kLink});
  }
  scene.fix_vertices(0, std::array<Index, 3>{0, 1, 2});
  return {"fibres", std::move(scene)};
}

EditScene make_joined_bodies() {
  const TetMesh lower = make_box({2, 2, 1}, kEdge, 0.1, 5);
  std::vector<Eigen::Vector3d> points(lower.positions().begin(), lower.positions().end());
  for (Eigen::Vector3d& x : points) {
    x.z() += 1.5 * kEdge;
  }
  const TetMesh upper(points, {lower.tets().begin(), lower.tets().end()});
  Scene scene;
  scene.add_body("lower", lower, elastic_material(lower, 1000, 20e3));
  scene.add_body("upper", upper, elastic_material(upper, 1000, 20e3));
  scene.fix_vertices(0, std::array<Index, 3>{0, 1, 2});
  ConnectiveTissue strands;
  const auto links = scattered_links(lower, upper, {.max_distance = kEdge, .density = 2e5});
  strands.join(scene, 0, 1, links, {.segments = 2, .slack = 0.1});
  return {"joined bodies", std::move(scene), std::move(strands)};
}

}  // namespace

const std::vector<EditScene>& edit_scenes() {
  static const std::vector<EditScene> scenes = [] {
    std::vector<EditScene> all;
    all.push_back(make_one_body("lattice", make_box({3, 2, 2}, kEdge, 0.1)));
    all.push_back(make_one_body("irregular", make_irregular_mesh(20, 7)));
    all.push_back(make_one_body("organ", make_small_organ()));
    all.push_back(make_linked_bodies());
    all.push_back(make_solids());
    all.push_back(make_joined_bodies());
    all.push_back(make_hinged_bodies());
    all.push_back(make_sheets());
    all.push_back(make_fibres());
    return all;
  }();
  return scenes;
}

std::vector<SolverOptions> edit_options(const EditScene& scene) {
  const SolverOptions base =
      small_steps({.substeps = 2, .damping = 1, .executor = executor::serial()});
  std::vector<SolverOptions> all(7, base);
  all[1].composition = PlanComposition::joint;
  all[1].coloring.balance = true;
  all[2].composition = PlanComposition::nested;
  all[2].coloring = {.algorithm = ColoringAlgorithm::random_disc};
  all[3].coloring = {.max_colors = 5};
  all[4].composition = PlanComposition::joint;
  all[4].coloring = {.max_colors = 5};
  all[5].method = SolverMethod::vertex_block;
  all[6].composition = PlanComposition::joint;
  all[6].mode = ProjectionMode::fraction;
  for (const std::size_t separate : {0, 3, 5}) {
    all[separate].composition = PlanComposition::separate;
  }
  const bool has_solid = std::ranges::any_of(scene.scene.bodies(), [](const Body& body) {
    return body.tet_count > 0 && body.material.model == ElasticModel::neo_hookean;
  });
  if (has_solid || !scene.scene.hinges().empty()) {  // whose energy fractions do not follow
    all.pop_back();
  }
  return all;
}

}  // namespace pbdsurg::testing
