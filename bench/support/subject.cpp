// SPDX-License-Identifier: Apache-2.0
#include "bench/support/subject.h"

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

Scene make_liver_and_gallbladder(const SceneSize& size) {
  constexpr double kMembraneReach = 4.5e-3;  // m
  constexpr double kFixedShare = 0.4;        // of the liver's height
  const TetMesh gallbladder = make_organ(Organ::gallbladder, size.gallbladder_vertices);
  const TetMesh liver = make_liver(size.liver_vertices);
  const Material springs{.model = ElasticModel::springs};  // the paper's
  Scene scene;
  scene.set_gravity({0, 0, -9.81F});
  const Index first = scene.add_body("gallbladder", gallbladder, springs);
  const Index second = scene.add_body("liver", liver, springs);
  const Eigen::AlignedBox3d box = bounding_box(liver);
  scene.fix_where(second, [&](const Eigen::Vector3d& x) {
    return x.z() > box.max().z() - kFixedShare * box.sizes().z();
  });
  for (const MembraneLink& link : membrane_links(gallbladder, liver, kMembraneReach)) {
    scene.add_link({scene.body(first).first_vertex + link.first,
                    scene.body(second).first_vertex + link.second,
                    static_cast<float>(link.rest_length), springs.stretch});
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
