// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/constraint_numbers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/solver/sets/edge_owners.h"
#include "lib/solver/sets/fibre_record.h"
#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/tissue/hinges.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

// What a projection takes: a fraction, or a compliance, m/N or m^5/N.
float stiffness_in(ProjectionMode mode, const Stiffness& stiffness) noexcept {
  return mode == ProjectionMode::fraction ? stiffness.fraction : stiffness.compliance;
}

EdgeNumbers edge_numbers(double length, const Material& material, ProjectionMode mode) {
  EdgeNumbers numbers;
  if (material.model == ElasticModel::springs) {
    numbers.distance = {static_cast<float>(length), stiffness_in(mode, material.stretch),
                        material.damping};
  }
  if (std::isfinite(material.max_stretch)) {
    numbers.limit = {static_cast<float>(material.max_stretch * length)};
  }
  return numbers;
}

TetNumbers tet_numbers(std::span<const Eigen::Vector3d> positions, const Tet& tet, const Body& body,
                       float stiffness, const Fibre& fibre, ProjectionMode mode) {
  TetNumbers numbers;
  if (has_volume_constraints(body)) {
    numbers.volume = {static_cast<float>(tet_volume(positions, tet)),
                      stiffness_in(mode, body.material.volume), body.material.damping};
  }
  if (body.material.model == ElasticModel::neo_hookean) {
    numbers.neo_hookean = make_neo_hookean(positions, tet, {}, body.material, stiffness).parameters;
  }
  if (fibre.stiffness > 0) {
    numbers.fibre = fibre_numbers(*numbers.neo_hookean, fibre);
  }
  return numbers;
}

// @param stiffness  times that of its rigidity
Numbers<BendingConstraint> hinge_numbers(std::span<const Eigen::Vector3d> positions,
                                         const Hinge& hinge, const Material& material,
                                         double stiffness) {
  Vec3<double> x[4];
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d& position = positions[hinge.vertices[k]];
    x[k] = {position.x(), position.y(), position.z()};
  }
  const HingeAtRest rest = hinge_at_rest(x, hinge.rigidity);
  return {static_cast<float>(rest.turn), static_cast<float>(1 / (stiffness * rest.stiffness)),
          material.damping};
}

const Material& material_of(std::span<const Body> bodies, Index vertex) {
  const auto after = std::ranges::upper_bound(bodies, vertex, {}, &Body::first_vertex);
  return std::prev(after)->material;
}

// Of an edge of a part, from the six lengths of the parent.
float length_between(const std::array<double, 4>& a, const std::array<double, 4>& b,
                     const std::array<double, 6>& lengths) {
  double square = 0;
  double longest = 0;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdges[e];
    square -= lengths[e] * lengths[e] * (a[i] - b[i]) * (a[j] - b[j]);
    longest = std::max(longest, lengths[e]);
  }
  constexpr double kShortest = 1e-3;  // lengths that were changed may belong to no tetrahedron
  return static_cast<float>(std::max(std::sqrt(std::max(square, 0.0)), kShortest * longest));
}

}  // namespace

ConstraintNumbers numbers_at_rest(const Scene& scene, std::span<const Edge> edges,
                                  ProjectionMode mode) {
  ConstraintNumbers numbers;
  numbers.edges.reserve(edges.size());
  numbers.tets.reserve(scene.tets().size());
  std::size_t b = 0;  // edges are sorted, so their bodies ascend
  for (const Edge& edge : edges) {
    while (edge[0] >= scene.bodies()[b].first_vertex + scene.bodies()[b].vertex_count) {
      ++b;
    }
    const double length = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
    numbers.edges.push_back(edge_numbers(length, scene.bodies()[b].material, mode));
  }
  for (const Body& body : scene.bodies()) {
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      numbers.tets.push_back(tet_numbers(scene.positions(), scene.tets()[t], body,
                                         scene.stiffnesses()[t], scene.fibres()[t], mode));
    }
  }
  for (const Body& body : scene.bodies()) {
    for (Index t = body.first_triangle; t < body.first_triangle + body.triangle_count; ++t) {
      numbers.triangles.emplace_back(make_membrane(scene.positions(), scene.triangles()[t], {},
                                                   body, scene.triangle_stiffnesses()[t])
                                         .parameters);
    }
  }
  const std::vector<double> stiffnesses = hinge_stiffnesses(scene);
  for (std::size_t h = 0; h < stiffnesses.size(); ++h) {
    const Hinge& hinge = scene.hinges()[h];
    numbers.hinges.emplace_back(hinge_numbers(
        scene.positions(), hinge, material_of(scene.bodies(), hinge.vertices[0]), stiffnesses[h]));
  }
  return numbers;
}

