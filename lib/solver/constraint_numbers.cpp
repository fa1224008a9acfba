// SPDX-License-Identifier: Apache-2.0
#include "solver/constraint_numbers.h"

#include <algorithm>
#include <cmath>

#include "solver/edge_owners.h"
#include "solver/neo_hookean_record.h"

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
                       ProjectionMode mode) {
  TetNumbers numbers;
  if (has_volume_constraints(body)) {
    numbers.volume = {static_cast<float>(tet_volume(positions, tet)),
                      stiffness_in(mode, body.material.volume), body.material.damping};
  }
  if (body.material.model == ElasticModel::neo_hookean) {
    numbers.neo_hookean = make_neo_hookean(positions, tet, {}, body.material).parameters;
  }
  return numbers;
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
    for (const Tet& tet : scene.tets().subspan(body.first_tet, body.tet_count)) {
      numbers.tets.push_back(tet_numbers(scene.positions(), tet, body, mode));
    }
  }
  return numbers;
}

std::vector<double> tet_masses_of(const Scene& scene) {
  std::vector<double> masses;
  masses.reserve(scene.tets().size());
  for (const Body& body : scene.bodies()) {
    for (const Tet& tet : scene.tets().subspan(body.first_tet, body.tet_count)) {
      masses.push_back(body.material.density * tet_volume(scene.positions(), tet));
    }
  }
  return masses;
}

bool has_damping(std::span<const Body> bodies) noexcept {
  return std::ranges::any_of(bodies, [](const Body& body) { return body.material.damping > 0; });
}

Numbers<DistanceConstraint> link_numbers(const Link& link, ProjectionMode mode) {
  return {link.rest_length, stiffness_in(mode, link.stiffness), 0};
}

}  // namespace pbdsurg
