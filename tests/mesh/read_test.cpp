// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/read.h"

#include <algorithm>
#include <cmath>
#include <locale>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::box_mesh;
using testing::box_surface;
using testing::ContainsSubstring;
using testing::SampleFile;
using testing::TemporaryFolder;

void check_samples(const std::vector<SampleFile>& samples, const MeshData& wanted) {
  const TemporaryFolder folder;
  for (const SampleFile& sample : samples) {
    INFO(sample.encoding);
    for (const SampleFile::Part& part : sample.parts) {
      folder.put(part.name, part.bytes);
    }
    const MeshData mesh = read_mesh(folder / sample.parts[0].name);
    CHECK((mesh.points == wanted.points));
    CHECK((mesh.tets == wanted.tets));
    CHECK((mesh.triangles == wanted.triangles));
  }
}

/// What reading a file with this name and content says.
std::string reading(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  const std::string path = folder.put(name, bytes).string();
  try {
    static_cast<void>(read_tet_mesh(path));
  } catch (const Error& error) {
    std::string text = error.what();
    const std::size_t at = text.find(path);
    return at == std::string::npos ? text : text.replace(at, path.size(), name);
  }
  return "";
}

const std::string kMsh2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n"
    "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n"
    "$EndElements\n";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), with);
}

}  // namespace

TEST_CASE("read: one mesh is the same from every encoding", "[unit]") {
  const MeshData box = box_mesh(3);

  check_samples(testing::tet_samples(box), box);
  check_samples(testing::tet_only_samples(box), {box.points, box.tets, {}});
  const MeshData surface = box_surface(3);
  check_samples(testing::surface_samples(surface), surface);
}

// Would catch a stream that asks the locale for its decimal point or groups of digits.
// Would catch a reader that takes a text file of old Macs, or of Windows, for one long line.
TEST_CASE("read: text is the same with any line ends", "[unit]") {
  const auto with_line_ends = [](std::vector<SampleFile> samples, const std::string& line_end) {
    std::erase_if(samples, [](const SampleFile& sample) {
      return std::any_of(sample.parts.begin(), sample.parts.end(), [](const auto& part) {
        return std::any_of(part.bytes.begin(), part.bytes.end(),
                           [](char c) { return c != '\n' && (c < ' ' || c > '~'); });
      });
    });
    for (SampleFile& sample : samples) {
      for (SampleFile::Part& part : sample.parts) {
        std::string bytes;
        for (const char c : part.bytes) {
          bytes += c == '\n' ? line_end : std::string(1, c);
        }
        part.bytes = bytes;
      }
    }
    return samples;
  };
  for (const std::string line_end : {"\r", "\r\n"}) {
    CAPTURE(line_end.size());
    const auto tets = with_line_ends(testing::tet_samples(box_mesh(2)), line_end);
    CHECK(tets.size() >= 4);
    check_samples(tets, box_mesh(2));
    const auto triangles = with_line_ends(testing::surface_samples(box_surface(2)), line_end);
    CHECK(triangles.size() >= 4);
    check_samples(triangles, box_surface(2));
  }
  const std::string two = replaced(kMsh2, "$Elements\n1\n", "$Elements\n2\n");
  CHECK_THAT(reading("a.msh", replaced(two, "1 1 2 3 4\n", "1 1 2 3\r4 2 4 2 0 1 1 2 3 4\r")),
             ContainsSubstring("the line ends where a node id should be"));
}

TEST_CASE("read: numbers do not depend on the locale", "[unit]") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\2"; }
  };
  const MeshData box = box_mesh(3);

  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const std::vector<SampleFile> samples = testing::tet_samples(box);
  check_samples(samples, box);
  std::locale::global(before);
}

