// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/stiff_links.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

constexpr double kBeyondSofter = 10, kBeyondStiffer = 4;  // times the stiffness of an end
constexpr double kUsualSubstep = 1e-3;                    // s

// N/m, about: how a free vertex resists to be moved alone, its neighbours held.
double vertex_stiffness(const Tissue& tissue, Index vertex) {
  const double mass = tissue.masses()[vertex];
  if (tissue.is_fixed(vertex) || !(mass > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const double inertia = mass / (kUsualSubstep * kUsualSubstep);
  const Body& body = tissue.bodies()[tissue.body_of_vertex(vertex)];
  const Material& material = body.material;
  if (is_sheet(body)) {
    return inertia + double{material.youngs_modulus} * double{body.thickness};
  }
  if (body.tet_count == 0) {
    return inertia;
  }
  double stiffness = 0;  // the mean around the vertex, times that of the material
  for (const Index t : tissue.tets_at(vertex)) {
    stiffness += double{tissue.stiffness(t)} / static_cast<double>(tissue.tets_at(vertex).size());
  }
  return inertia + (material.model == ElasticModel::neo_hookean
                        ? stiffness * material.youngs_modulus * std::cbrt(mass / material.density)
                        : 1 / double{material.stretch.compliance});
}

// Neighbouring vertices of a body, each with a link, give way together, and further than each would
// alone; eight of a face that were drawn to one point burst.
constexpr float kShareInTissue = 0.7F;

bool has_tissue(const Tissue& tissue, Index vertex) {
  const Body& body = tissue.bodies()[tissue.body_of_vertex(vertex)];
  return body.tet_count > 0 || is_sheet(body);
}

}  // namespace

StiffLinkNumbers stiff_link_numbers(const Tissue& tissue, Index link,
                                    const SolverOptions& options) {
  if (options.method != SolverMethod::vertex_block) {
    return {};
  }
  const auto& [first, second, rest_length, stiffness] = tissue.links()[link];
  const double ends[2] = {vertex_stiffness(tissue, first), vertex_stiffness(tissue, second)};
  const double soft_enough = std::max(kBeyondSofter * std::min(ends[0], ends[1]),
                                      kBeyondStiffer * std::max(ends[0], ends[1]));
  const float compliance = stiffness.compliance;
  if (compliance > 0 && compliance * soft_enough >= 1) {
    return {};
  }
  const bool is_in_tissue = has_tissue(tissue, first) && has_tissue(tissue, second);
  return Numbers<StiffLinkConstraint>{rest_length, compliance, is_in_tissue ? kShareInTissue : 1};
}

}  // namespace pbdsurg
