// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/live_surface.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/views/live_boundary.h"

#include "tests/support/catch.h"
#include "tests/support/random_edits.h"
#include "tests/support/random_growth.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

using Triangles = std::vector<std::pair<Index, Triangle>>;  // after the tetrahedra they bound

// What the slots hold, checked on the way: origins name the triangles, empty slots have no area.
Triangles shown_by(const LiveSurface& surface, const Solver& solver) {
  Triangles shown;
  bool consistent = true;
  for (Index slot = 0; slot < surface.slot_count(); ++slot) {
    const Triangle& triangle = surface.triangles()[slot];
    const TetFace& origin = surface.origins()[slot];
    if (origin.tet == kInvalidIndex) {
      consistent &= triangle == LiveSurface::kEmptyTriangle;
      continue;
    }
    const Tet& tet = solver.tissue().tets()[origin.tet];
    for (int i = 0; i < 3; ++i) {
      consistent &= triangle[i] == tet[kTetTriangles[origin.face][i]];
    }
    shown.emplace_back(origin.tet, triangle);
  }
  REQUIRE(consistent);
  REQUIRE(static_cast<Index>(shown.size()) == surface.triangle_count());
  std::sort(shown.begin(), shown.end());
  return shown;
}

// Against a surface found afresh.
void check_surface(const LiveSurface& surface, const Solver& solver, Index body) {
  Triangles expected;
  const Body& own = solver.tissue().body(body);
  std::vector<bool> bared(static_cast<std::size_t>(own.vertex_count), false);
  for (const BoundaryTriangle& triangle : find_live_boundary(solver.tissue(), body)) {
    expected.emplace_back(triangle.tet, triangle.vertices);
    for (const Index v : triangle.vertices) {
      bared[v - own.first_vertex] = true;
    }
  }
  std::sort(expected.begin(), expected.end());
  REQUIRE(shown_by(surface, solver) == expected);
  Index wrong = 0;
  for (Index v = 0; v < own.vertex_count; ++v) {
    wrong += surface.is_on_surface(own.first_vertex + v) != bared[v];
  }
  REQUIRE(wrong == 0);
}

bool are_same(const LiveSurface& a, const LiveSurface& b) {
  const auto is_same_origin = [](const TetFace& x, const TetFace& y) {
    return x.tet == y.tet && x.face == y.face;
  };
  return std::equal(a.triangles().begin(), a.triangles().end(), b.triangles().begin(),
                    b.triangles().end()) &&
         std::equal(a.origins().begin(), a.origins().end(), b.origins().begin(), b.origins().end(),
                    is_same_origin);
}

// A renderer's index buffer, which sees nothing but ranges.
struct Mirror {
  std::uint64_t version = 0;
  std::vector<Triangle> triangles{};
  std::vector<SlotRange> ranges{};

  Index update(const LiveSurface& surface) {
    surface.collect_changes(version, ranges);
    version = surface.version();
    triangles.resize(static_cast<std::size_t>(surface.slot_count()));
    Index copied = 0;
    Index end = -LiveSurface::kJoinedGap;
    bool apart = true;
    for (const SlotRange& range : ranges) {
      apart &= range.first >= end + LiveSurface::kJoinedGap;
      end = range.end;
      std::copy(surface.triangles().begin() + range.first, surface.triangles().begin() + range.end,
                triangles.begin() + range.first);
      copied += range.end - range.first;
    }
    REQUIRE(apart);
    REQUIRE(std::equal(triangles.begin(), triangles.end(), surface.triangles().begin(),
                       surface.triangles().end()));
    return copied;
  }
};

}  // namespace

// Would catch a face that stays with a tetrahedron that is gone, one that is not bared, a slot used
// twice, an undo that leaves anything behind, and a reader that is not told of a change.
TEST_CASE("live surface: it equals one found afresh after any edits and undos", "[property]") {
  constexpr std::uint64_t kSequences = 100;  // of each scene
  for (const testing::SampleScene& sample : testing::make_sample_scenes()) {
    INFO(sample.name);
    for (std::uint64_t sequence = 0; sequence < kSequences; ++sequence) {
      Solver solver(sample.scene, {.executor = executor::serial()});
      std::vector<LiveSurface> surfaces;
      for (Index b = 0; b < static_cast<Index>(solver.tissue().bodies().size()); ++b) {
        surfaces.emplace_back(solver.tissue(), b);
      }
      std::vector<Mirror> eager(surfaces.size()), lazy(surfaces.size());
      const Index most = sequence % 2 == 0 ? 8 : 80;
      for (std::uint64_t i = 0; i < 8; ++i) {
        const TopologyEdit edit =
            testing::random_removal(sample.scene, solver, most, 100 * sequence + i);
        const std::vector<LiveSurface> before = surfaces;
        solver.tissue().apply(edit);
        const bool undone = random_bits(sequence, i) % 3 == 0;
        for (std::size_t b = 0; b < surfaces.size(); ++b) {
          check_surface(surfaces[b], solver, static_cast<Index>(b));
          eager[b].update(surfaces[b]);
        }
        if (undone) {
          const std::vector<LiveSurface> after = surfaces;
          solver.tissue().undo();
          for (std::size_t b = 0; b < surfaces.size(); ++b) {
            REQUIRE(are_same(surfaces[b], before[b]));
            eager[b].update(surfaces[b]);
          }
          solver.tissue().apply(edit);
          for (std::size_t b = 0; b < surfaces.size(); ++b) {
            REQUIRE(are_same(surfaces[b], after[b]));
          }
        }
        for (std::size_t b = 0; b < surfaces.size() && i % 3 == 2; ++b) {
          lazy[b].update(surfaces[b]);
        }
      }
    }
  }
}

