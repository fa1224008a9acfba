// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/surgical_scene.h"

#include <limits>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/surgery/membrane.h"

#include "apps/cholecystectomy/joints.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::TetMesh;

constexpr double kMembraneAreaPerLink = 2e-6;  // m^2, of cross-section
constexpr double kTearStretch = 2;             // loose connective tissue tears at 1.5 to 2

void add_organ(SurgicalScene& result, Organ organ, const TetMesh& mesh,
               pbdsurg::ElasticModel model) {
  result.tissues.push_back(tissue_of(organ));
  pbdsurg::Material material = tissue_of(organ).mechanics;
  if (model == pbdsurg::ElasticModel::springs) {
    material = pbdsurg::springs(mesh, material);
  }
  // Implicit Euler damps more in a step of 5 ms than friction of 1 ms would, and limits of stretch
  // would fight the strands, which tear at twice their length.
  material.damping = 0;
  material.max_stretch = std::numeric_limits<float>::infinity();
  result.scene.add_body(pbdsurg::name_of(organ), mesh, material);
}

// Fixes the two ends of a tube along its longest side, or only the one with the larger coordinate.
void fix_ends(SurgicalScene& result, Organ organ, double reach, bool both) {
  const pbdsurg::Body& body = result.scene.body(body_of(organ));
  Eigen::AlignedBox3d box;
  for (Index v = body.first_vertex; v < body.first_vertex + body.vertex_count; ++v) {
    box.extend(result.scene.positions()[v]);
  }
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  result.scene.fix_where(body_of(organ), [&](const Eigen::Vector3d& p) {
    return p[axis] > box.max()[axis] - reach || (both && p[axis] < box.min()[axis] + reach);
  });
}

}  // namespace

const pbdsurg::TissueRecord& tissue_of(Organ organ) {
  switch (organ) {
    case Organ::gallbladder:
      return pbdsurg::tissues::gallbladder_wall();
    case Organ::liver:
      return pbdsurg::tissues::liver();
    case Organ::cystic_duct:
    case Organ::common_bile_duct:
      return pbdsurg::tissues::bile_duct();
    case Organ::cystic_artery:
      return pbdsurg::tissues::artery();
    case Organ::calot_fat:
      return pbdsurg::tissues::fat();
  }
  throw pbdsurg::InvalidArgument("unknown organ");
}

SurgicalScene make_scene(const LoadedAnatomy& loaded, pbdsurg::ElasticModel model) {
  const auto& organs = loaded.anatomy.organs;
  SurgicalScene result;
  result.scene.set_gravity({0, 0, -9.81F});
  for (const Organ organ : pbdsurg::kOrgans) {
    add_organ(result, organ, organs.at(organ), model);
  }

  const Eigen::AlignedBox3d liver = pbdsurg::bounding_box(organs.at(Organ::liver));
  result.scene.fix_where(body_of(Organ::liver), [&](const Eigen::Vector3d& p) {
    return p.z() > liver.min().z() + 0.6 * liver.sizes().z();
  });
  fix_ends(result, Organ::cystic_artery, 2e-3, false);
  fix_ends(result, Organ::common_bile_duct, 3e-3, true);

  const double membrane_modulus = pbdsurg::tissues::membrane().mechanics.youngs_modulus;
  for (const Joint& joint : kJoints) {
    const auto links = find_links(joint, loaded, result.warnings);
    pbdsurg::MeshData sheet =
        pbdsurg::membrane_sheet(organs.at(joint.first), organs.at(joint.second), links);
    const auto first_link = static_cast<Index>(result.connections.strands().size());
    for (const auto& [a, b, c] : sheet.triangles) {
      result.sheets.push_back({first_link + a, first_link + b, first_link + c});
    }
    if (result.joined.empty()) {
      result.membrane = std::move(sheet);
      result.membrane_link_count = static_cast<Index>(links.size());
    }
    result.connections.join(
        result.scene, body_of(joint.first), body_of(joint.second), links,
        {.stiffness = membrane_modulus * kMembraneAreaPerLink, .tear_stretch = kTearStretch});
    result.joined.push_back(
        {joint.first, joint.second, static_cast<Index>(links.size()), fibres_of(links)});
  }
  return result;
}

}  // namespace cholecystectomy