TEST_CASE("read: quads, polygons and strips become triangles", "[unit]") {
  const TemporaryFolder folder;

  const MeshData strip = read_mesh(
      folder.put("strip.vtk",
                 "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 float\n"
                 "0 0 0 1 0 0 0 1 0 1 1 0\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"));
  CHECK((strip.triangles == std::vector<Triangle>{{0, 1, 2}, {2, 1, 3}}));

  const MeshData quad =
      read_mesh(folder.put("quad.msh", replaced(kMsh2, "1 4 2 0 1 1 2 3 4", "1 3 2 0 1 1 2 3 4")));
  CHECK((quad.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));

  const MeshData pixel = read_mesh(
      folder.put("pixel.vtk",
                 "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n"
                 "0 0 0 1 0 0 0 1 0 1 1 0\nCELLS 2 7\n4 0 1 2 3\n1 0\nCELL_TYPES 2\n8 1\n"));
  CHECK((pixel.triangles == std::vector<Triangle>{{0, 1, 3}, {0, 3, 2}}));

  const MeshData obj = read_mesh(folder.put(
      "forms.obj",
      "# c\nmtllib x.mtl\nv 0 0 0\nv 1 0 0 # one\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
      "o part\nf 1/1/1 2//1 3/1 4\nf -4 -3 \\\n -2\n"));
  CHECK((obj.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}}));
}

