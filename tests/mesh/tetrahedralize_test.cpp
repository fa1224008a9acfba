// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/tetrahedralize.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/test_surfaces.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;
using testing::ContainsSubstring;
using testing::icosphere;
using testing::joined;
using testing::turned;

constexpr double kDegree = std::numbers::pi / 180;

TetrahedralizeOptions at_spacing(double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  return options;
}

TetrahedralizeOptions with_vertices(Index count) {
  TetrahedralizeOptions options;
  options.vertex_count = count;
  return options;
}

std::vector<Triangle> boundary_of(const TetMesh& mesh) {
  std::vector<Triangle> triangles;
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
    triangles.push_back(triangle.vertices);
  }
  return triangles;
}

// Measured anew, without the tetrahedraliser's own checks: volumes are positive by TetMesh.
void require_sound(const Tetrahedralization& result, double min_degrees) {
  const TetMesh& mesh = result.mesh;
  const std::vector<Triangle> boundary = boundary_of(mesh);
  std::map<Edge, int> uses;
  for (const Triangle& triangle : boundary) {
    for (int i = 0; i < 3; ++i) {
      const Index a = triangle[i], b = triangle[(i + 1) % 3];
      ++uses[{std::min(a, b), std::max(a, b)}];
    }
  }
  for (const auto& [edge, count] : uses) {
    REQUIRE(count == 2);
  }
  const auto edge_count = static_cast<int>(find_edges(mesh.tets()).size());
  const auto face_count = (4 * mesh.tet_count() + static_cast<int>(boundary.size())) / 2;
  CHECK(mesh.vertex_count() - edge_count + face_count - mesh.tet_count() == result.report.euler);
  CHECK(find_components(mesh.vertex_count(), boundary).count == result.report.boundary_shells);

  double smallest = std::numeric_limits<double>::infinity();
  for (const Tet& tet : mesh.tets()) {
    for (const auto& [i, j] : kTetEdges) {
      // the angle between the two faces at the edge, seen along it
      const Vector3d origin = mesh.positions()[tet[i]];
      const Vector3d axis = (mesh.positions()[tet[j]] - origin).normalized();
      std::vector<Vector3d> arms;
      for (int k = 0; k < 4; ++k) {
        if (k != i && k != j) {
          const Vector3d arm = mesh.positions()[tet[k]] - origin;
          arms.push_back(arm - arm.dot(axis) * axis);
        }
      }
      smallest =
          std::min(smallest, std::atan2(arms[0].cross(arms[1]).norm(), arms[0].dot(arms[1])));
    }
  }
  CHECK(smallest == Approx(result.report.min_dihedral).epsilon(1e-9));
  CHECK(smallest >= min_degrees * kDegree);
}

double boundary_area(const TetMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : boundary_of(mesh)) {
    const auto x = mesh.positions();
    area += 0.5 * (x[b] - x[a]).cross(x[c] - x[a]).norm();
  }
  return area;
}

bool same_bytes(const TetMesh& a, const TetMesh& b) {
  return a.vertex_count() == b.vertex_count() && a.tet_count() == b.tet_count() &&
         std::memcmp(a.positions().data(), b.positions().data(), a.positions().size_bytes()) == 0 &&
         std::memcmp(a.tets().data(), b.tets().data(), a.tets().size_bytes()) == 0;
}

}  // namespace

// A polyhedron inscribed in a smooth surface misses volume and area in second order.
TEST_CASE("tetrahedralize: volume and area of a sphere converge", "[property]") {
  constexpr double kRadius = 0.02;
  const double volume = 4 * std::numbers::pi / 3 * std::pow(kRadius, 3);
  const double area = 4 * std::numbers::pi * std::pow(kRadius, 2);
  double last_volume_error = 0, last_area_error = 0;
  for (const double spacing : {0.006, 0.003, 0.0015}) {
    const auto result = tetrahedralize(sphere_shape({0, 0, 0}, kRadius), at_spacing(spacing));
    require_sound(result, 20);
    CHECK(result.report.euler == 1);
    CHECK(result.report.boundary_shells == 1);
    const double volume_error = std::abs(total_volume(result.mesh) / volume - 1);
    const double area_error = std::abs(boundary_area(result.mesh) / area - 1);
    if (last_volume_error > 0) {
      CHECK(volume_error < last_volume_error / 3);
      CHECK(area_error < last_area_error / 3);
    }
    last_volume_error = volume_error;
    last_area_error = area_error;
  }
  CHECK(last_volume_error < 0.005);
}