ConstraintNumbers numbers_at_rest(const Tissue& tissue, ProjectionMode mode) {
  const std::span<const Eigen::Vector3d> positions = tissue.rest_positions();
  ConstraintNumbers numbers;
  numbers.edges.resize(tissue.edges().size());
  for (std::size_t e = 0; e < numbers.edges.size(); ++e) {
    const auto [a, b] = tissue.edges()[e];
    if (tissue.edge_tets()[e] > 0) {
      numbers.edges[e] = edge_numbers((positions[a] - positions[b]).norm(),
                                      tissue.bodies()[tissue.body_of_vertex(a)].material, mode);
    }
  }
  numbers.tets.resize(tissue.tets().size());
  for (Index t = 0; t < static_cast<Index>(numbers.tets.size()); ++t) {
    if (tissue.is_tet_alive(t)) {
      numbers.tets[t] =
          tet_numbers(positions, tissue.tets()[t], tissue.bodies()[tissue.body_of_tet(t)],
                      tissue.stiffness(t), tissue.fibre(t), mode);
    }
  }
  numbers.triangles.resize(tissue.triangles().size());
  for (Index t = 0; t < static_cast<Index>(numbers.triangles.size()); ++t) {
    if (tissue.is_triangle_alive(t)) {
      numbers.triangles[t] =
          make_membrane(positions, tissue.triangles()[t], {},
                        tissue.bodies()[tissue.body_of_triangle(t)], tissue.triangle_stiffness(t))
              .parameters;
    }
  }
  numbers.hinges.resize(tissue.hinges().size());
  for (Index h = 0; h < static_cast<Index>(numbers.hinges.size()); ++h) {
    if (tissue.is_hinge_alive(h)) {
      numbers.hinges[h] = hinge_numbers(tissue, h);
    }
  }
  return numbers;
}

Numbers<BendingConstraint> hinge_numbers(const Tissue& tissue, Index hinge) {
  const Hinge& own = tissue.hinges()[hinge];
  const Body& body = tissue.bodies()[tissue.body_of_vertex(own.vertices[0])];
  return hinge_numbers(tissue.rest_positions(), own, body.material, hinge_stiffness(tissue, hinge));
}

void check_materials(std::span<const Body> bodies, ProjectionMode mode) {
  for (const Body& body : bodies) {
    if ((body.tet_count > 0 || is_sheet(body)) &&
        body.material.model == ElasticModel::neo_hookean && mode == ProjectionMode::fraction) {
      throw InvalidArgument("body '" + body.name + "' is " +
                            (is_sheet(body) ? "a sheet" : "Neo-Hookean") +
                            ", which has moduli and no fraction: such bodies need "
                            "the compliance mode");
    }
  }
}

void check_hinges(std::size_t count, ProjectionMode mode) {
  if (count > 0 && mode == ProjectionMode::fraction) {
    throw InvalidArgument("the " + std::to_string(count) +
                          " hinges have a rigidity and no fraction: they need the compliance mode");
  }
}

bool has_damping(std::span<const Body> bodies) noexcept {
  return std::ranges::any_of(bodies, [](const Body& body) { return body.material.damping > 0; });
}

Numbers<DistanceConstraint> link_numbers(const Link& link, ProjectionMode mode) {
  return {link.rest_length, stiffness_in(mode, link.stiffness), 0};
}

EdgeNumbers part_numbers(const std::array<EdgeNumbers, 6>& parent, const std::array<double, 4>& a,
                         const std::array<double, 4>& b) {
  EdgeNumbers numbers = parent.front();
  std::array<double, 6> lengths{};
  if (numbers.distance) {
    for (std::size_t e = 0; e < 6; ++e) {
      lengths[e] = (*parent[e].distance)[DistanceConstraint::kRest];
    }
    (*numbers.distance)[DistanceConstraint::kRest] = length_between(a, b, lengths);
  }
  if (numbers.limit) {
    for (std::size_t e = 0; e < 6; ++e) {
      lengths[e] = (*parent[e].limit)[StrainLimitConstraint::kLimit];
    }
    (*numbers.limit)[StrainLimitConstraint::kLimit] = length_between(a, b, lengths);
  }
  return numbers;
}

}  // namespace pbdsurg
