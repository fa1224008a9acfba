// SPDX-License-Identifier: Apache-2.0
#include "surgical_scene.h"

#include <limits>
#include <span>

#include "pbdsurg/anatomy/membrane.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::TetMesh;

// Elasticity of the membrane, Pa, at the small end of what the literature gives for living tissue.
constexpr double kMembraneModulus = 60e3;
constexpr double kMembraneAreaPerLink = 2e-6;  // m^2, of cross-section
constexpr double kTearStretch = 2;             // loose connective tissue tears at 1.5 to 2

constexpr double kMembraneReach = 4.5e-3;    // m, between gallbladder and the liver's coarser mesh
constexpr double kConnectionReach = 2.5e-3;  // m, between the other organs

struct OrganProperties {
  pbdsurg::TissueProperties tissue;
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

using Links = std::vector<pbdsurg::MembraneLink>;

void join(SurgicalScene& result, Organ first, Organ second, const Links& links) {
  result.connections.join(
      result.scene, body_of(first), body_of(second), links,
      {.stiffness = kMembraneModulus * kMembraneAreaPerLink, .tear_stretch = kTearStretch});
}

Links link_surfaces(SurgicalScene& result, Organ first, Organ second, double reach) {
  const Links links =
      pbdsurg::membrane_links(result.meshes[body_of(first)], result.meshes[body_of(second)], reach);
  join(result, first, second, links);
  return links;
}

// Links each vertex of an enclosed tube to the nearest vertex of what encloses it, inside or out.
void link_enclosed(SurgicalScene& result, Organ tube, Organ around, double reach) {
  const auto inner = result.meshes[body_of(tube)].positions();
  const auto outer = result.meshes[body_of(around)].positions();
  Links links;
  for (std::size_t v = 0; v < inner.size(); ++v) {
    double nearest = reach;
    Index partner = pbdsurg::kInvalidIndex;
    for (std::size_t u = 0; u < outer.size(); ++u) {
      const double distance = (inner[v] - outer[u]).norm();
      if (distance < nearest) {
        nearest = distance;
        partner = static_cast<Index>(u);
      }
    }
    if (partner != pbdsurg::kInvalidIndex) {
      links.push_back({static_cast<Index>(v), partner, nearest});
    }
  }
  join(result, tube, around, links);
}

}  // namespace

SurgicalScene make_scene(const pbdsurg::CholecystectomyAnatomy& anatomy) {
  SurgicalScene result;
  result.scene.set_gravity({0, 0, -9.81F});
  for (const Organ organ : pbdsurg::kOrgans) {
    add_organ(result, organ, anatomy.organs.at(organ));
  }

  const Eigen::AlignedBox3d liver = pbdsurg::bounding_box(anatomy.organs.at(Organ::liver));
  result.scene.fix_where(body_of(Organ::liver), [&](const Eigen::Vector3d& p) {
    return p.z() > liver.min().z() + 0.6 * liver.sizes().z();
  });
  fix_ends(result, Organ::cystic_artery, 2e-3, false);
  fix_ends(result, Organ::common_bile_duct, 3e-3, true);

  const Links membrane = link_surfaces(result, Organ::gallbladder, Organ::liver, kMembraneReach);
  result.membrane = pbdsurg::membrane_sheet(anatomy.organs.at(Organ::gallbladder),
                                            anatomy.organs.at(Organ::liver), membrane);
  result.membrane_link_count = static_cast<Index>(result.scene.links().size());
  link_surfaces(result, Organ::calot_fat, Organ::gallbladder, kConnectionReach);
  link_surfaces(result, Organ::calot_fat, Organ::liver, kConnectionReach);
  link_surfaces(result, Organ::cystic_artery, Organ::gallbladder, kConnectionReach);
  link_surfaces(result, Organ::cystic_duct, Organ::gallbladder, kConnectionReach);
  link_surfaces(result, Organ::cystic_duct, Organ::common_bile_duct, kConnectionReach);
  link_enclosed(result, Organ::cystic_duct, Organ::calot_fat, kConnectionReach);
  link_enclosed(result, Organ::cystic_artery, Organ::calot_fat, kConnectionReach);
  return result;
}

}  // namespace cholecystectomy