// Many lattice positions relative to the shape meet all stencils of the lattice tetrahedra.
TEST_CASE("tetrahedralize: no stencil leaves a gap or an inverted tetrahedron", "[property]") {
  for (int i = 0; i < 12; ++i) {
    const double radius = 0.02 + 0.00013 * i;
    const ImplicitShape shape =
        smooth_difference(rounded_box_shape({0, 0, 0}, {0.02, 0.03, 0.015}, 0.004),
                          sphere_shape({0.001 * i, 0.03, 0.02}, radius), 0.002);
    TetrahedralizeOptions options = at_spacing(0.0035);
    options.smoothing_sweeps = 0;
    const auto raw = tetrahedralize(shape, options);
    require_sound(raw, 8);
    // nothing is lost: the volume agrees with a count of sample points
    int inside = 0;
    constexpr int kSteps = 40;
    const Vector3d cell = shape.bounds().sizes() / kSteps;
    for (int s = 0; s < kSteps * kSteps * kSteps; ++s) {
      const Vector3d index(s % kSteps + 0.5, s / kSteps % kSteps + 0.5,
                           s / (kSteps * kSteps) + 0.5);
      inside += shape(shape.bounds().min() + index.cwiseProduct(cell)) < 0 ? 1 : 0;
    }
    CHECK(total_volume(raw.mesh) == Approx(inside * cell.prod()).epsilon(0.03));
  }
}

TEST_CASE("tetrahedralize: a hollow ball has two shells", "[unit]") {
  TetrahedralizeOptions options = at_spacing(0.0025);
  options.euler = 2;
  const auto result = tetrahedralize(shell_shape(sphere_shape({0, 0, 0}, 0.02), 0.003), options);
  require_sound(result, 20);
  CHECK(result.report.boundary_shells == 2);
  CHECK(result.report.thin_share == 0);
}

TEST_CASE("tetrahedralize: smoothing raises the smallest angle", "[unit]") {
  const ImplicitShape shape = ellipsoid_shape({0, 0, 0}, {0.02, 0.015, 0.012});
  TetrahedralizeOptions options = at_spacing(0.003);
  options.smoothing_sweeps = 0;
  const double raw = tetrahedralize(shape, options).report.min_dihedral;
  options.smoothing_sweeps = 5;
  const double smoothed = tetrahedralize(shape, options).report.min_dihedral;
  CHECK(raw > 8 * kDegree);
  CHECK(smoothed > raw + 5 * kDegree);
}

// Would catch uninitialised memory and orders that depend on addresses.
TEST_CASE("tetrahedralize: equal arguments give equal bytes", "[property]") {
  const auto make = [] {
    return tetrahedralize(shell_shape(ellipsoid_shape({0, 0, 0}, {0.02, 0.015, 0.012}), 0.004),
                          at_spacing(0.003))
        .mesh;
  };
  const TetMesh first = make();
  CHECK(same_bytes(first, make()));
}

TEST_CASE("tetrahedralize: a shape that moves takes its mesh along", "[property]") {
  const Vector3d radii(0.02, 0.015, 0.012);
  // a power of two and whole lattice cells, so that the moved coordinates round alike
  const double spacing = 1.0 / 256;
  const Vector3d move = spacing * Vector3d(8, -16, 32);
  const TetMesh still = tetrahedralize(ellipsoid_shape({0, 0, 0}, radii), at_spacing(spacing)).mesh;
  const TetMesh moved = tetrahedralize(ellipsoid_shape(move, radii), at_spacing(spacing)).mesh;
  REQUIRE(still.vertex_count() == moved.vertex_count());
  CHECK(std::equal(still.tets().begin(), still.tets().end(), moved.tets().begin(),
                   moved.tets().end()));
  for (Index v = 0; v < still.vertex_count(); ++v) {
    REQUIRE((moved.positions()[v] - move - still.positions()[v]).norm() < 1e-9 * spacing);
  }
}

TEST_CASE("tetrahedralize: a wanted vertex count is met", "[unit]") {
  const ImplicitShape shape = ellipsoid_shape({0, 0, 0}, {0.04, 0.015, 0.012});
  for (const Index wanted : {500, 3000}) {
    const auto result = tetrahedralize(shape, with_vertices(wanted));
    CHECK(std::abs(result.mesh.vertex_count() - wanted) <= 0.005 * wanted);
    CHECK(result.report.meshes_made <= 10);
  }
  // a wall that follows the spacing, and a surface
  const auto wall = tetrahedralize(
      [&](double spacing) { return shell_shape(shape, spacing / 0.88); }, with_vertices(2000));
  CHECK(std::abs(wall.mesh.vertex_count() - 2000) <= 10);
  const auto surface = tetrahedralize(icosphere({0, 0, 0}, 0.02, 2), with_vertices(1000));
  CHECK(std::abs(surface.mesh.vertex_count() - 1000) <= 5);
}

