// SPDX-License-Identifier: Apache-2.0
#include "bench/support/subject.h"

#include <algorithm>
#include <limits>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/surgery/membrane.h"
#include "pbdsurg/tissue/library.h"

#include "bench/support/paper_step.h"
#include "bench/support/sample.h"

namespace pbdsurg::bench {
namespace {

constexpr Index kMillionVertices = 183'000;  // give a million tetrahedra

TetMesh make_organ(Organ organ, Index vertex_count) {
  OrganRecipe recipe = organ_recipe(organ);
  recipe.options.vertex_count = vertex_count;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

}  // namespace

TetMesh make_liver(Index vertices) {
  return make_organ(Organ::liver, vertices);
}

TetMesh make_large_liver() {
  return make_liver(kMillionVertices);
}

Scene make_sagging_liver(Index vertices) {
  const TetMesh mesh = make_liver(vertices);
  Scene scene;
  scene.add_body("liver", mesh, tissues::liver().mechanics);
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  scene.fix_where(
      0, [&](const Eigen::Vector3d& x) { return x.z() > box.max().z() - 0.1 * box.sizes().z(); });
  return scene;
}

OrganPair make_organ_pair(const SceneSize& size) {
  return {make_organ(Organ::gallbladder, size.gallbladder_vertices),
          make_liver(size.liver_vertices)};
}

Scene make_liver_and_gallbladder(const SceneSize& size, ElasticModel model) {
  return make_liver_and_gallbladder(make_organ_pair(size), model);
}

Scene make_liver_and_gallbladder(const OrganPair& organs, ElasticModel model) {
  constexpr double kMembraneReach = 4.5e-3;  // m
  constexpr double kFixedShare = 0.4;        // of the liver's height
  constexpr double kMembraneArea = 2e-6;     // m^2, of a link
  constexpr double kLeastLength = 0.2e-3;    // m, with which a link stretches
  const auto& [gallbladder, liver] = organs;
  const auto material = [&](const TissueRecord& tissue) {
    Material real = tissue.mechanics;
    real.damping = 0;
    real.max_stretch = std::numeric_limits<float>::infinity();
    return model == ElasticModel::springs ? Material{.model = model} : real;
  };
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  const Index first =
      scene.add_body("gallbladder", gallbladder, material(tissues::gallbladder_wall()));
  const Index second = scene.add_body("liver", liver, material(tissues::liver()));
  const Eigen::AlignedBox3d box = bounding_box(liver);
  scene.fix_where(second, [&](const Eigen::Vector3d& x) {
    return x.z() > box.max().z() - kFixedShare * box.sizes().z();
  });
  for (const MembraneLink& link : membrane_links(gallbladder, liver, kMembraneReach)) {
    Stiffness stretch = scene.body(first).material.stretch;
    if (model != ElasticModel::springs) {
      const double stiffness = tissues::membrane().mechanics.youngs_modulus * kMembraneArea /
                               std::max(link.rest_length, kLeastLength);
      stretch.compliance = static_cast<float>(1 / stiffness);
    }
    scene.add_link({scene.body(first).first_vertex + link.first,
                    scene.body(second).first_vertex + link.second,
                    static_cast<float>(link.rest_length), stretch});
  }
  return scene;
}

std::vector<Subject> make_table2_subjects(bool quick, std::vector<std::string>& notes) {
  const auto samples =
      quick
          ? make_samples({1}, {Table2Kind::hollow}, notes)
          : make_samples({1, 2, 3, 4, 5}, {Table2Kind::hollow, Table2Kind::surface_filled}, notes);
  std::vector<Subject> subjects;
  for (const Sample& sample : samples) {
    subjects.push_back({sample.row, name_of(sample.kind), make_organ_scene(sample.mesh)});
  }
  if (!quick) {
    subjects.push_back({std::nullopt, "scene", make_liver_and_gallbladder(kLargestScene)});
    subjects.push_back({std::nullopt, "lattice", make_organ_scene(make_large_liver())});
  }
  return subjects;
}

}  // namespace pbdsurg::bench
