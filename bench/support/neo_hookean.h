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

/// Pa, of an area at rest, with which a strip pulls that is stretched along its fibres and free
/// across: mu (l - J / l^2) + k (l - 1), with J where nothing pulls across, J - 1 = mu (1 - 1 / l)
/// / lambda. Compressed, fibres have no say.
/// @param fibre_stiffness  k, Pa
/// @param stretch          l, > 0
inline double uniaxial_stress(const NeoHookeanModuli& moduli, double fibre_stiffness,
                              double stretch) {
  const double volume = 1 + moduli.mu / moduli.lambda * (1 - 1 / stretch);
  return moduli.mu * (stretch - volume / (stretch * stretch)) +
         (stretch > 1 ? fibre_stiffness * (stretch - 1) : 0);
}

/// The stretch that has a uniaxial_stress(), by bisection.
/// @param stress  Pa
inline double uniaxial_stretch(const NeoHookeanModuli& moduli, double fibre_stiffness,
                               double stress) {
  double low = 0.2, high = 5;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (uniaxial_stress(moduli, fibre_stiffness, middle) < stress ? low : high) = middle;
  }
  return low;
}

/// A tetrahedron at rest.
struct Element {
  Tet vertices;
  NeoHookeanModuli moduli;
  double volume;                          ///< m^3
  std::array<Eigen::Vector3d, 4> shapes;  ///< gradients of the shape functions, 1/m
  double fibre_stiffness;                 ///< Pa
  std::array<double, 4> fibre_shares;     ///< 1/m, of corners in what becomes of the fibres
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
    const Fibre& fibre = scene.fibres()[t];
    Element element{tet, moduli[t], edges.determinant() / 6, {}, fibre.stiffness, {}};
    element.shapes[0].setZero();
    for (int i = 0; i < 3; ++i) {
      element.shapes[i + 1] = inverse.row(i).transpose();
      element.shapes[0] -= element.shapes[i + 1];
    }
    for (std::size_t i = 0; i < 4; ++i) {
      element.fibre_shares[i] = element.shapes[i].dot(fibre.direction.cast<double>());
    }
    elements.push_back(element);
  }
  return elements;
}

}  // namespace pbdsurg::bench