TEST_CASE("tetrahedralize: the largest piece is kept, or all are", "[unit]") {
  const ImplicitShape pair =
      smooth_union(sphere_shape({0, 0, 0}, 0.02), sphere_shape({0.04, 0, 0}, 0.01), 0);
  TetrahedralizeOptions options = at_spacing(0.004);
  const auto largest = tetrahedralize(pair, options);
  options.pieces = Pieces::all;
  const auto all = tetrahedralize(pair, options);

  CHECK(largest.report.pieces == 2);
  CHECK(largest.report.euler == 1);
  CHECK(all.report.euler == 2);
  CHECK(all.report.dropped_tets == 0);
  CHECK(all.mesh.tet_count() == largest.mesh.tet_count() + largest.report.dropped_tets);
  CHECK(std::all_of(largest.mesh.positions().begin(), largest.mesh.positions().end(),
                    [](const Vector3d& p) { return p.x() < 0.025; }));
}

TEST_CASE("tetrahedralize: user surfaces of any quality are filled", "[unit]") {
  constexpr double kRadius = 0.02;
  const MeshData sphere = icosphere({0, 0, 0}, kRadius, 3);
  const double volume = 4 * std::numbers::pi / 3 * std::pow(kRadius, 3);
  const auto filled = [](const MeshData& surface) {
    const auto result = tetrahedralize(surface, at_spacing(0.003));
    require_sound(result, 20);
    return total_volume(result.mesh);
  };
  CHECK(filled(sphere) == Approx(volume).epsilon(0.03));
  CHECK(filled(turned(sphere)) == Approx(volume).epsilon(0.03));
  MeshData open = sphere;
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 40);
  CHECK(filled(open) == Approx(volume).epsilon(0.05));
  // two balls at a distance of one radius share a lens of 5/16 of a ball
  CHECK(filled(joined(sphere, icosphere({kRadius, 0, 0}, kRadius, 3))) ==
        Approx(volume * (2 - 5.0 / 16)).epsilon(0.03));
  // the boundary of tetrahedra serves as a surface too
  const TetMesh mesh = tetrahedralize(sphere, at_spacing(0.004)).mesh;
  const MeshData tets{{mesh.positions().begin(), mesh.positions().end()},
                      {mesh.tets().begin(), mesh.tets().end()},
                      {}};
  CHECK(filled(tets) == Approx(volume).epsilon(0.05));
}

// Two balls that touch in a spot thinner than the lattice.
TEST_CASE("tetrahedralize: a pinched spot is bridged, not left", "[property]") {
  int bridged = 0;
  for (int i = 0; i < 8; ++i) {
    const double gap = 0.0001 * i;
    const ImplicitShape pair = smooth_union(sphere_shape({0, 0, 0}, 0.02),
                                            sphere_shape({0.0385 + gap, 0.003, 0.002}, 0.02), 0);
    const auto result = tetrahedralize(pair, at_spacing(0.004));
    require_sound(result, 15);
    bridged += result.report.bridges;
  }
  CHECK(bridged > 0);
}

TEST_CASE("tetrahedralize: parts too thin for the spacing are told", "[unit]") {
  const ImplicitShape ball = sphere_shape({0, 0, 0}, 0.02);
  TetrahedralizeOptions options = at_spacing(0.006);
  options.euler = 2;
  CHECK_THROWS_WITH(tetrahedralize(shell_shape(ball, 0.001), options),
                    ContainsSubstring("too thin"));
  // nothing at all is hit
  CHECK_THROWS_WITH(tetrahedralize(sphere_shape({0, 0, 0}, 1e-4), at_spacing(0.012)),
                    ContainsSubstring("no lattice point lies inside"));
  // a plate half a cell thick, where it comes out at all
  options.euler.reset();
  const ImplicitShape plate = rounded_box_shape({0, 0, 0}, {0.03, 0.03, 0.0028}, 0.001);
  CHECK(tetrahedralize(plate, options).report.thin_share > 0.5);
  CHECK(tetrahedralize(plate, at_spacing(0.003)).report.thin_share < 0.05);
  // a wall of fixed thickness needs more vertices than this
  CHECK_THROWS_WITH(tetrahedralize(shell_shape(ball, 0.001),
                                   [] {
                                     TetrahedralizeOptions few = with_vertices(500);
                                     few.euler = 2;
                                     return few;
                                   }()),
                    ContainsSubstring("no sound mesh with 500 vertices"));
}

