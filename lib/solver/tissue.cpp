// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/tissue.h"

#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {
namespace {

struct Properties {
  const char* name;
  float density;         // kg/m^3
  float youngs_modulus;  // Pa
  float max_stretch;
};

Properties properties_of(Tissue tissue) {
  switch (tissue) {
    case Tissue::liver:
      return {"liver", 1079, 5.2e3F, 1.46F};
    case Tissue::gallbladder_wall:
      return {"gallbladder_wall", 1071, 250e3F, 1.54F};
    case Tissue::fat:
      return {"fat", 911, 3.3e3F, 1.5F};
    case Tissue::duct:
      return {"duct", 1027, 480e3F, 1.5F};
    case Tissue::artery:
      return {"artery", 1050, 610e3F, 1.88F};
    case Tissue::membrane:
      return {"membrane", 1027, 60e3F, 1.5F};
  }
  throw InvalidArgument("there is no tissue " + std::to_string(static_cast<int>(tissue)));
}

}  // namespace

const char* name_of(Tissue tissue) {
  return properties_of(tissue).name;
}

Material tissue_material(Tissue tissue) {
  const Properties properties = properties_of(tissue);
  return {.density = properties.density,
          .model = ElasticModel::neo_hookean,
          .youngs_modulus = properties.youngs_modulus,
          .poissons_ratio = 0.45F,
          .damping = 1e-3F,
          .max_stretch = properties.max_stretch};
}

Material tube_material(const TetMesh& mesh, Tissue tissue) {
  const Material solid = tissue_material(tissue);
  Material tube = elastic_material(mesh, solid.density, solid.youngs_modulus, solid.poissons_ratio);
  tube.has_volume_constraints = false;
  tube.damping = solid.damping;
  tube.max_stretch = solid.max_stretch;
  return tube;
}

}  // namespace pbdsurg
