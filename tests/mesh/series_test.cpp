// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/series.h"

#include <limits>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/read.h"

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"

namespace pbdsurg {

using testing::box_mesh;
using testing::ContainsSubstring;
using testing::read_bytes;
using testing::TemporaryFolder;

TEST_CASE("series: the list is complete after each frame, whose topology may change", "[unit]") {
  const TemporaryFolder folder;
  MeshSeries series(folder / "burn.pvd");
  CHECK_THAT(read_bytes(folder / "burn.pvd"), ContainsSubstring("</VTKFile>"));

  MeshData mesh = box_mesh(2);
  series.add_frame(0, mesh);
  mesh.tets.pop_back();
  mesh.triangles.clear();
  MeshFields fields;
  fields.point.push_back({"temperature", 1, std::vector<float>(mesh.points.size(), 310)});
  fields.cell.push_back({"state", 1, std::vector<float>(mesh.tets.size(), 2)});
  series.add_frame(0.1, mesh, fields);

  CHECK(series.frame_count() == 2);
  CHECK(read_mesh(folder / "burn_000000.vtu").tets.size() == mesh.tets.size() + 1);
  CHECK((read_mesh(folder / "burn_000001.vtu").tets == mesh.tets));
  const std::string list = read_bytes(folder / "burn.pvd");
  CHECK_THAT(list, ContainsSubstring("timestep=\"0\" part=\"0\" file=\"burn_000000.vtu\"/>"));
  CHECK_THAT(list, ContainsSubstring("timestep=\"0.1\" part=\"0\" file=\"burn_000001.vtu\"/>"));
  CHECK_THAT(list, ContainsSubstring("</Collection>\n</VTKFile>"));
}

TEST_CASE("series: a bad name, time or field adds no frame", "[unit]") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(MeshSeries(folder / "a.vtu"), InvalidArgument);
  CHECK_THROWS_AS(MeshSeries(folder / "none/a.pvd"), FileError);

  MeshSeries series(folder / "a.pvd");
  series.add_frame(1, box_mesh(1));
  CHECK_THROWS_AS(series.add_frame(0.5, box_mesh(1)), InvalidArgument);
  CHECK_THROWS_AS(series.add_frame(std::numeric_limits<double>::quiet_NaN(), box_mesh(1)),
                  InvalidArgument);
  CHECK_THROWS_AS(series.add_frame(2, box_mesh(1), {{{"t", 1, {1}}}, {}}), InvalidArgument);
  CHECK(series.frame_count() == 1);
}

}  // namespace pbdsurg
