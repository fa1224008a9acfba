// SPDX-License-Identifier: Apache-2.0
#include "surgical_scene.h"

#include "pbdsurg/anatomy/membrane.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

#include "joints.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::TetMesh;

// Elasticity of the membrane, Pa, at the small end of what the literature gives for living tissue.
constexpr double kMembraneModulus = 60e3;
constexpr double kMembraneAreaPerLink = 2e-6;  // m^2, of cross-section
constexpr double kTearStretch = 2;             // loose connective tissue tears at 1.5 to 2

struct OrganProperties {
  pbdsurg::ThermalProperties tissue;
  double modulus;  // Pa, at the small end of what the literature gives for living organs
  bool is_tube;    // tubes have distance constraints only
};

OrganProperties properties_of(Organ organ) {
  switch (organ) {
    case Organ::gallbladder:
      return {pbdsurg::kGallbladderWall, 100e3, false};
    case Organ::liver:
      return {pbdsurg::kLiver, 6e3, false};
    case Organ::cystic_duct:
    case Organ::common_bile_duct:
      return {pbdsurg::kDuct, 150e3, true};
    case Organ::cystic_artery:
      return {pbdsurg::kArtery, 200e3, true};
    case Organ::calot_fat:
      return {pbdsurg::kFat, 2.5e3, false};
  }
  throw pbdsurg::InvalidArgument("unknown organ");
}

void add_organ(SurgicalScene& result, Organ organ, const TetMesh& mesh) {
  const auto& [tissue, modulus, is_tube] = properties_of(organ);
  result.meshes.push_back(mesh);
  result.tissues.push_back(tissue);
  pbdsurg::Material material = pbdsurg::elastic_material(mesh, tissue.density, modulus);
  material.has_volume_constraints = !is_tube;
  result.scene.add_body(pbdsurg::name_of(organ), mesh, material);
}

// Fixes the two ends of a tube along its longest side, or only the one with the larger coordinate.
void fix_ends(SurgicalScene& result, Organ organ, double reach, bool both) {
  const Eigen::AlignedBox3d box = pbdsurg::bounding_box(result.meshes[body_of(organ)]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  result.scene.fix_where(body_of(organ), [&](const Eigen::Vector3d& p) {
    return p[axis] > box.max()[axis] - reach || (both && p[axis] < box.min()[axis] + reach);
  });
}

}  // namespace

SurgicalScene make_scene(const LoadedAnatomy& loaded) {
  const auto& organs = loaded.anatomy.organs;
  SurgicalScene result;
  result.scene.set_gravity({0, 0, -9.81F});
  for (const Organ organ : pbdsurg::kOrgans) {
    add_organ(result, organ, organs.at(organ));
  }

  const Eigen::AlignedBox3d liver = pbdsurg::bounding_box(organs.at(Organ::liver));
  result.scene.fix_where(body_of(Organ::liver), [&](const Eigen::Vector3d& p) {
    return p.z() > liver.min().z() + 0.6 * liver.sizes().z();
  });
  fix_ends(result, Organ::cystic_artery, 2e-3, false);
  fix_ends(result, Organ::common_bile_duct, 3e-3, true);

  for (const Joint& joint : kJoints) {
    const auto links = find_links(joint, loaded, result.warnings);
    if (result.joined.empty()) {
      result.membrane =
          pbdsurg::membrane_sheet(organs.at(joint.first), organs.at(joint.second), links);
      result.membrane_link_count = static_cast<Index>(links.size());
    }
    result.connections.join(
        result.scene, body_of(joint.first), body_of(joint.second), links,
        {.stiffness = kMembraneModulus * kMembraneAreaPerLink, .tear_stretch = kTearStretch});
    result.joined.push_back(
        {joint.first, joint.second, static_cast<Index>(links.size()), fibres_of(links)});
  }
  return result;
}

}  // namespace cholecystectomy
