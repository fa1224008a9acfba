// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/fewer_colors.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

// Vertices of what joins them, as a solver of vertex blocks colours them.
struct Blocks {
  IndexLists lists;
  Index element_count;

  template <std::size_t kArity>
  Blocks(const std::vector<std::array<Index, kArity>>& elements, Index vertex_count)
      : lists(find_vertex_constraints({std::span(elements), vertex_count})),
        element_count(static_cast<Index>(elements.size())) {}
  explicit Blocks(const TetMesh& mesh)
      : Blocks(std::vector<Tet>(mesh.tets().begin(), mesh.tets().end()), mesh.vertex_count()) {}

  [[nodiscard]] ConstraintVertices view() const { return {lists, element_count}; }
  [[nodiscard]] Coloring repaired() const {
    return color_constraints(view(), {.order = GreedyOrder::saturation, .repair = true});
  }
  [[nodiscard]] bool has_ring() const { return has_odd_ring(find_conflicts(view())); }
};

Coloring searched(const Blocks& blocks, Coloring coloring, std::uint64_t seed = 0) {
  const Coloring before = coloring;
  find_fewer_colors(coloring, blocks.view(), seed);
  CHECK_FALSE(find_conflict(coloring, blocks.view()));
  CHECK(testing::has_no_gap(coloring));
  CHECK(coloring.color_count <= before.color_count);
  if (coloring.color_count == before.color_count) {
    CHECK(coloring == before);
  }
  return coloring;
}

TetMesh small_liver() {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = 1150;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

// Tetrahedra around the edge of vertices 0 and 1.
std::vector<Tet> ring_of(Index count) {
  std::vector<Tet> tets;
  for (Index i = 0; i < count; ++i) {
    tets.push_back({0, 1, 2 + i, 2 + (i + 1) % count});
  }
  return tets;
}

// Mycielski's graph of a ring of five: no triangle, and yet no three colours.
std::vector<Edge> groetzsch_graph() {
  std::vector<Edge> edges;
  for (Index i = 0; i < 5; ++i) {
    const Index next = (i + 1) % 5;
    edges.push_back({i, next});
    edges.push_back({i, 5 + next});
    edges.push_back({next, 5 + i});
    edges.push_back({5 + i, 10});
  }
  return edges;
}

}  // namespace

TEST_CASE("fewer colours: valid, without gaps, never more, and the same again", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Coloring before = color_constraints(constraints);
    Coloring coloring = before;
    find_fewer_colors(coloring, constraints, 5);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(testing::has_no_gap(coloring));
    CHECK(coloring.color_count <= before.color_count);
    Coloring again = before;
    find_fewer_colors(again, constraints, 5);
    CHECK(again == coloring);
  }
}

// Would catch a walk that gets stuck, or one that spreads: repair leaves six colours in all of
// them, and an edge with an odd number of tetrahedra around it proves that four do not do.
TEST_CASE("fewer colours: five for the vertices of organs, whatever the seed", "[property]") {
  for (const TetMesh& mesh : {table2_mesh(1), table2_mesh(2), small_liver()}) {
    const Blocks blocks(mesh);
    const Coloring repaired = blocks.repaired();
    CHECK(repaired.color_count == 6);
    CHECK(blocks.has_ring());
    for (const std::uint64_t seed : {0, 1, 2, 3}) {
      INFO("seed " << seed);
      CHECK(searched(blocks, repaired, seed).color_count == 5);
    }
  }
}

TEST_CASE("fewer colours: nothing is searched at the bound", "[unit]") {
  const Blocks lattice(testing::make_box({9, 8, 7}, 1e-3));
  CHECK(lattice.repaired().color_count == 4);
  CHECK(searched(lattice, lattice.repaired()).color_count == 4);
  CHECK_FALSE(lattice.has_ring());
}

TEST_CASE("fewer colours: an odd ring around an edge needs five", "[golden]") {
  for (const Index count : {3, 4, 5, 6, 7, 8}) {
    INFO(count << " tetrahedra around an edge");
    const Blocks blocks(ring_of(count), 2 + count);
    CHECK(blocks.has_ring() == (count % 2 == 1));
    Coloring coloring{{}, 2 + count};
    for (Index v = 0; v < coloring.color_count; ++v) {
      coloring.color_of.push_back(v);
    }
    CHECK(searched(blocks, coloring).color_count == 4 + count % 2);
  }
}

TEST_CASE("fewer colours: what cannot have fewer stays as it was", "[golden]") {
  const Blocks blocks(groetzsch_graph(), 11);
  const Coloring start = blocks.repaired();
  REQUIRE(start.color_count == 4);
  CHECK(searched(blocks, start) == start);
  CHECK_FALSE(blocks.has_ring());
}

// A graph whose vertices lie in three classes, and edges between these alone. First fit in order of
// their numbers takes more colours.
TEST_CASE("fewer colours: three where a graph was made of three classes", "[golden]") {
  constexpr Index kVertices = 300;
  std::vector<Edge> edges;
  for (Index v = 0; v < kVertices; ++v) {
    for (Index w = 0; w < v; ++w) {
      if (v % 3 != w % 3 && random_unit(8, v, w) < 0.08) {
        edges.push_back({w, v});
      }
    }
  }
  const Blocks blocks(edges, kVertices);
  const Coloring start = color_constraints(blocks.view());
  REQUIRE(start.color_count > 4);
  CHECK(searched(blocks, start).color_count == 3);
}

// Bodies that links join: more neighbours than a mesh has, and cliques beyond its tetrahedra.
TEST_CASE("fewer colours: links count as much as tetrahedra", "[property]") {
  const TetMesh liver = small_liver();
  const Index count = liver.vertex_count();
  IndexLists elements;
  const auto append = [&](const auto& vertices, Index shift) {
    for (const Index v : vertices) {
      elements.entries.push_back(v + shift);
    }
    elements.offsets.push_back(static_cast<Index>(elements.entries.size()));
  };
  for (const Tet& tet : liver.tets()) {
    append(tet, 0);
    append(tet, count);
  }
  for (Index v = 0; v < count; ++v) {
    for (const Index step : {0, 1, 7}) {
      append(Edge{v, count + (v + step) % count}, 0);
    }
  }
  const IndexLists lists = find_vertex_constraints(ConstraintVertices(elements, 2 * count));
  const ConstraintVertices vertices(lists, elements.list_count());
  Coloring coloring =
      color_constraints(vertices, {.order = GreedyOrder::saturation, .repair = true});
  const Index before = coloring.color_count;
  find_fewer_colors(coloring, vertices, 0);
  CHECK_FALSE(find_conflict(coloring, vertices));
  CHECK(coloring.color_count < before);
}

}  // namespace pbdsurg
