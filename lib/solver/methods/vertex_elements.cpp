// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/vertex_elements.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/vertex_block.h"
#include "pbdsurg/tissue/tissue_change.h"

#include "lib/solver/sets/membrane_record.h"
#include "lib/solver/sets/neo_hookean_record.h"
#include "lib/solver/state/solver_data.h"
#include "lib/tissue/hinges.h"

namespace pbdsurg {
namespace {

// Dashpots of c = this share of mu V0 / l^2 along the edges of tetrahedra that lie in all
// directions alike resist shear with the modulus mu, and a change of volume as if both Lame
// parameters were mu. A lattice of cubes is not that isotropic: up to a third more along its axes,
// and less in shear.
constexpr double kEdgeDampingShare = 2.5;

// Likewise c = this share of mu t A0 / l^2 along the edges of equilateral triangles, of a sheet as
// thick as t.
constexpr double kSheetDampingShare = 8.0 / 3;

// A sheet is thin where its hinges are less stiff than this share of its stretch. A homogeneous one
// is, where it is no thicker than a third of its edges.
constexpr float kThin = 0.1F;

// N m, mu t A of the triangle of a live hinge that has the least; zero on a solid.
float stretch_stiffness(const SolverData& data, const Tissue& tissue, Index hinge) {
  const auto triangles = sheet_triangles(tissue, hinge);
  const auto stiffness = [&](Index t) {
    return data.sets.of<MembraneConstraint>().record(t).parameters[MembraneConstraint::kStiffness];
  };
  return triangles ? std::min(stiffness((*triangles)[0]), stiffness((*triangles)[1])) : 0;
}

struct Moduli {
  double mu, lambda;  // Pa, as NeoHookeanTerms takes them
};

// @param stiffness  times that of the material
Moduli moduli_of(const Material& material, float stiffness) {
  const double youngs_modulus = double{stiffness} * material.youngs_modulus;
  const double ratio = material.poissons_ratio;
  const double mu = youngs_modulus / (2 * (1 + ratio));
  return {mu, 2 * mu * ratio / (1 - 2 * ratio) + mu};
}

VertexTet make_neo_hookean(const std::array<Vec3<double>, 4>& rest, const Material& material,
                           float stiffness) {
  const auto [mu, lambda] = moduli_of(material, stiffness);
  const Vec3<double> x[4] = {rest[0], rest[1], rest[2], rest[3]};
  const NeoHookeanTerms<double> terms = NeoHookeanTerms<double>::at_rest(x, mu, lambda);
  VertexTet tet;
  std::copy(std::begin(terms.weights), std::end(terms.weights), tet.weights.begin());
  tet.stiffness = static_cast<float>(terms.stiffness);
  tet.target = static_cast<float>(terms.target);
  const double volume = terms.target / (1 + mu / lambda);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const Vec3<double> side = x[kTetEdges[e][0]] - x[kTetEdges[e][1]];
    tet.edge_damping[e] =
        static_cast<float>(kEdgeDampingShare * material.damping * mu * volume / dot(side, side));
  }
  tet.volume_damping =
      material.damping * std::max(0.0F, static_cast<float>(1 - 2 * mu / lambda)) * tet.stiffness;
  return tet;
}

VertexTet make_volume(const ConstraintRecord<VolumeConstraint>& record) {
  VertexTet tet;
  tet.stiffness = 1 / record.parameters[VolumeConstraint::kStiffness];
  tet.target = record.parameters[VolumeConstraint::kRest];
  tet.volume_damping = record.parameters[VolumeConstraint::kDamping] * tet.stiffness;
  return tet;
}

VertexTet make_neo_hookean(const ConstraintRecord<NeoHookeanConstraint>& record,
                           const Material& material, float stiffness) {
  const Eigen::Matrix3d sides = rest_sides(record);
  std::array<Vec3<double>, 4> rest{};
  for (int k = 0; k < 3; ++k) {
    rest[k + 1] = {sides(0, k), sides(1, k), sides(2, k)};
  }
  return make_neo_hookean(rest, material, stiffness);
}

struct StretchLimit {
  float stiffness = 0;  // N/m; zero for none
  float length = 0;     // m
};

// Beyond its limit, an edge is as stiff as a bar of its tissue that is as wide as the edge is long.
StretchLimit limit_of(const Tissue& tissue, const ConstraintData& sets, Index edge) {
  const auto& limits = sets.of<StrainLimitConstraint>();
  if (!limits.is_alive(edge)) {
    return {};
  }
  const float length = limits.record(edge).parameters[StrainLimitConstraint::kLimit];
  const Material& material =
      tissue.bodies()[tissue.body_of_vertex(tissue.edges()[edge][0])].material;
  return {material.model == ElasticModel::neo_hookean
              ? material.youngs_modulus * (length / material.max_stretch)
              : 1 / material.stretch.compliance,
          length};
}

VertexSpring spring_of(const SolverData& data, Index distance, const Edge& ends) {
  VertexSpring spring{.vertices = data.places_of(ends)};
  if (data.sets.of<DistanceConstraint>().is_alive(distance)) {
    const auto& numbers = data.sets.of<DistanceConstraint>().record(distance).parameters;
    spring.stiffness = 1 / numbers[DistanceConstraint::kStiffness];
    spring.rest = numbers[DistanceConstraint::kRest];
    spring.damping = numbers[DistanceConstraint::kDamping] * spring.stiffness;
  }
  return spring;
}

// m, at rest
double longest_side(const Tissue& tissue, Index triangle) {
  const std::span<const Eigen::Vector3d> x = tissue.rest_positions();
  const auto& [a, b, c] = tissue.triangles()[triangle];
  return std::max({(x[a] - x[b]).norm(), (x[b] - x[c]).norm(), (x[c] - x[a]).norm()});
}

// Neighbours may be apart by so many of the longest edges or links, along each axis: beyond, fixed
// points wrap around and forces are wrong. An edge's length is then as exact as a float.
constexpr double kMostStretch = 128;

}  // namespace

