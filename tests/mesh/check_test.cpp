// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "tests/support/catch.h"
#include "tests/support/sample_files.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::box_mesh;
using testing::box_surface;

bool finds(const MeshReport& report, Severity severity, const std::string& text) {
  return std::any_of(report.findings.begin(), report.findings.end(), [&](const Finding& finding) {
    return finding.severity == severity && finding.text.find(text) != std::string::npos;
  });
}

/// Appends a copy of another mesh, moved along x.
void append(MeshData& mesh, const MeshData& other, double shift) {
  const auto first = static_cast<Index>(mesh.points.size());
  for (const Eigen::Vector3d& p : other.points) {
    mesh.points.emplace_back(p + Eigen::Vector3d(shift, 0, 0));
  }
  for (Tet tet : other.tets) {
    for (Index& v : tet) {
      v += first;
    }
    mesh.tets.push_back(tet);
  }
  for (Triangle triangle : other.triangles) {
    for (Index& v : triangle) {
      v += first;
    }
    mesh.triangles.push_back(triangle);
  }
}

}  // namespace

TEST_CASE("check: a box of tets is counted and measured", "[unit]") {
  MeshData mesh = box_mesh(3);
  mesh.points.emplace_back(9, 9, 9);

  const MeshReport report = check_mesh(mesh);

  CHECK(report.vertices == 64);
  CHECK(report.boundary_vertices == 56);
  CHECK(report.unreferenced == 1);
  CHECK(report.tets == 162);
  CHECK(report.boundary_triangles == 108);
  CHECK(report.edges == 64 + 162 + 56 - 3);  // E = V + T + Vb - 3 for a solid
  CHECK(report.components == 1);
  CHECK(report.shells == 1);
  CHECK(report.euler == 1);
  CHECK(report.closed);
  CHECK(report.volume == Approx(27.0 / (64 * 64 * 64)));
  CHECK(report.area == Approx(54.0 / (64 * 64)));
  CHECK(report.shortest_edge == Approx(1.0 / 64));
  CHECK(report.longest_edge == Approx(std::sqrt(3.0) / 64));
  CHECK(report.min_dihedral == Approx(std::numbers::pi / 4));
  CHECK(report.max_dihedral == Approx(std::numbers::pi / 2));
  CHECK(report.max_vertex_tets == 24);
  CHECK(report.inverted + report.flat + report.duplicate_points + report.near_points +
            report.overfull_faces + report.pinched_vertices + report.overshared_edges ==
        0);
  CHECK_FALSE(report.has_errors());
  REQUIRE(report.findings.size() == 1);
  CHECK(report.findings[0].text == "points that no element uses: 1 (64)");
}

TEST_CASE("check: inverted means against the majority", "[unit]") {
  MeshData mesh = box_mesh(2);
  const double volume = check_mesh(mesh).volume;
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  const MeshReport one = check_mesh(mesh);
  for (Tet& tet : mesh.tets) {
    std::swap(tet[2], tet[3]);
  }
  const MeshReport all_but_one = check_mesh(mesh);

  CHECK(one.inverted == 1);
  CHECK_FALSE(one.turned);
  CHECK(finds(one, Severity::error, "inverted tets: 1 (7)"));
  CHECK(all_but_one.inverted == 1);
  CHECK(all_but_one.turned);
  CHECK(finds(all_but_one, Severity::error, "inverted tets: 1 (7)"));
  CHECK(all_but_one.volume == Approx(volume * 46 / 48));
  CHECK(one.volume == Approx(volume * 46 / 48));
}

TEST_CASE("check: flat, repeated and overlapping tets are errors", "[unit]") {
  MeshData mesh = box_mesh(1);
  mesh.tets.push_back({0, 1, 3, 2});  // four corners of one side
  CHECK(finds(check_mesh(mesh), Severity::error, "flat tets (volume zero to rounding): 1 (6)"));

  mesh.tets.back() = {0, 1, 1, 2};
  CHECK(finds(check_mesh(mesh), Severity::error, "tets that use a vertex twice: 1 (6)"));

  mesh.tets.back() = mesh.tets[2];
  std::rotate(mesh.tets.back().begin(), mesh.tets.back().begin() + 1, mesh.tets.back().end());
  CHECK(check_mesh(mesh).duplicate_tets == 1);
  CHECK(finds(check_mesh(mesh), Severity::error, "tets that repeat an earlier one: 1 (6 as 2)"));

  // a third tet on the inner face of the first one
  const MeshData pair{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.5, 0.5, 2}},
                      {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}},
                      {}};
  CHECK(check_mesh(pair).overfull_faces == 1);
  CHECK(finds(check_mesh(pair), Severity::error, "faces of three or more tets"));
}

