// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/table2_family.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/skip.h"

namespace pbdsurg {
namespace {

double error(double is, double wanted) {
  return std::abs(is / wanted - 1);
}

void check_counts(const TetMesh& mesh, const Table2Row& row) {
  CHECK(error(mesh.vertex_count(), row.vertices) <= 0.005);
  CHECK(error(static_cast<double>(find_edges(mesh.tets()).size()), row.links) <= 0.05);
  CHECK(error(mesh.tet_count(), row.tets) <= 0.05);
}

// Sets PATH for one test.
class PathGuard {
 public:
  explicit PathGuard(const char* path) {
    if (const char* old = std::getenv("PATH")) {
      old_ = old;
    }
    setenv("PATH", path, 1);
  }
  ~PathGuard() { setenv("PATH", old_.c_str(), 1); }
  PathGuard(const PathGuard&) = delete;
  PathGuard& operator=(const PathGuard&) = delete;

 private:
  std::string old_;
};

std::optional<TetMesh> surface_filled(int row) {
  try {
    return table2_mesh(row, Table2Kind::surface_filled);
  } catch (const BackendUnavailable& unavailable) {
    testing::skip(unavailable.what());
    return std::nullopt;
  }
}

}  // namespace

TEST_CASE("table 2 family: the rows obey Euler's bound nearly", "[unit]") {
  for (const Table2Row& row : kTable2) {
    CHECK(error(row.links, 2.0 * row.vertices + row.tets - 3) < 0.007);
  }
}

TEST_CASE("table 2 family: hollow meshes have the paper's sizes", "[property][long]") {
  const int row = GENERATE(1, 2, 3, 4, 5);
  CAPTURE(row);
  const TetMesh mesh = table2_mesh(row);
  check_counts(mesh, kTable2[row - 1]);
  CHECK(find_components(mesh.vertex_count(), mesh.tets()).count == 1);
  std::vector<Triangle> boundary;
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
    boundary.push_back(triangle.vertices);
  }
  CHECK(find_components(mesh.vertex_count(), boundary).count == 2);
}

TEST_CASE("table 2 family: a row is the same in every run", "[property]") {
  const TetMesh first = table2_mesh(1), second = table2_mesh(1);
  REQUIRE(first.positions().size_bytes() == second.positions().size_bytes());
  CHECK(std::memcmp(first.positions().data(), second.positions().data(),
                    first.positions().size_bytes()) == 0);
}

TEST_CASE("table 2 family: surface-filled meshes have the paper's sizes and slivers",
          "[property][tetgen]") {
  if (const std::optional<TetMesh> mesh = surface_filled(1)) {
    check_counts(*mesh, kTable2[0]);
    // no vertex is inside: the boundary has 2 V - 4 triangles
    CHECK(error(static_cast<double>(find_boundary(mesh->tets()).size()),
                2.0 * mesh->vertex_count() - 4) < 0.001);
    const IndexLists stars = find_vertex_tets(mesh->vertex_count(), mesh->tets());
    std::size_t largest = 0;
    for (Index v = 0; v < mesh->vertex_count(); ++v) {
      largest = std::max(largest, stars[v].size());
    }
    CHECK(largest > 50);
  }
}

TEST_CASE("table 2 family: without tetgen the message says what is missing", "[unit]") {
  const PathGuard guard("/nonexistent");
  CHECK_THROWS_WITH(table2_mesh(1, Table2Kind::surface_filled),
                    testing::ContainsSubstring("tetgen"));
  CHECK_THROWS_AS(table2_mesh(1, Table2Kind::surface_filled), BackendUnavailable);
}

TEST_CASE("table 2 family: there are five rows", "[unit]") {
  CHECK_THROWS_AS(table2_mesh(0), InvalidArgument);
  CHECK_THROWS_AS(table2_mesh(6), InvalidArgument);
}

}  // namespace pbdsurg