TEST_CASE("read: STL corners are joined where they are equal, signs of zero apart", "[unit]") {
  const TemporaryFolder folder;
  const MeshData mesh = read_mesh(folder.put(
      "weld.stl",
      "solid facet of things\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
      "vertex 0 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 -0.0\n"
      "vertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"));

  CHECK(mesh.points.size() == 4);
  CHECK((mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

TEST_CASE("read: a mesh counted the other way round is turned as a whole", "[unit]") {
  const TemporaryFolder folder;
  const auto path =
      folder.put("turned.msh", replaced(kMsh2, "1 4 2 0 1 1 2 3 4", "1 4 2 0 1 1 3 2 4"));

  CHECK(total_volume(read_tet_mesh(path)) == Approx(1.0 / 6));
  CHECK((read_mesh(path).tets == std::vector<Tet>{{0, 2, 1, 3}}));
}

TEST_CASE("read: lengths become metres, and a guess is reported", "[unit]") {
  const TemporaryFolder folder;
  std::string scaled = kMsh2;
  for (const char* row : {"2 1 0 0", "3 0 1 0", "4 0 0 1"}) {
    scaled = replaced(scaled, row, replaced(row, " 1", " 80"));
  }
  const auto path = folder.put("mm.msh", scaled + "$Comments\n$EndComments\n");

  const MeshFile guessed = read_mesh_file(path, {LengthUnit::automatic});
  CHECK(guessed.unit == LengthUnit::millimetre);
  CHECK_FALSE(guessed.unit_ambiguous());
  CHECK_FALSE(guessed.stated_unit);
  CHECK(guessed.longest_side == Approx(0.08));
  CHECK(guessed.mesh.points[1].x() == Approx(0.08));
  CHECK(guessed.format == "Gmsh MSH 2.2, ASCII");
  CHECK(read_mesh(path).points[1].x() == 80);
  CHECK(read_mesh(path, {LengthUnit::centimetre}).points[1].x() == Approx(0.8));
}

// Would catch a guess that does not use what the organ is.
TEST_CASE("read: the size that is expected makes a guess sure", "[unit]") {
  const TemporaryFolder folder;
  const auto path = folder.put("artery.obj", "v 0 0 0\nv 12 0 0\nv 0 3 0\nf 1 2 3\n");

  const MeshFile any = read_mesh_file(path, {LengthUnit::automatic});
  CHECK(any.unit_ambiguous());
  CHECK((any.plausible_units ==
         std::vector<LengthUnit>{LengthUnit::millimetre, LengthUnit::centimetre}));
  const MeshFile artery = read_mesh_file(path, {LengthUnit::automatic, {0.01, 0.095}});
  CHECK_FALSE(artery.unit_ambiguous());
  CHECK(artery.longest_side == Approx(0.012));
}

TEST_CASE("read: a scale stands for units without a name", "[unit]") {
  const TemporaryFolder folder;
  const auto path = folder.put("inches.obj", "v 0 0 0\nv 3 0 0\nv 0 1 0\nf 1 2 3\n");

  const MeshFile file = read_mesh_file(path, {.scale = 0.0254});
  CHECK(file.mesh.points[1].x() == 3 * 0.0254);
  CHECK(file.longest_side == 3 * 0.0254);
  CHECK(file.metres_per_unit == 0.0254);
  CHECK_THROWS_WITH(read_mesh(path, {.scale = 1e308}), ContainsSubstring("no longer finite"));
  CHECK_FALSE(file.unit_ambiguous());
  for (const double scale : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    CHECK_THROWS_AS(read_mesh(path, {.scale = scale}), InvalidArgument);
  }
}

// Would catch a unit that is set on top of another, and bits that depend on when it is set.
TEST_CASE("read: a unit that is set later gives the coordinates of one told at once", "[unit]") {
  const TemporaryFolder folder;
  const auto path = folder.put("a.obj", "v 0.1 0.2 0.7\nv 12.3 0 0\nv 0 3.3 0\nf 1 2 3\n");

  MeshFile later = read_mesh_file(path);
  set_unit(later, LengthUnit::millimetre);
  const MeshFile at_once = read_mesh_file(path, {LengthUnit::millimetre});
  CHECK((later.mesh.points == at_once.mesh.points));
  CHECK(later.longest_side == at_once.longest_side);
  CHECK(later.unit == LengthUnit::millimetre);
  CHECK(later.metres_per_unit == 0.001);
  CHECK_THROWS_AS(set_unit(later, LengthUnit::centimetre), InvalidArgument);
}

TEST_CASE("read: a broken text file is refused with its line and reason", "[unit]") {
  CHECK(reading("ok.msh", kMsh2) == "");
  CHECK(reading("a.msh", replaced(kMsh2, "1 1 2 3 4", "1 1 2 3 9")) ==
        "a.msh:13: element 1 refers to node 9; no node has this id");
  CHECK(reading("a.msh", replaced(kMsh2, "3 0 1 0", "3 0 nan 0")) ==
        "a.msh:8: a coordinate is not a number; it must be finite");
  CHECK(reading("a.msh", replaced(kMsh2, "3 0 1 0", "3 0 1e999 0")) ==
        "a.msh:8: '1e999' stands where a coordinate should be");
  CHECK(reading("a.msh", replaced(kMsh2, "1 4 2 0", "1 5 2 0")) ==
        "a.msh:13: cell 1 is a hexahedron (type 5); volume cells must be four-node tetrahedra");
  CHECK(reading("a.msh", replaced(kMsh2, "1 4 2 0", "1 777 2 0")) ==
        "a.msh:13: cell 1 has the unknown type 777");
  CHECK(reading("a.msh", replaced(kMsh2, "$Nodes\n4", "$Nodes\n4000000000")) ==
        "a.msh:5: 4000000000 nodes are announced; at most 2147483647 are supported");
  CHECK_THAT(reading("a.msh", replaced(kMsh2, "$Nodes\n4", "$Nodes\n2000000000")),
             ContainsSubstring("a.msh:5: 2000000000 nodes are announced, but only"));
  CHECK(reading("a.msh", replaced(kMsh2, "$Nodes\n4", "$Nodes\n-4")) ==
        "a.msh:5: -4 is announced as the number of nodes; it must not be negative");
  CHECK(reading("a.msh", replaced(kMsh2, "$Nodes\n4", "$Nodes\n3")) ==
        "a.msh:9: the section should end here with $EndNodes");
  CHECK(reading("a.msh", replaced(kMsh2, "4 0 0 1", "3 0 0 1")) ==
        "a.msh:9: two points have the id 3");
  CHECK_THAT(reading("a.msh", replaced(kMsh2, "2.2", "4.0")),
             ContainsSubstring("a.msh:2: version 4.0 is not supported"));
  CHECK(reading("a.msh", replaced(kMsh2, "1 0 0 0", "1 0.000 0.000 0.000").substr(0, 77)) ==
        "a.msh:8: the file ends where a coordinate should be");
  CHECK(reading("a.msh", "$NOD\n0\n$ENDNOD\n") == "a.msh: the mesh is empty: it has no points");
  CHECK(reading("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n") ==
        "a.obj:3: the face refers to point 3; ids must be in [1, 3), or negative to count "
        "backwards");
  CHECK(reading("a.xyz", "1 2 3") ==
        "a.xyz: neither its first bytes nor its extension '.xyz' are those of a known format "
        "(msh, vtk, vtu, node, ele, mesh, stl, obj, ply)");
  CHECK_THAT(reading("a.vtu", "<VTKFile type='PolyData'/>"),
             ContainsSubstring("a.vtu:1: a VTKFile of type PolyData is not supported"));
  CHECK_THAT(reading("a.node", "1 3\n0 0 0 0\n"), ContainsSubstring("a.ele is not there"));
  CHECK_THAT(reading("a.mesh", "MeshVersionFormatted 2 Dimension 3 Vertices 1 0 0 0 0 Hexahedra 1"),
             ContainsSubstring("the file holds Hexahedra"));
  CHECK_THROWS_WITH(read_mesh("/nonexistent/a.msh"), ContainsSubstring("no such file"));
  CHECK_THROWS_WITH(read_mesh(std::filesystem::temp_directory_path()),
                    ContainsSubstring("not a regular file"));
}

// Would catch a reader that takes the ids of an element from the next line, or leaves some over for
// the next element: the ids of all elements that follow then belong to others. In some of these
// files the tokens add up.
TEST_CASE("read: MSH rows with too few or too many numbers are refused with their line", "[unit]") {
  // read to the end: the two tets are then found to be one
  const std::string whole =
      "a.msh: tet 1 (vertices 0 1 2 3) repeats tet 0; each may occur only once";
  const std::string two = replaced(kMsh2, "$Elements\n1\n1 4 2 0 1 1 2 3 4\n",
                                   "$Elements\n2\n1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 4\n");
  CHECK(reading("a.msh", two) == whole);
  const auto with_rows = [&](const std::string& first, const std::string& second) {
    return reading("a.msh", replaced(two, "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 3 4\n",
                                     first + "\n" + second + "\n"));
  };
  CHECK(with_rows("1 4 2 0 1 1 2 3 4 2", "4 2 0 1 1 2 3 4") ==
        "a.msh:13: '2' stands where the line of element 1 should end");
  CHECK(with_rows("1 4 2 0 1 1 2 3", "4 2 4 2 0 1 1 2 3 4") ==
        "a.msh:13: the line ends where a node id should be");
  CHECK(with_rows("1 4 2 0 1 1 2 3 4", "2 4 3 0 1 1 2 3 4") ==
        "a.msh:14: the line ends where a node id should be");
  CHECK(with_rows("1 4 1 0 1 1 2 3 4", "2 4 2 0 1 1 2 3 4") ==
        "a.msh:13: '4' stands where the line of element 1 should end");
  CHECK(with_rows("", "1 4 2 0 1 1 2 3 4 \t\r\n\n2 4 2 0 1 1 2 3 4") == whole);
  CHECK(reading("a.msh", replaced(kMsh2, "2 1 0 0\n", "2 1 0\n")) ==
        "a.msh:7: the line ends where a coordinate should be");
  CHECK(reading("a.msh", replaced(kMsh2, "2 1 0 0\n", "2 1 0 0 0\n")) ==
        "a.msh:7: '0' stands where the line of node 2 should end");

  const std::string msh1 =
      "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n2\n"
      "1 4 1 1 4 1 2 3 4\n2 4 1 1 4 1 2 3 4\n$ENDELM\n";
  CHECK(reading("a.msh", msh1) == whole);
  CHECK(reading("a.msh", replaced(msh1, "3 4\n2 4", "3 4 2\n4")) ==
        "a.msh:10: '2' stands where the line of element 1 should end");
  CHECK(reading("a.msh", replaced(msh1, "3 4\n2 4", "3\n4 2 4")) ==
        "a.msh:10: the line ends where a node id should be");

  const std::string msh4 =
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 2 1 2\n3 1 4 2\n"
      "1 1 2 3 4\n2 1 2 3 4\n$EndElements\n";
  CHECK(reading("a.msh", msh4) == whole);
  CHECK(reading("a.msh", replaced(msh4, "1 1 2 3 4\n2", "1 1 2 3 4 2\n")) ==
        "a.msh:19: '2' stands where the line of element 1 should end");
  CHECK(reading("a.msh", replaced(msh4, "1 1 2 3 4\n2", "1 1 2 3\n4 2")) ==
        "a.msh:19: the line ends where a node id should be");
  CHECK(reading("a.msh", replaced(msh4, "3 1 4 2\n1", "3 1 4 2 1\n")) ==
        "a.msh:18: '1' stands where the line of element block 1 should end");
  CHECK(reading("a.msh", replaced(msh4, "0 0 0\n1 0 0\n", "0 0\n0 1 0 0\n")) ==
        "a.msh:11: the line ends where a coordinate should be");
  CHECK(reading("a.msh", replaced(msh4, "2\n3\n4\n0 0 0\n", "2\n3\n4 0\n0 0\n")) ==
        "a.msh:10: '0' stands where the line of node 4 should end");
}

// Would catch lines and bytes that are counted from behind the mark, and a binary STL whose header
// happens to begin with one.
TEST_CASE("read: a byte-order mark moves neither lines nor bytes", "[unit]") {
  const std::string mark = "\xEF\xBB\xBF";
  CHECK(reading("a.msh", mark + kMsh2) == "");
  CHECK(reading("a.msh", mark + replaced(kMsh2, "1 1 2 3 4", "1 1 2 3 9")) ==
        "a.msh:13: element 1 refers to node 9; no node has this id");
  CHECK(reading("a.obj", mark) == "a.obj:1: the file has no vertices ('v')");
  const TemporaryFolder folder;
  std::string stl = mark + std::string(81 + 50, '\0');
  stl[80] = '\1';
  CHECK(read_mesh(folder.put("a.stl", stl)).triangles.size() == 1);
}

TEST_CASE("read: a broken binary file is refused with its byte and reason", "[unit]") {
  std::string stl(84, ' ');
  stl[80] = '\x10', stl[81] = stl[82] = '\0', stl[83] = '\x40';
  CHECK(reading("a.stl", stl) ==
        "a.stl: byte 80: 1073741840 triangles take 53687092084 bytes, but the file has 84");
  CHECK(reading("a.vtk",
                "# vtk DataFile Version 4.2\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
                "POINTS 2000000000 double\n1234") ==
        "a.vtk: byte 87: 2000000000 points are announced, but only 4 bytes are left");
}

TEST_CASE("read: a mesh that cannot be simulated says why and which file", "[unit]") {
  const std::string flat = replaced(kMsh2, "4 0 0 1", "4 1 1 0");
  CHECK_THAT(reading("a.msh", flat),
             ContainsSubstring("a.msh: tet 0") && ContainsSubstring("is flat"));
  CHECK_THAT(
      reading("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
      ContainsSubstring("is a surface of 1 triangles") && ContainsSubstring("pbdsurg mesh make"));
}

}  // namespace pbdsurg
