// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/stiff_links.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pbdsurg {
namespace {

constexpr double kStiffLink = 10;    // times the stiffness of an end
constexpr double kShortStep = 1e-3;  // s: in longer substeps, inertia resists less

// N/m, about: how a free vertex resists to be moved alone, its neighbours held.
double vertex_stiffness(const Tissue& tissue, Index vertex) {
  const double mass = tissue.masses()[vertex];
  if (tissue.is_fixed(vertex) || !(mass > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const double inertia = mass / (kShortStep * kShortStep);
  const Body& body = tissue.bodies()[tissue.body_of_vertex(vertex)];
  if (body.tet_count == 0) {
    return inertia;
  }
  const Material& material = body.material;
  return inertia + (material.model == ElasticModel::neo_hookean
                        ? material.youngs_modulus * std::cbrt(mass / material.density)
                        : 1 / double{material.stretch.compliance});
}

}  // namespace

bool is_stiff_link(const Tissue& tissue, Index link, const SolverOptions& options) {
  if (options.method != SolverMethod::vertex_block) {
    return false;
  }
  const Link& joined = tissue.links()[link];
  const double softer =
      std::min(vertex_stiffness(tissue, joined.first), vertex_stiffness(tissue, joined.second));
  const double compliance = joined.stiffness.compliance;
  return compliance == 0 || compliance * kStiffLink * softer < 1;
}

}  // namespace pbdsurg
