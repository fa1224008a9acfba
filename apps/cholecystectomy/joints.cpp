// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/joints.h"

#include <algorithm>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;
using pbdsurg::TetMesh;
using Links = std::vector<pbdsurg::MembraneLink>;
using Organs = std::map<Organ, TetMesh>;

constexpr double kSamples = 2e6;  // per m^2, to measure where built-in organs face each other
constexpr double kFew = 0.25;     // of the built-in fibres

// Links each vertex of an enclosed tube to the nearest vertex of what encloses it, inside or out.
Links enclosed_links(const TetMesh& tube, const TetMesh& around, double reach) {
  const auto inner = tube.positions();
  const auto outer = around.positions();
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
  return links;
}

Links vertex_links(const Joint& joint, const Organs& organs) {
  const TetMesh &first = organs.at(joint.first), &second = organs.at(joint.second);
  return joint.is_enclosed ? enclosed_links(first, second, joint.reach)
                           : pbdsurg::membrane_links(first, second, joint.reach);
}

Links area_links(const Joint& joint, const Organs& organs, double density) {
  return pbdsurg::links_by_area(organs.at(joint.first), organs.at(joint.second),
                                {.max_distance = joint.reach, .density = density});
}

// From one surface to the other, m; 0 where they overlap. As fine as the vertices are.
double gap_between(const TetMesh& first, const TetMesh& second) {
  double gap = std::numeric_limits<double>::infinity();
  for (const auto& [mesh, other] : {std::pair(&first, &second), std::pair(&second, &first)}) {
    std::vector<pbdsurg::Triangle> triangles;
    for (const pbdsurg::BoundaryTriangle& triangle : pbdsurg::find_boundary(mesh->tets())) {
      triangles.push_back(triangle.vertices);
    }
    const pbdsurg::SurfaceDistance distance(mesh->positions(), triangles);
    for (const Eigen::Vector3d& x : other->positions()) {
      gap = std::min(gap, distance.signed_distance(x));
    }
  }
  return std::max(gap, 0.0);
}

void check(const Joint& joint, const Organs& organs, Index fibres, Index built_in,
           std::vector<Warning>& warnings) {
  if (fibres >= kFew * built_in) {
    return;
  }
  std::ostringstream text;
  text.precision(3);
  text << pbdsurg::name_of(joint.first) << " and " << pbdsurg::name_of(joint.second) << " are ";
  const double gap = fibres > 0 ? 0 : gap_between(organs.at(joint.first), organs.at(joint.second));
  if (gap >= joint.reach) {
    text << 1e3 * gap << " mm apart; strands join what is nearer than " << 1e3 * joint.reach
         << " mm, so nothing joins them";
    warnings.push_back({"apart", text.str(), 1e3 * gap});
  } else {
    text << "joined by " << fibres << " fibres, the built-in ones by " << built_in;
    warnings.push_back({"few_links", text.str(), fibres});
  }
}

}  // namespace

Index fibres_of(const std::vector<pbdsurg::MembraneLink>& links) {
  Index count = 0;
  for (const pbdsurg::MembraneLink& link : links) {
    count += link.fibres;
  }
  return count;
}

std::vector<pbdsurg::MembraneLink> find_links(const Joint& joint, const LoadedAnatomy& loaded,
                                              std::vector<Warning>& warnings) {
  const Organs& organs = loaded.anatomy.organs;
  const bool is_coarse = loaded.detail != Detail::full;
  if (loaded.own.empty() && !is_coarse) {
    return vertex_links(joint, organs);
  }
  const Index built_in = fibres_of(vertex_links(joint, loaded.built_in));
  if (built_in == 0) {
    return {};  // near, but not joined
  }
  Links links;
  if (is_coarse || loaded.own.contains(joint.first) || loaded.own.contains(joint.second)) {
    const double area = fibres_of(area_links(joint, loaded.built_in, kSamples)) / kSamples;
    links = area_links(joint, organs, built_in / area);
  } else {
    links = vertex_links(joint, organs);
  }
  check(joint, organs, fibres_of(links), built_in, warnings);
  return links;
}

}  // namespace cholecystectomy