TEST_CASE("check: what only touches is pinched, and parts are counted", "[unit]") {
  const MeshData at_vertex{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
      {{0, 1, 2, 3}, {0, 5, 4, 6}},
      {}};
  const MeshReport vertex = check_mesh(at_vertex);
  CHECK(vertex.pinched_vertices == 1);
  CHECK(vertex.components == 1);
  CHECK(vertex.shells == 2);
  CHECK(vertex.overshared_edges == 0);
  CHECK(finds(vertex, Severity::warning, "pinched vertices"));

  const MeshData at_edge{{{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                         {{0, 2, 3, 1}, {0, 4, 5, 1}},
                         {}};
  const MeshReport edge = check_mesh(at_edge);
  CHECK(edge.overshared_edges == 1);
  CHECK_FALSE(edge.closed);

  MeshData two = box_mesh(1);
  append(two, box_mesh(1), 1);
  const MeshReport parts = check_mesh(two);
  CHECK(parts.components == 2);
  CHECK(parts.shells == 2);
  CHECK(parts.euler == 2);
}

TEST_CASE("check: a hollow mesh has two shells", "[unit]") {
  MeshData mesh = box_mesh(3);
  const Index centre = 1 + 4 * (1 + 4 * 1);  // first corner of the middle cube
  std::erase_if(mesh.tets, [&](const Tet& tet) {
    return std::find(tet.begin(), tet.end(), centre) != tet.end() &&
           std::find(tet.begin(), tet.end(), centre + 1 + 4 + 16) != tet.end();
  });
  REQUIRE(mesh.tets.size() == 156);

  const MeshReport report = check_mesh(mesh);
  CHECK(report.shells == 2);
  CHECK(report.euler == 2);
  CHECK(report.closed);
  CHECK(finds(report, Severity::note, "2 closed shells"));
}

TEST_CASE("check: repeated points are found exactly and nearly, at every scale", "[property]") {
  const double scale = GENERATE(1e3, 1.0, 1e-6);
  MeshData mesh = box_mesh(2);
  append(mesh, box_mesh(1), 2.0 / 64);  // touches with four corners at equal places
  mesh.points.back() += Eigen::Vector3d(1e-9, 0, 0);
  const MeshData corner{
      {{-1.0 / 64 + 2e-8, 0, 0}, {-1, 0, 0}, {-1, -1, 0}, {-1, 0, -1}}, {{0, 1, 2, 3}}, {}};
  append(mesh, corner, 0);
  for (Eigen::Vector3d& p : mesh.points) {
    p *= scale;
  }

  const MeshReport report = check_mesh(mesh);

  CHECK(report.duplicate_points == 4);
  CHECK(report.near_points == 1);
  CHECK(finds(report, Severity::warning, "(35 as 0)"));
}

// Would catch seams that are taken for holes without a word of what closes them.
TEST_CASE("check: what welding repeated points would change is told", "[unit]") {
  MeshData seams;  // every triangle has points of its own, as in a picture with a texture
  const MeshData surface = box_surface(1);
  for (const Triangle& t : surface.triangles) {
    append(seams,
           {{surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]}, {}, {{0, 1, 2}}},
           0);
  }
  const MeshReport report = check_mesh(seams);
  CHECK(report.duplicate_points == 36 - 8);
  CHECK(report.open_edges == 36);
  CHECK(report.welded_open_edges == 0);
  CHECK(report.components == 12);
  CHECK(report.welded_components == 1);
  CHECK(report.self_crossings == 0);
  CHECK(finds(report, Severity::note,
              "welding the repeated points would change parts 12 -> 1, open edges 36 -> 0"));

  MeshData touching = box_mesh(1);
  append(touching, box_mesh(1), 1.0 / 64);
  const MeshReport tets = check_mesh(touching);
  CHECK(tets.duplicate_points == 4);
  CHECK(tets.self_crossings == 0);
  CHECK(finds(tets, Severity::note, "would change parts 2 -> 1, boundary triangles 24 -> 20"));

  MeshData needle = box_surface(1);
  needle.points.emplace_back(needle.points[0] + Eigen::Vector3d(1e-10, 0, 0));
  needle.triangles.push_back({0, 8, 1});
  CHECK(finds(check_mesh(needle), Severity::note, "triangles that use a vertex twice 0 -> 1"));

  MeshData twice = box_surface(1);
  append(twice, box_surface(1), 0);
  CHECK(finds(check_mesh(twice), Severity::note, "triangles that repeat another 0 -> 12"));

  CHECK(check_mesh(surface).welded_components == 1);
  CHECK_FALSE(finds(check_mesh(surface), Severity::note, "welding"));
}

// Would catch what was there before taken for an effect of welding, and fewer repeated triangles
// than before counted below zero.
TEST_CASE("check: welding is not charged with what was there before", "[unit]") {
  MeshData flat = box_surface(1);
  append(flat, {{{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}, {}, {{0, 0, 1}, {0, 0, 1}, {0, 0, 2}}}, 1);
  const MeshReport report = check_mesh(flat);
  CHECK(report.duplicate_points == 1);
  CHECK(report.components == 2);
  CHECK(report.welded_components == 2);
  CHECK(finds(report, Severity::note,
              "welding the repeated points would change nothing but their number"));

  MeshData needles = box_surface(1);
  needles.points.emplace_back(needles.points[0]);
  needles.triangles.insert(needles.triangles.end(), {{0, 8, 1}, {0, 8, 1}, {3, 3, 4}});
  CHECK(finds(check_mesh(needles), Severity::note,
              "triangles that use a vertex twice 1 -> 3, triangles that repeat another 1 -> 0"));
}

TEST_CASE("check: the report says what was looked at and what was not", "[unit]") {
  const MeshReport good = check_mesh(box_surface(2));
  CHECK(good.checked.size() == 4);
  CHECK(good.not_checked.size() == 2);
  MeshData broken = box_surface(2);
  broken.triangles[3][2] = 99;
  CHECK(check_mesh(broken).checked.empty());
  CHECK(check_mesh(broken).not_checked ==
        std::vector<std::string>{"anything that needs sound ids and coordinates"});
}

TEST_CASE("check: surfaces are closed, wound and turned, or not", "[unit]") {
  const MeshData surface = box_surface(3);
  const MeshReport good = check_mesh(surface);
  CHECK(good.tets == 0);
  CHECK(good.vertices == 56);
  CHECK(good.edges == 162);
  CHECK(good.boundary_triangles == 108);
  CHECK(good.euler == 2);
  CHECK(good.closed);
  CHECK(good.shells == 1);
  CHECK_FALSE(good.inside_out);
  CHECK(good.volume == Approx(27.0 / (64 * 64 * 64)));
  CHECK_FALSE(good.has_errors());

  MeshData turned = surface;
  for (Triangle& triangle : turned.triangles) {
    std::swap(triangle[0], triangle[1]);
  }
  CHECK(check_mesh(turned).inside_out);
  CHECK(check_mesh(turned).volume == Approx(good.volume));

  MeshData open = surface;
  open.triangles.pop_back();
  CHECK(check_mesh(open).open_edges == 3);
  CHECK(check_mesh(open).shells == 0);
  CHECK_FALSE(check_mesh(open).closed);

  MeshData badly_wound = surface;
  std::swap(badly_wound.triangles[5][0], badly_wound.triangles[5][1]);
  CHECK(check_mesh(badly_wound).badly_wound_edges == 3);
  CHECK_FALSE(check_mesh(badly_wound).inside_out);

  MeshData repeated = surface;
  repeated.triangles.push_back(surface.triangles[4]);
  CHECK(check_mesh(repeated).duplicate_triangles == 1);
  CHECK(check_mesh(repeated).overshared_edges == 3);

  MeshData flat = surface;
  flat.triangles.push_back({0, 0, 1});
  CHECK(check_mesh(flat).flat_triangles == 1);
}

TEST_CASE("check: broken content is reported, not thrown", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  MeshData mesh = box_mesh(1);
  mesh.tets[3][2] = 99;
  CHECK(finds(check_mesh(mesh), Severity::error, "points that do not exist: 1 (3)"));

  mesh = box_mesh(1);
  mesh.points[4].y() = nan;
  CHECK(finds(check_mesh(mesh), Severity::error, "points that are not finite: 1 (4)"));

  mesh = box_mesh(1);
  mesh.points[4].y() = std::numeric_limits<double>::max();
  CHECK(check_mesh(mesh).vertices == 8);

  mesh.points.assign(8, Eigen::Vector3d::Zero());
  CHECK(check_mesh(mesh).duplicate_points == 7);
  CHECK(check_mesh(mesh).flat == 6);

  CHECK(finds(check_mesh({}), Severity::error, "neither tets nor triangles"));
  CHECK(finds(check_mesh({{{0, 0, 0}}, {}, {}}), Severity::error, "neither tets nor triangles"));
}

}  // namespace pbdsurg
