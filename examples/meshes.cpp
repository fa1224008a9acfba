// SPDX-License-Identifier: Apache-2.0
// Makes an organ, writes it, reads it back in another unit, checks it, and shows what is refused.
#include <cstdio>
#include <exception>
#include <utility>

#include "pbdsurg/mesh/check.h"
#include "pbdsurg/mesh/read.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/mesh/write.h"

using pbdsurg::LengthUnit;
using pbdsurg::MeshData;

int main() try {
  // make: shapes in metres, filled with tetrahedra
  const pbdsurg::ImplicitShape kidney =
      pbdsurg::smooth_difference(pbdsurg::ellipsoid_shape({0, 0, 0}, {0.05, 0.03, 0.025}),
                                 pbdsurg::sphere_shape({0, 0.04, 0}, 0.02), 5e-3);
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 5e-3;
  const pbdsurg::TetMesh made = pbdsurg::tetrahedralize(kidney, options).mesh;

  // convert: the extension names the format
  MeshData mesh;
  mesh.points.assign(made.positions().begin(), made.positions().end());
  mesh.tets.assign(made.tets().begin(), made.tets().end());
  pbdsurg::write_mesh("organ.vtu", mesh);
  pbdsurg::write_mesh("organ.stl", mesh);  // its surface alone

  // read: a unit that no file states is guessed from an organ's size, or given
  const pbdsurg::TetMesh read = pbdsurg::read_tet_mesh("organ.vtu", {LengthUnit::automatic});
  std::printf("%d vertices, %d tets, %.1f ml\n", read.vertex_count(), read.tet_count(),
              1e6 * pbdsurg::total_volume(read));

  // fill the surface of a file, coarser
  options.spacing = 8e-3;
  const pbdsurg::TetMesh coarse =
      pbdsurg::tetrahedralize(pbdsurg::read_mesh("organ.stl"), options).mesh;
  std::printf("coarser: %d tets, %.1f ml\n", coarse.tet_count(),
              1e6 * pbdsurg::total_volume(coarse));

  // check: a report of what is wrong, where a TetMesh would throw at the first fault
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  const pbdsurg::MeshReport report = pbdsurg::check_mesh(mesh);
  for (const pbdsurg::Finding& finding : report.findings) {
    std::printf("%s: %s\n", name_of(finding.severity), finding.text.c_str());
  }
  try {
    const pbdsurg::TetMesh refused(mesh.points, mesh.tets);
  } catch (const pbdsurg::InvalidMesh& error) {
    std::printf("refused: %s\n", error.what());
  }

  // mend: turn what is inside out
  const pbdsurg::Index turned = pbdsurg::orient_tets(mesh.points, mesh.tets);
  const pbdsurg::TetMesh mended(mesh.points, mesh.tets);
  std::printf("%d turned, %zu edges\n", turned, pbdsurg::find_edges(mended.tets()).size());
} catch (const std::exception& error) {
  std::fprintf(stderr, "meshes: %s\n", error.what());
  return 2;
}
