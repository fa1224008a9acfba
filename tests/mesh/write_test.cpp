// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/write.h"

#include <cmath>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/check.h"
#include "pbdsurg/mesh/read.h"

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"

namespace pbdsurg {
namespace {

using testing::box_mesh;
using testing::ContainsSubstring;
using testing::read_bytes;
using testing::TemporaryFolder;

}  // namespace

// Would catch text of too few digits: the coordinates fill all bits and many decades.
TEST_CASE("write: every bit of a coordinate survives", "[property]") {
  MeshData mesh = box_mesh(2);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double unit = random_unit(5, v, axis) - 0.5;
      mesh.points[v][static_cast<Eigen::Index>(axis)] =
          unit * std::pow(10.0, static_cast<double>(v % 40) - 20);
    }
  }
  mesh.points[3].x() = 5e-324;
  mesh.points[4].x() = 1.7976931348623157e308;

  const TemporaryFolder folder;
  for (const auto& [name, options] :
       std::vector<std::pair<std::string, WriteOptions>>{{"a.msh", {"2.2", MeshEncoding::ascii}},
                                                         {"b.msh", {"2.2", MeshEncoding::binary}},
                                                         {"c.msh", {"4.1", MeshEncoding::ascii}},
                                                         {"d.msh", {"4.1", MeshEncoding::binary}},
                                                         {"e.vtk", {"4.2", MeshEncoding::ascii}},
                                                         {"f.vtk", {"", MeshEncoding::binary}},
                                                         {"g.vtu", {"", MeshEncoding::ascii}},
                                                         {"h.VTU", {}},
                                                         {"i.obj", {}}}) {
    INFO(name);
    write_mesh(folder / name, mesh, options);
    const MeshData back = read_mesh(folder / name);
    CHECK((back.points == mesh.points));
    CHECK((back.triangles == mesh.triangles));
    CHECK((back.tets == mesh.tets || name == "i.obj"));
    const std::string first = read_bytes(folder / name);
    write_mesh(folder / name, mesh, options);
    CHECK(read_bytes(folder / name) == first);
  }
}

// Would catch a mesh in metres that is read back in another unit, as one of 1 m in centimetres; and
// another program's comment that is taken for ours.
TEST_CASE("write: files say that they are in metres, whatever the size", "[unit]") {
  const TemporaryFolder folder;
  folder.put("foreign.obj",
             "# was a mesh in metres, is in mm\nv 0 0 0\nv 120 0 0\nv 0 120 0\nf 1 2 3\n");
  CHECK_FALSE(read_mesh_file(folder / "foreign.obj", {LengthUnit::automatic}).stated_unit);
  for (const double size : {0.001, 0.02, 1.0, 12.0}) {
    MeshData mesh = box_mesh(1);
    for (Eigen::Vector3d& p : mesh.points) {
      p *= size;
    }
    for (const MeshEncoding encoding : {MeshEncoding::ascii, MeshEncoding::binary}) {
      for (const auto& [name, version] : std::vector<std::pair<std::string, std::string>>{
               {"a.msh", "2.2"}, {"b.msh", "4.1"}, {"c.vtk", ""}, {"d.vtu", ""}, {"e.stl", ""}}) {
        CAPTURE(name, size);
        write_mesh(folder / name, mesh, {version, encoding});
        const MeshFile back = read_mesh_file(folder / name, {LengthUnit::automatic});
        CHECK(back.stated_unit == LengthUnit::metre);
        CHECK(back.unit == LengthUnit::metre);
        CHECK_FALSE(back.unit_ambiguous());
        CHECK(read_mesh_file(folder / name, {LengthUnit::millimetre}).longest_side ==
              0.001 * back.longest_side);
      }
    }
    write_mesh(folder / "f.obj", mesh);
    CHECK(read_mesh_file(folder / "f.obj", {LengthUnit::automatic}).stated_unit);
  }
}

TEST_CASE("write: surface formats take the boundary of tets without triangles", "[unit]") {
  const TemporaryFolder folder;
  MeshData mesh = box_mesh(3);
  mesh.triangles.clear();
  for (const std::string name : {"a.stl", "b.obj"}) {
    INFO(name);
    write_mesh(folder / name, mesh);
    const MeshReport report = check_mesh(read_mesh(folder / name));
    CHECK(report.vertices == 56);
    CHECK(report.unreferenced == 0);
    CHECK(report.closed);
    CHECK_FALSE(report.inside_out);
    CHECK(report.volume == testing::Approx(check_mesh(mesh).volume));
  }
  CHECK_THROWS_AS(write_mesh(folder / "c.stl", {{{0, 0, 0}}, {}, {}}), InvalidMesh);
}

TEST_CASE("write: fields go into VTK files", "[unit]") {
  const TemporaryFolder folder;
  const MeshData mesh = box_mesh(1);
  MeshFields fields;
  fields.point.push_back({"temperature <K>", 1, std::vector<float>(8, 310.25f)});
  fields.cell.push_back({"flow", 3, std::vector<float>(3 * (6 + 12), -1.5f)});

  for (const std::string name : {"a.vtk", "b.vtu"}) {
    INFO(name);
    write_mesh(folder / name, mesh, {"", MeshEncoding::ascii}, fields);
    const std::string text = read_bytes(folder / name);
    CHECK_THAT(text, ContainsSubstring("310.25\n310.25") && ContainsSubstring("-1.5\n-1.5"));
    CHECK_THAT(text, ContainsSubstring(name == "a.vtk" ? "temperature%20<K> 1 8 float"
                                                       : "Name=\"temperature &lt;K&gt;\""));
    CHECK((read_mesh(folder / name).tets == mesh.tets));
    write_mesh(folder / name, mesh, {}, fields);
    CHECK((read_mesh(folder / name).tets == mesh.tets));
  }
  fields.cell[0].values.pop_back();
  CHECK_THROWS_WITH(write_mesh(folder / "a.vtu", mesh, {}, fields),
                    ContainsSubstring("field 'flow' has 53 values; 18 cells need 54"));
  CHECK_THROWS_AS(write_mesh(folder / "a.msh", mesh, {}, fields), InvalidArgument);
}

TEST_CASE("write: what cannot be written is refused and leaves the file alone", "[unit]") {
  const TemporaryFolder folder;
  MeshData mesh = box_mesh(1);
  const auto path = folder.put("kept.msh", "before");

  CHECK_THROWS_AS(write_mesh(folder / "a.ply", mesh), InvalidArgument);
  CHECK_THROWS_AS(write_mesh(path, mesh, {"3.0", {}}), InvalidArgument);
  CHECK_THROWS_AS(write_mesh(folder / "a.obj", mesh, {"", MeshEncoding::binary}), InvalidArgument);
  CHECK_THROWS_AS(write_mesh(folder / "none/a.msh", mesh), FileError);
  CHECK_THROWS_AS(write_mesh(folder / "", mesh), Error);
  mesh.tets[2][1] = 77;
  CHECK_THROWS_WITH(write_mesh(path, mesh), ContainsSubstring("tet 2 refers to point 77"));
  CHECK(read_bytes(path) == "before");
  CHECK_FALSE(std::filesystem::exists(folder / "kept.msh.part"));
}

}  // namespace pbdsurg
