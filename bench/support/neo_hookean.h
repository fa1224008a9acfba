// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the bench's own solvers know of stable Neo-Hookean tetrahedra.
///
/// Psi = mu/2 (tr F^T F - 3) + lambda/2 (det F - 1 - mu/lambda)^2, where lambda is Lame's parameter
/// plus mu: the form whose moduli at rest are those of linear elasticity (Smith, De Goes and Kim
/// 2018, "Stable Neo-Hookean Flesh Simulation"; Macklin and Mueller 2021, "A Constraint-based
/// Formulation of Stable Neo-Hookean Materials").

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::bench {

struct NeoHookeanModuli {
  /// @param stiffness  times that of the material
  explicit NeoHookeanModuli(const Material& material, double stiffness = 1) {
    const double modulus = stiffness * material.youngs_modulus;
    const double ratio = material.poissons_ratio;
    mu = modulus / (2 * (1 + ratio));
    lambda = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio)) + mu;
  }

  double mu;      ///< Pa
  double lambda;  ///< Pa
};

/// What bodies of the statics and of the motions are of: 1000 kg/m^3.
/// @param youngs_modulus  Pa
inline Material neo_hookean(double youngs_modulus, double poissons_ratio) {
  Material material;
  material.density = 1000;
  material.model = ElasticModel::neo_hookean;
  material.youngs_modulus = static_cast<float>(youngs_modulus);
  material.poissons_ratio = static_cast<float>(poissons_ratio);
  return material;
}

/// A tetrahedron at rest.
struct Element {
  Tet vertices;
  NeoHookeanModuli moduli;
  double volume;                          ///< m^3
  std::array<Eigen::Vector3d, 4> shapes;  ///< gradients of the shape functions, 1/m
};

inline std::vector<Element> make_elements(const Scene& scene) {
  const auto x = scene.positions();
  std::vector<Element> elements;
  std::vector<NeoHookeanModuli> moduli;  // [tet]
  for (const Body& body : scene.bodies()) {
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      moduli.emplace_back(body.material, scene.stiffnesses()[t]);
    }
  }
  for (std::size_t t = 0; t < moduli.size(); ++t) {
    const Tet& tet = scene.tets()[t];
    Eigen::Matrix3d edges;
    edges << x[tet[1]] - x[tet[0]], x[tet[2]] - x[tet[0]], x[tet[3]] - x[tet[0]];
    const Eigen::Matrix3d inverse = edges.inverse();
    Element element{tet, moduli[t], edges.determinant() / 6, {}};
    element.shapes[0].setZero();
    for (int i = 0; i < 3; ++i) {
      element.shapes[i + 1] = inverse.row(i).transpose();
      element.shapes[0] -= element.shapes[i + 1];
    }
    elements.push_back(element);
  }
  return elements;
}

}  // namespace pbdsurg::bench
