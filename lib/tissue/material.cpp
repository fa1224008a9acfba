// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/material.h"

#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {

Material elastic_material(const TetMesh& mesh, double density, double youngs_modulus,
                          double poissons_ratio) {
  if (!(youngs_modulus > 0) || !std::isfinite(youngs_modulus)) {
    throw InvalidArgument("Young's modulus is " + std::to_string(youngs_modulus) +
                          " Pa; it must be positive and finite");
  }
  if (!(poissons_ratio > -1) || !(poissons_ratio < 0.5)) {
    throw InvalidArgument("Poisson's ratio is " + std::to_string(poissons_ratio) +
                          "; it must be in (-1, 0.5)");
  }
  if (mesh.tet_count() == 0) {
    throw InvalidArgument("an elastic material needs a mesh with tetrahedra");
  }
  const std::vector<Edge> edges = find_edges(mesh.tets());
  double length = 0;
  for (const auto& [a, b] : edges) {
    length += (mesh.positions()[a] - mesh.positions()[b]).norm();
  }
  length /= static_cast<double>(edges.size());
  const double volume = total_volume(mesh) / mesh.tet_count();
  Material material;
  material.density = static_cast<float>(density);
  material.model = ElasticModel::springs;
  material.stretch.compliance = static_cast<float>(1 / (youngs_modulus * length));
  material.volume.compliance =
      static_cast<float>(volume * 3 * (1 - 2 * poissons_ratio) / youngs_modulus);
  return material;
}

SheetMaterial sheet_material(const Material& solid, float thickness) {
  if (solid.model != ElasticModel::neo_hookean) {
    throw InvalidArgument("a sheet is made of a Neo-Hookean material's moduli; this one has none");
  }
  return {.thickness = thickness,
          .density = solid.density,
          .youngs_modulus = solid.youngs_modulus,
          .poissons_ratio = solid.poissons_ratio,
          .damping = solid.damping};
}

Material springs(const TetMesh& mesh, const Material& solid) {
  if (solid.model != ElasticModel::neo_hookean) {
    throw InvalidArgument("springs are made of a Neo-Hookean material's moduli; this one has none");
  }
  const Material elastic =
      elastic_material(mesh, solid.density, solid.youngs_modulus, solid.poissons_ratio);
  Material material = solid;
  material.model = ElasticModel::springs;
  material.stretch.compliance = elastic.stretch.compliance;
  material.volume.compliance = elastic.volume.compliance;
  return material;
}

}  // namespace pbdsurg