std::vector<VertexTet> vertex_tets_at_rest(const Tissue& tissue) {
  const std::span<const Eigen::Vector3d> positions = tissue.rest_positions();
  std::vector<VertexTet> tets(tissue.tets().size());
  for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
    if (!tissue.is_tet_alive(t)) {
      continue;
    }
    const Material& material = tissue.bodies()[tissue.body_of_tet(t)].material;
    if (material.model == ElasticModel::neo_hookean) {
      std::array<Vec3<double>, 4> rest;
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector3d& x = positions[tissue.tets()[t][k]];
        rest[k] = {x.x(), x.y(), x.z()};
      }
      tets[t] = make_neo_hookean(rest, material, tissue.stiffness(t));
    } else if (material.has_volume_constraints) {
      tets[t].stiffness = 1 / material.volume.compliance;
      tets[t].target = static_cast<float>(tet_volume(positions, tissue.tets()[t]));
      tets[t].volume_damping = material.damping * tets[t].stiffness;
    }
  }
  return tets;
}

VertexTet vertex_tet(const SolverData& data, const Tissue& tissue, Index id) {
  const auto& volumes = data.sets.of<VolumeConstraint>();
  const auto& solids = data.sets.of<NeoHookeanConstraint>();
  VertexTet tet;
  if (volumes.is_alive(id)) {
    tet = make_volume(volumes.record(id));
  } else if (solids.is_alive(id)) {
    tet = make_neo_hookean(solids.record(id), tissue.bodies()[tissue.body_of_tet(id)].material,
                           tissue.stiffness(id));
  }
  tet.vertices = data.places_of(tissue.tets()[id]);
  set_fibre(data, id, tet);
  return tet;
}

