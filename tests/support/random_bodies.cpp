// SPDX-License-Identifier: Apache-2.0
#include "tests/support/random_bodies.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>

#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::testing {
namespace {

constexpr double kEdge = 4e-3;  // m
constexpr Stiffness kLink{0.5F, 1e-3F};

TetMesh make_mesh(Choices& choices) {
  const auto seed = static_cast<std::uint64_t>(choices.below(8));
  if (choices.below(3) > 0) {
    return make_box({1 + choices.below(2), 1, 1}, kEdge, 0.1, seed);
  }
  const auto corners = random_tet(kEdge, seed);
  std::vector<Eigen::Vector3d> points(corners.begin(), corners.end());
  points.emplace_back(0, 0, -kEdge);
  return {std::move(points), {{0, 1, 2, 3}}};
}

Material make_material(const TetMesh& mesh, ProjectionMode mode, Choices& choices) {
  Material material = elastic_material(mesh, 500.0 * (1 + choices.below(3)), 20e3);
  material.has_volume_constraints = choices.below(3) > 0;
  if (choices.below(3) == 0) {
    material.max_stretch = 1.2F;
  }
  if (mode == ProjectionMode::compliance) {
    if (choices.below(3) == 0) {
      material.model = ElasticModel::neo_hookean;
    }
    if (choices.below(3) == 0) {
      material.damping = 1e-3F;
    }
  }
  return material;
}

// One that no body has: a compaction leaves fewer bodies than their names count.
std::string make_name(const Solver& solver, const Scene& scene) {
  for (std::size_t number = solver.tissue().bodies().size() + scene.bodies().size();; ++number) {
    const std::string name = "guest " + std::to_string(number);
    const auto has_name = [&](const Body& body) { return body.name == name; };
    if (std::ranges::none_of(solver.tissue().bodies(), has_name) &&
        std::ranges::none_of(scene.bodies(), has_name)) {
      return name;
    }
  }
}

}  // namespace

Scene make_bodies(const Solver& solver, Choices& choices) {
  Scene scene;
  for (Index count = 1 + choices.below(2); count > 0; --count) {
    const std::string name = make_name(solver, scene);
    const Index kind = choices.below(4);
    if (kind == 0) {
      scene.add_particles(
          name, std::array<Eigen::Vector3d, 2>{{{0, 0, 2 * kEdge}, {kEdge, 0, 2 * kEdge}}}, 1e-5);
      continue;
    }
    if (kind == 1 && !solver.tissue().triangles().empty()) {
      const SheetMesh sheet = make_sheet({1 + choices.below(3), 1}, kEdge);
      const Index added = scene.add_sheet(name, sheet.positions, sheet.triangles,
                                          {.damping = choices.below(3) == 0 ? 1e-3F : 0.0F});
      if (choices.below(2) == 0) {
        std::vector<float> factors(sheet.triangles.size());
        std::ranges::generate(factors, [&] { return 0.5F * (1 + choices.below(5)); });
        scene.set_stiffnesses(added, factors);
      }
      continue;
    }
    const TetMesh mesh = make_mesh(choices);
    const Index body =
        scene.add_body(name, mesh, make_material(mesh, solver.options().mode, choices));
    if (scene.body(body).material.model == ElasticModel::neo_hookean &&
        has_fibres(solver.tissue()) && choices.below(2) == 0) {
      std::vector<Fibre> fibres(mesh.tets().size());
      std::ranges::generate(fibres, [&] { return make_fibre(choices); });
      scene.set_fibres(body, fibres);
    }
    if (!solver.tissue().hinges().empty() && choices.below(2) == 0) {
      scene.add_hinges(body, 1e-6F * (1 + choices.below(100)));
    }
    if (choices.below(2) == 0) {
      const auto any = [](Index) { return true; };
      const auto all = find_all(static_cast<std::size_t>(mesh.vertex_count()), any);
      scene.fix_vertices(body, pick_some(all, 3, choices));
    }
  }
  for (Index count = choices.below(4); count > 0; --count) {
    const std::vector<Index> ends = pick_some(vertices_with_tissue(scene), 2, choices);
    if (ends.size() == 2) {
      scene.add_link({ends[0], ends[1], 2e-3F, kLink});
    }
  }
  return scene;
}

bool has_fibres(const Tissue& tissue) {
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (tissue.fibre(t).stiffness > 0) {
      return true;
    }
  }
  return false;
}

Fibre make_fibre(Choices& choices) {
  const std::array<Eigen::Vector3f, 3> directions{
      {{1, 0, 0}, {0, 0.6F, -0.8F}, Eigen::Vector3f(1, 2, -2) / 3}};
  return {choices.one_of(directions), 1e3F * static_cast<float>(choices.below(3))};
}

std::vector<Index> vertices_with_tissue(const Scene& scene) {
  return find_all(scene.masses().size(), [&](Index v) { return scene.masses()[v] > 0; });
}

}  // namespace pbdsurg::testing