// A sheet of 80 x 60 x 3 mm, turned so that it follows no plane of the lattice. Would catch a
// refusal without numbers, numbers that do not hold, and a message that names an option of some
// program.
TEST_CASE("tetrahedralize: a thin sheet is filled, or told how thick it must be", "[unit]") {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
  MeshData sheet{{},
                 {},
                 {{0, 2, 1},
                  {1, 2, 3},
                  {4, 5, 6},
                  {5, 7, 6},
                  {0, 1, 4},
                  {1, 5, 4},
                  {2, 6, 3},
                  {3, 6, 7},
                  {0, 4, 2},
                  {2, 4, 6},
                  {1, 3, 5},
                  {3, 7, 5}}};
  for (int corner = 0; corner < 8; ++corner) {
    sheet.points.emplace_back(
        turn * Vector3d(0.08 * (corner & 1), 0.03 * (corner & 2), 0.00075 * (corner & 4)));
  }
  const auto filled = tetrahedralize(sheet, at_spacing(0.0026));
  require_sound(filled, 15);
  CHECK(filled.report.pieces == 1);
  CHECK(total_volume(filled.mesh) == Approx(0.08 * 0.06 * 0.003).epsilon(0.05));

  // 0.003 / 1.12 = 0.0027; 1.12 * 0.012 = 0.013
  CHECK_THROWS_WITH(
      tetrahedralize(sheet, at_spacing(0.012)),
      ContainsSubstring("thinnest parts are 0.003 m thick") &&
          ContainsSubstring("takes a spacing of at most 0.0027 m") &&
          ContainsSubstring("for a spacing of 0.012 m they must be at least 0.013 m thick") &&
          !ContainsSubstring("choose") && !ContainsSubstring("--"));
  std::string text;
  try {
    static_cast<void>(tetrahedralize(sheet, with_vertices(800)));
  } catch (const InvalidMesh& error) {
    text = error.what();
  }
  CHECK_THAT(text, ContainsSubstring("thinnest parts are 0.003 m thick") &&
                       ContainsSubstring("for 800 vertices they must be about 0.0"));
  // the number of vertices that it names does
  const std::size_t some = text.find("and some ");
  REQUIRE(some != std::string::npos);
  const auto enough = tetrahedralize(sheet, with_vertices(std::stoi(text.substr(some + 9))));
  require_sound(enough, 15);
  CHECK(enough.report.spacing == Approx(0.0027).epsilon(0.05));
}

// Bounds may be loose, of a shape that turns inside them for one. Would catch a whole sheet, one
// cell thick, taken for a scrap since it spans little of its bounds.
TEST_CASE("tetrahedralize: a sheet far smaller than its bounds is filled as it is", "[unit]") {
  const ImplicitShape sheet = rounded_box_shape({0, 0, 0}, {0.02, 0.02, 0.0005}, 0);
  const Vector3d reach = 3 * sheet.bounds().max();
  const auto result = tetrahedralize(ImplicitShape([&sheet](const Vector3d& p) { return sheet(p); },
                                                   Eigen::AlignedBox3d(-reach, reach)),
                                     at_spacing(0.001));
  CHECK(result.report.meshes_made == 1);
  CHECK(result.report.spacing == 0.001);
  CHECK((result.mesh.positions()[0] - result.mesh.positions()[1]).norm() < 0.0016);
}