void set_fibre(const SolverData& data, Index id, VertexTet& tet) {
  const auto& fibres = data.sets.of<FibreConstraint>();
  tet.fibre_shares = {};
  tet.fibre_stiffness = 0;
  if (fibres.is_alive(id)) {
    const auto numbers = fibres.record(id).parameters;
    std::copy_n(numbers.begin() + FibreConstraint::kShares, 3, tet.fibre_shares.begin());
    tet.fibre_stiffness = numbers[FibreConstraint::kStiffness];
  }
}

VertexTet resized(VertexTet tet, const Material& material, float rest_volume) {
  if (material.model != ElasticModel::neo_hookean) {
    tet.target = rest_volume;
    return tet;
  }
  const auto [mu, lambda] = moduli_of(material, 1);  // of which the quotient counts alone
  NeoHookeanTerms<double> before{};
  std::copy(tet.weights.begin(), tet.weights.end(), before.weights);
  before.stiffness = tet.stiffness;
  before.target = tet.target;
  const double ratio = rest_volume * (1 + mu / lambda) / before.target;
  const NeoHookeanTerms<double> after = before.resized(ratio);
  std::copy(std::begin(after.weights), std::end(after.weights), tet.weights.begin());
  tet.stiffness = static_cast<float>(after.stiffness);
  tet.target = static_cast<float>(after.target);
  tet.volume_damping /= static_cast<float>(ratio);
  for (float& damping : tet.edge_damping) {
    damping *= static_cast<float>(std::cbrt(ratio));
  }
  return tet;
}

VertexSpring edge_spring(const SolverData& data, const Tissue& tissue, Index edge) {
  VertexSpring spring = spring_of(data, data.sets.distance_ids.of_edge(edge), tissue.edges()[edge]);
  const StretchLimit limit = limit_of(tissue, data.sets, edge);
  spring.limit_stiffness = limit.stiffness;
  spring.limit = limit.length;
  return spring;
}

VertexSpring link_spring(const SolverData& data, const Tissue& tissue, Index link) {
  const Link& ends = tissue.links()[link];
  VertexSpring spring =
      spring_of(data, data.sets.distance_ids.of_link(link), {ends.first, ends.second});
  if (data.sets.of<StiffLinkConstraint>().is_alive(link)) {
    spring.stiffness = spring.damping = 0;  // it has phases of its own
  }
  return spring;
}

VertexTriangle vertex_triangle(const SolverData& data, const Tissue& tissue, Index id) {
  VertexTriangle triangle{.vertices = data.places_of(tissue.triangles()[id])};
  const auto& membranes = data.sets.of<MembraneConstraint>();
  if (!membranes.is_alive(id)) {
    return triangle;
  }
  const auto record = membranes.record(id);
  const Eigen::Matrix2d sides = rest_sides(record);
  const Vec3<double> x[3] = {{}, {sides(0, 0), sides(1, 0), 0}, {sides(0, 1), sides(1, 1), 0}};
  const double area = rest_area(record);
  const double mu = record.parameters[MembraneConstraint::kStiffness] / area;
  const double lambda = mu * record.parameters[MembraneConstraint::kRatio];
  const auto terms = MembraneTerms<double>::at_rest(x, mu, lambda);
  const double damping = record.parameters[MembraneConstraint::kDamping];
  triangle.stiffness = static_cast<float>(terms.stiffness);
  triangle.target = static_cast<float>(terms.target);
  triangle.area_damping =
      static_cast<float>(damping * std::max(0.0, 1 - 2 * mu / lambda) * terms.stiffness);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3<double> side = x[(i + 2) % 3] - x[(i + 1) % 3];
    triangle.weights[i] = static_cast<float>(terms.weights[i]);
    triangle.edge_damping[i] =
        static_cast<float>(kSheetDampingShare * damping * mu * area / dot(side, side));
  }
  return triangle;
}

