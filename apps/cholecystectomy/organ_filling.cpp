// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/organ_filling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/check.h"

namespace cholecystectomy {

using Eigen::Vector3d;
using pbdsurg::Organ;

namespace {

constexpr double kMostLost = 0.2;          // of a side of the bounding box
constexpr double kMostThinSurface = 0.02;  // feathered edges give as much

constexpr const char* kAdvice =
    ". Is the unit right (--unit, --scale)? `pbdsurg mesh make FILE OUT.msh --spacing MM` fills at "
    "a spacing of your choice; the resolution of its tetrahedra is kept";

// "100 x 80 x 3 mm"
std::string describe_sides(const Eigen::AlignedBox3d& box) {
  const Vector3d sides = 1e3 * box.sizes();
  std::ostringstream text;
  text << std::setprecision(3) << sides.x() << " x " << sides.y() << " x " << sides.z() << " mm";
  return text.str();
}

void check_extent(const Filling& filling, const Eigen::AlignedBox3d& filled) {
  const Vector3d wanted = filling.extent.sizes();
  if ((filled.sizes().array() < (1 - kMostLost) * wanted.array()).any()) {
    throw pbdsurg::InvalidMesh(
        filling.name + " is lost in part where it is filled with tetrahedra: " +
        describe_sides(filling.extent) + " in the scene become " + describe_sides(filled) +
        ", and no side may lose more than a fifth. Its parts are too thin, or do not hang "
        "together" +
        kAdvice);
  }
}

void warn_of_losses(const std::string& name, const pbdsurg::Tetrahedralization& filled,
                    std::vector<Warning>& warnings) {
  const pbdsurg::TetrahedralizeReport& report = filled.report;
  if (report.pieces > 1) {
    warnings.push_back(
        {"pieces_dropped",
         name + " falls into " + std::to_string(report.pieces) +
             " pieces, of which the largest is kept: " + std::to_string(report.dropped_tets) +
             " tetrahedra of " + std::to_string(report.dropped_tets + filled.mesh.tets().size()) +
             " are dropped",
         report.dropped_tets});
  }
  if (report.bridges > 0) {
    warnings.push_back({"pinched",
                        name + " is thickened at " + std::to_string(report.bridges) +
                            (report.bridges == 1 ? " spot" : " spots") + " where it was pinched",
                        report.bridges});
  }
  if (report.thin_share > kMostThinSurface) {
    std::ostringstream text;
    text << std::setprecision(2) << 100 * report.thin_share << " % of the surface of " << name
         << " lies over parts too thin for a spacing of " << 1e3 * report.spacing
         << " mm; details there may be lost";
    warnings.push_back({"thin", text.str(), 100 * report.thin_share});
  }
}

}  // namespace

double estimate_tets(Organ organ, const pbdsurg::MeshData& surface) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : surface.points) {
    centre += p / static_cast<double>(surface.points.size());
  }
  double area = 0, volume = 0;  // holes closed by cones to the centre
  for (const pbdsurg::Triangle& triangle : surface.triangles) {
    const Vector3d a = surface.points[triangle[0]] - centre;
    const Vector3d b = surface.points[triangle[1]] - centre;
    const Vector3d c = surface.points[triangle[2]] - centre;
    area += (b - a).cross(c - a).norm() / 2;
    volume += a.dot(b.cross(c)) / 6;
  }
  volume = std::abs(volume);
  if (organ == Organ::gallbladder) {  // its wall alone, which has two sides
    volume = std::min(volume, area * pbdsurg::CholecystectomyOptions{}.wall_thickness);
    area *= 2;
  }
  // twelve to a cell of the lattice, and those that its surface cuts
  const double spacing = pbdsurg::organ_recipe(organ).options.spacing;
  return 12 * volume / std::pow(spacing, 3) + 2 * area / std::pow(spacing, 2);
}

void check_tet_count(double tet_count, pbdsurg::Index max_tets, const std::string& name) {
  if (tet_count > max_tets) {
    throw pbdsurg::InvalidArgument(name + " takes about " +
                                   std::to_string(static_cast<std::int64_t>(tet_count)) +
                                   " tetrahedra; --max-tets allows " + std::to_string(max_tets) +
                                   ". Is the unit right (--unit, --scale)? `pbdsurg mesh make FILE "
                                   "OUT.msh --spacing MM` makes "
                                   "coarser tetrahedra, whose resolution is kept");
  }
}

pbdsurg::TetMesh fill(const Filling& filling, pbdsurg::Index max_tets,
                      std::vector<Warning>& warnings) {
  pbdsurg::Tetrahedralization filled;
  try {
    filled =
        pbdsurg::fill_organ(filling.organ, filling.shape,
                            pbdsurg::CholecystectomyOptions{}.wall_thickness, filling.vertex_count);
  } catch (const pbdsurg::InvalidMesh& error) {
    throw pbdsurg::InvalidMesh(filling.name + " cannot be filled with tetrahedra: " + error.what() +
                               kAdvice);
  }
  check_tet_count(static_cast<double>(filled.mesh.tets().size()), max_tets, filling.name);
  check_extent(filling, pbdsurg::bounding_box(filled.mesh));
  warn_of_losses(filling.name, filled, warnings);
  return std::move(filled.mesh);
}

void warn_of_gaps(const pbdsurg::MeshData& surface, const std::string& name,
                  std::vector<Warning>& warnings) {
  const pbdsurg::Index open_edges = pbdsurg::check_mesh(surface).welded_open_edges;
  if (open_edges > 0) {
    warnings.push_back({"gaps_filled",
                        name + " is not closed: it has " + std::to_string(open_edges) +
                            " open edges, where points at one place count as one; the gaps are "
                            "filled over",
                        open_edges});
  }
}

}  // namespace cholecystectomy
