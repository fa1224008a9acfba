// SPDX-License-Identifier: Apache-2.0
#include "surgical_scene.h"

#include <algorithm>
#include <limits>
#include <span>

#include "pbdsurg/anatomy/membrane.h"
#include "pbdsurg/mesh/topology.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::Material;
using pbdsurg::TetMesh;

// Elasticity of each tissue, Pa, at the small end of what the literature gives for living organs.
constexpr double kGallbladderModulus = 100e3;
constexpr double kLiverModulus = 6e3;
constexpr double kDuctModulus = 150e3;
constexpr double kArteryModulus = 200e3;
constexpr double kFatModulus = 2.5e3;
constexpr double kMembraneModulus = 60e3;
constexpr double kMembraneAreaPerLink = 2e-6;  // m^2, of cross-section

constexpr double kMembraneReach = 4.5e-3;    // m, between gallbladder and the liver's coarser mesh
constexpr double kConnectionReach = 2.5e-3;  // m, between the other organs

// An edge stands for a bar as wide as it is long: stiffness E L. A volume constraint stands for the
// bulk modulus E / (3 (1 - 2 nu)) at nu = 0.45.
Material make_material(const TetMesh& mesh, const pbdsurg::TissueProperties& tissue, double modulus,
                       bool is_tube) {
  const auto edges = pbdsurg::find_edges(mesh.tets());
  double length = 0;
  for (const auto& [a, b] : edges) {
    length +=
        (mesh.positions()[a] - mesh.positions()[b]).norm() / static_cast<double>(edges.size());
  }
  Material material;
  material.density = static_cast<float>(tissue.density);
  material.stretch.compliance = static_cast<float>(1 / (modulus * length));
  const double volume = pbdsurg::total_volume(mesh) / mesh.tet_count();
  material.volume.compliance = static_cast<float>(volume * 3 * (1 - 2 * 0.45) / modulus);
  material.has_volume_constraints = !is_tube;  // tubes have distance constraints only
  return material;
}

Index add(SurgicalScene& result, const char* name, const TetMesh& mesh,
          const pbdsurg::TissueProperties& tissue, double modulus, bool is_tube = false) {
  result.meshes.push_back(mesh);
  result.tissues.push_back(tissue);
  return result.scene.add_body(name, mesh, make_material(mesh, tissue, modulus, is_tube));
}

// Fixes the two ends of a tube along its longest side, or only the one with the larger coordinate.
void fix_ends(SurgicalScene& result, Index body, double reach, bool both) {
  const Eigen::AlignedBox3d box = pbdsurg::bounding_box(result.meshes[body]);
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  result.scene.fix_where(body, [&](const Eigen::Vector3d& p) {
    return p[axis] > box.max()[axis] - reach || (both && p[axis] < box.min()[axis] + reach);
  });
}

pbdsurg::Stiffness membrane_stiffness(double rest_length) {
  return {1.0F, static_cast<float>(rest_length / (kMembraneModulus * kMembraneAreaPerLink))};
}

std::vector<pbdsurg::MembraneLink> link_surfaces(SurgicalScene& result, Index first, Index second,
                                                 double reach) {
  const std::vector<pbdsurg::MembraneLink> links =
      pbdsurg::membrane_links(result.meshes[first], result.meshes[second], reach);
  for (const pbdsurg::MembraneLink& link : links) {
    result.scene.add_link({result.scene.body(first).first_vertex + link.first,
                           result.scene.body(second).first_vertex + link.second,
                           static_cast<float>(link.rest_length),
                           membrane_stiffness(std::max(link.rest_length, 0.2e-3))});
  }
  return links;
}

// Links each vertex of an enclosed tube to the nearest vertex of what encloses it, inside or out.
void link_enclosed(SurgicalScene& result, Index tube, Index around, double reach) {
  const auto inner = result.meshes[tube].positions();
  const auto outer = result.meshes[around].positions();
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
      result.scene.add_link({result.scene.body(tube).first_vertex + static_cast<Index>(v),
                             result.scene.body(around).first_vertex + partner,
                             static_cast<float>(nearest),
                             membrane_stiffness(std::max(nearest, 0.2e-3))});
    }
  }
}

}  // namespace

SurgicalScene make_scene(const pbdsurg::CholecystectomyAnatomy& anatomy) {
  SurgicalScene result;
  result.scene.set_gravity({0, 0, -9.81F});
  add(result, "gallbladder", anatomy.gallbladder, pbdsurg::kGallbladderWall, kGallbladderModulus);
  add(result, "liver", anatomy.liver, pbdsurg::kLiver, kLiverModulus);
  add(result, "cystic_duct", anatomy.cystic_duct, pbdsurg::kConnectiveTissue, kDuctModulus, true);
  add(result, "cystic_artery", anatomy.cystic_artery, pbdsurg::kConnectiveTissue, kArteryModulus,
      true);
  add(result, "calot_fat", anatomy.calot_fat, pbdsurg::kFat, kFatModulus);
  add(result, "common_bile_duct", anatomy.common_bile_duct, pbdsurg::kConnectiveTissue,
      kDuctModulus, true);

  const Eigen::AlignedBox3d liver = pbdsurg::bounding_box(anatomy.liver);
  result.scene.fix_where(kLiverBed, [&](const Eigen::Vector3d& p) {
    return p.z() > liver.min().z() + 0.6 * liver.sizes().z();
  });
  fix_ends(result, kArtery, 2e-3, false);
  fix_ends(result, kBileDuct, 3e-3, true);

  const auto membrane = link_surfaces(result, kGallbladder, kLiverBed, kMembraneReach);
  result.membrane = pbdsurg::membrane_sheet(anatomy.gallbladder, anatomy.liver, membrane);
  result.membrane_link_count = static_cast<Index>(result.scene.links().size());
  link_surfaces(result, kCalotFat, kGallbladder, kConnectionReach);
  link_surfaces(result, kCalotFat, kLiverBed, kConnectionReach);
  link_surfaces(result, kArtery, kGallbladder, kConnectionReach);
  link_surfaces(result, kDuct, kGallbladder, kConnectionReach);
  link_surfaces(result, kDuct, kBileDuct, kConnectionReach);
  link_enclosed(result, kDuct, kCalotFat, kConnectionReach);
  link_enclosed(result, kArtery, kCalotFat, kConnectionReach);
  return result;
}

}  // namespace cholecystectomy