VertexHinge vertex_hinge(const SolverData& data, const Tissue& tissue, Index id) {
  const auto& corners = tissue.hinges()[id].vertices;
  VertexHinge hinge{.vertices = data.places_of(corners)};
  const auto& bendings = data.sets.of<BendingConstraint>();
  if (!bendings.is_alive(id)) {
    return hinge;
  }
  const auto& numbers = bendings.record(id).parameters;
  const float stiffness = 1 / numbers[BendingConstraint::kStiffness];
  hinge.rest = numbers[BendingConstraint::kRest];
  hinge.damping = numbers[BendingConstraint::kDamping] * stiffness;
  if (stiffness > kThin * stretch_stiffness(data, tissue, id)) {
    hinge.stiffness = stiffness;
    return hinge;
  }
  Vec3<double> x[4];
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d& corner = tissue.rest_positions()[corners[k]];
    x[k] = {corner.x(), corner.y(), corner.z()};
  }
  const SheetHinge terms = SheetHinge::at_rest(x, double{stiffness});
  std::ranges::transform(terms.weights, hinge.weights.begin(),
                         [](double weight) { return static_cast<float>(weight); });
  hinge.moment = static_cast<float>(terms.moment);
  return hinge;
}

double edge_of_volume(double volume) {
  return 2 * std::cbrt(volume);
}

float choose_unit(const Tissue& tissue, std::span<const VertexTet> tets,
                  std::span<const VertexSpring> springs) {
  const std::span<const Eigen::Vector3d> x = tissue.rest_positions();
  double longest = 0;
  for (Index e = 0; e < static_cast<Index>(tissue.edges().size()); ++e) {
    const Edge& edge = tissue.edges()[e];
    longest = std::max(longest, tissue.is_edge_alive(e) ? (x[edge[0]] - x[edge[1]]).norm() : 0);
  }
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    const Link& link = tissue.links()[l];
    longest =
        std::max(longest, tissue.is_link_alive(l) ? (x[link.first] - x[link.second]).norm() : 0);
  }
  for (Index t = 0; t < static_cast<Index>(tissue.triangles().size()); ++t) {
    longest = std::max(longest, tissue.is_triangle_alive(t) ? longest_side(tissue, t) : 0);
  }
  for (const VertexSpring& spring : springs) {
    longest = std::max(longest, static_cast<double>(spring.rest));
  }
  for (const VertexTet& tet : tets) {
    longest = std::max(longest, edge_of_volume(tet.target));
  }
  return longest > 0
             ? static_cast<float>(std::exp2(std::ceil(std::log2(kMostStretch * longest)) - 31))
             : kUsualUnit;
}

float wide_enough(float unit, double length) {
  while (kMostStretch * length > 0x1p31 * unit) {
    unit *= 2;
  }
  return unit;
}

float wide_enough(float unit, const Tissue& tissue, const TissueChange& change,
                  std::span<const VertexTet> tets, std::span<const VertexSpring> springs) {
  const std::span<const Eigen::Vector3d> x = tissue.rest_positions();
  double longest = 0;
  for (auto e = static_cast<std::size_t>(change.first_new_edge); e < tissue.edges().size(); ++e) {
    const Edge& edge = tissue.edges()[e];
    longest = std::max(longest, (x[edge[0]] - x[edge[1]]).norm());
  }
  for (auto l = static_cast<std::size_t>(change.first_new_link); l < tissue.links().size(); ++l) {
    const Link& link = tissue.links()[l];
    longest = std::max(longest, (x[link.first] - x[link.second]).norm());
  }
  for (auto t = change.first_new_triangle; t < static_cast<Index>(tissue.triangles().size()); ++t) {
    longest = std::max(longest, longest_side(tissue, t));
  }
  for (const VertexSpring& spring : springs) {
    longest = std::max(longest, double{spring.rest});
  }
  for (const VertexTet& tet : tets) {
    longest = std::max(longest, edge_of_volume(tet.target));
  }
  return wide_enough(unit, longest);
}

}  // namespace pbdsurg