// Sheets of 100 x 100 mm along the planes of the lattice, which may lie between all of its points.
// Would catch a search that fills them finely to learn how many vertices they need, a lattice that
// is too large in place of that number, and a number from a lattice too coarse to see the sheet.
TEST_CASE("tetrahedralize: a sheet far too thin is told the vertices it needs, unmeshed",
          "[unit]") {
  const auto refusal = [](double thickness, const TetrahedralizeOptions& options) {
    try {
      static_cast<void>(
          tetrahedralize(rounded_box_shape({0, 0, 0}, {0.05, 0.05, 0.5 * thickness}, 0), options));
    } catch (const InvalidMesh& error) {
      return std::string(error.what());
    }
    return std::string("filled");
  };
  const auto vertices_in = [](const std::string& text) {
    const std::size_t some = text.find("and some ");
    return some == std::string::npos ? 0.0 : std::stod(text.substr(some + 9));
  };
  const std::map<double, double> needed{// vertices at a spacing of 0.89 thicknesses
                                        {0.001, 63'618},
                                        {0.0005, 252'674},
                                        {0.0002, 1'578'096}};
  for (const auto& [thickness, count] : needed) {
    CAPTURE(thickness);
    const std::string by_count = refusal(thickness, with_vertices(2000));
    CAPTURE(by_count);
    CHECK_THAT(by_count, ContainsSubstring("none of 4 attempts") &&
                             ContainsSubstring("for 2000 vertices they must be about 0.0058 m"));
    CHECK(vertices_in(by_count) == Approx(count).epsilon(0.15));
    const std::string by_spacing = refusal(thickness, at_spacing(0.005));
    CAPTURE(by_spacing);
    CHECK(vertices_in(by_spacing) == Approx(count).epsilon(0.15));
  }
  CHECK_THAT(refusal(0.00005, with_vertices(2000)), ContainsSubstring("parts are 5e-05 m thick"));
  // thinner than what is measured at this spacing
  CHECK_THAT(refusal(1e-6, with_vertices(100)),
             ContainsSubstring("m thick or less") && ContainsSubstring("and at least "));
}

// A sheet of 100 x 100 x 3 mm that resolves with 7800 vertices. Would catch a search that gives
// up, or jumps to the spacing that surely resolves, where a coarser mesh is sound.
TEST_CASE("tetrahedralize: a search goes on where a thin shape may yet come out", "[unit]") {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.3, Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
  const ImplicitShape flat = rounded_box_shape({0, 0, 0}, {0.05, 0.05, 0.0015}, 0);
  const Vector3d reach = turn.cwiseAbs() * flat.bounds().max();
  const auto result =
      tetrahedralize(ImplicitShape([&](const Vector3d& p) { return flat(turn.transpose() * p); },
                                   Eigen::AlignedBox3d(-reach, reach)),
                     with_vertices(5000));
  CHECK(std::abs(result.mesh.vertex_count() - 5000) <= 25);
  CHECK(result.report.thin_share > 0.5);
}

TEST_CASE("tetrahedralize: what cannot be filled is refused by name", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ImplicitShape ball = sphere_shape({0, 0, 0}, 0.02);
  const Eigen::AlignedBox3d box = ball.bounds();
  const auto shape = [&box](auto value) { return ImplicitShape(value, box); };

  CHECK_THROWS_WITH(tetrahedralize(ball, at_spacing(-1)), ContainsSubstring("spacing is -1"));
  CHECK_THROWS_AS(tetrahedralize(ball, at_spacing(nan)), InvalidArgument);
  CHECK_THROWS_AS(tetrahedralize(ball, at_spacing(0)), InvalidArgument);
  CHECK_THROWS_AS(tetrahedralize(ball, with_vertices(-5)), InvalidArgument);
  CHECK_THROWS_WITH(tetrahedralize(ball, at_spacing(1e-9)), ContainsSubstring("lattice cells"));
  TetrahedralizeOptions few_cells = at_spacing(0.001);
  few_cells.max_cells = 5000;
  CHECK_THROWS_WITH(tetrahedralize(ball, few_cells), ContainsSubstring("5000 lattice cells"));
  CHECK_THROWS_WITH(tetrahedralize(shape([](const Vector3d&) { return 1.0; }), at_spacing(0.004)),
                    ContainsSubstring("no lattice point lies inside"));
  CHECK_THROWS_AS(tetrahedralize(shape([](const Vector3d&) { return 1.0; }), with_vertices(100)),
                  InvalidMesh);
  CHECK_THROWS_WITH(
      tetrahedralize(shape([nan](const Vector3d& p) { return p.x() > 0 ? nan : -1.0; }),
                     at_spacing(0.004)),
      ContainsSubstring("must be finite"));
  CHECK_THROWS_WITH(tetrahedralize(shape([](const Vector3d&) { return -1.0; }), at_spacing(0.004)),
                    ContainsSubstring("reaches past its bounds"));
  CHECK_THROWS_WITH(tetrahedralize(half_space_shape({0, 0, 0}, {0, 0, 1}), at_spacing(0.004)),
                    ContainsSubstring("unbounded"));
  CHECK_THROWS_AS(tetrahedralize(MeshData{}, at_spacing(0.004)), InvalidMesh);
}

}  // namespace pbdsurg