// Would catch faces of parted tissue that stay joined, partners that do not find each other where
// tissue is split, and whatever of this an undo leaves behind.
TEST_CASE("live surface: it follows tissue that parts and splits", "[property]") {
  const TetMesh mesh = testing::make_box({3, 3, 3}, testing::kEditEdge, 0.1);
  for (std::uint64_t sequence = 0; sequence < 60; ++sequence) {
    testing::EditedBody body(mesh, std::vector<bool>(mesh.positions().size(), false));
    Tissue tissue(body.make_scene());
    LiveSurface surface(tissue, 0);
    for (std::uint64_t i = 0; i < 5; ++i) {
      const TopologyEdit edit = body.random_edit(100 * sequence + i);
      body.apply(edit);
      const LiveSurface before = surface;
      tissue.apply(edit);
      check_surface(surface, body.make_solver(), 0);
      const LiveSurface after = surface;
      tissue.undo();
      REQUIRE(are_same(surface, before));
      tissue.apply(edit);
      REQUIRE(are_same(surface, after));
    }
  }
}

// Would catch an edit that rebuilds, or buffers that grow with time: as many slots change as
// triangles come and go, and slots are used again.
TEST_CASE("live surface: an edit changes the slots of its faces alone", "[property]") {
  Scene scene;
  scene.add_body("block", testing::make_box({12, 12, 12}, 4e-3));
  Solver solver(scene, {.executor = executor::serial()});
  LiveSurface surface(solver.tissue(), 0);
  Index most_triangles = surface.triangle_count();
  std::vector<SlotRange> ranges;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const TopologyEdit edit = testing::random_removal(scene, solver, 30, i);
    const std::uint64_t version = surface.version();
    const Index slots = surface.slot_count();
    solver.tissue().apply(edit);
    CHECK(surface.version() - version <= 4 * edit.remove_tets.size());
    most_triangles = std::max(most_triangles, surface.triangle_count());
    surface.collect_changes(version, ranges);
    Index uploaded = 0;
    for (const SlotRange& range : ranges) {
      uploaded += range.end - range.first;
    }
    CHECK(uploaded <= 4 * LiveSurface::kJoinedGap * static_cast<Index>(edit.remove_tets.size()));
    CHECK(surface.slot_count() <= std::max(slots, most_triangles));
  }
}

TEST_CASE("live surface: a reader that was away for long gets all slots", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({8, 8, 8}, 4e-3));
  Solver solver(scene, {.executor = executor::serial()});
  LiveSurface surface(solver.tissue(), 0);
  Mirror mirror;
  mirror.update(surface);
  const Index tet_count = static_cast<Index>(scene.tets().size());
  for (Index t = 0; t < tet_count; ++t) {
    solver.tissue().apply({.remove_tets = {t}});
  }
  CHECK(mirror.update(surface) == surface.slot_count());
  CHECK(surface.triangle_count() == 0);
  CHECK(mirror.update(surface) == 0);
  for (const Triangle& triangle : mirror.triangles) {
    CHECK(triangle == LiveSurface::kEmptyTriangle);
  }
}

// Would catch a surface that silently shows what is not there, or misses what went before it came.
TEST_CASE("live surface: it may come at any time, and a copy of it stays as it was", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3));
  Solver solver(scene);
  CHECK_THROWS_AS(LiveSurface(solver.tissue(), 1), InvalidArgument);
  solver.tissue().apply({.remove_tets = {3}});
  const LiveSurface surface(solver.tissue(), 0);
  check_surface(surface, solver, 0);
  const LiveSurface copy = surface;
  solver.tissue().apply({.remove_tets = {4}});
  check_surface(surface, solver, 0);
  CHECK(!are_same(copy, surface));
  solver.tissue().undo();
  CHECK(are_same(copy, surface));
}

}  // namespace pbdsurg
