// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/live_pieces.h"

#include <algorithm>
#include <map>
#include <set>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"
#include "tests/support/random_edits.h"
#include "tests/support/random_growth.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// Pieces as lists, found afresh.
struct Reference {
  std::vector<std::vector<Index>> pieces{};  // tetrahedra, ascending

  explicit Reference(const Solver& solver) {
    std::vector<Index> all(solver.tissue().tets().size());
    for (std::size_t t = 0; t < all.size(); ++t) {
      all[t] = static_cast<Index>(t);
    }
    pieces = parts_of(solver, all, {});
  }

  // Those among some tetrahedra, in the order of their smallest vertices.
  static std::vector<std::vector<Index>> parts_of(const Solver& solver,
                                                  const std::vector<Index>& tets,
                                                  const std::set<Index>& without) {
    std::vector<Index> ids;
    std::vector<Tet> live;
    for (const Index t : tets) {
      if (solver.tissue().is_tet_alive(t) && without.count(t) == 0) {
        ids.push_back(t);
        live.push_back(solver.tissue().tets()[t]);
      }
    }
    const Components components = find_components(solver.vertex_count(), live);
    std::vector<std::vector<Index>> parts(static_cast<std::size_t>(components.count));
    for (std::size_t i = 0; i < ids.size(); ++i) {
      parts[components.of_vertex[live[i][0]]].push_back(ids[i]);
    }
    return parts;
  }

  // What an edit frees; `pieces` keep the largest parts.
  std::vector<std::vector<Index>> take_apart(const Solver& solver, const std::set<Index>& without) {
    std::vector<std::vector<Index>> freed;
    for (std::vector<Index>& piece : pieces) {
      std::vector<std::vector<Index>> parts = parts_of(solver, piece, without);
      const auto largest = std::min_element(parts.begin(), parts.end(), [](auto& a, auto& b) {
        return a.size() != b.size() ? a.size() > b.size() : a < b;
      });
      piece = largest == parts.end() ? std::vector<Index>{} : *largest;
      for (auto part = parts.begin(); part != parts.end(); ++part) {
        if (part != largest) {
          freed.push_back(*part);
        }
      }
    }
    std::sort(freed.begin(), freed.end());
    return freed;
  }

  void follow(const Solver& solver) {
    for (std::vector<Index>& part : take_apart(solver, {})) {
      pieces.push_back(std::move(part));
    }
  }
};

void check_pieces(const LivePieces& pieces, const Reference& reference, const Scene& scene) {
  REQUIRE(pieces.count() == static_cast<Index>(reference.pieces.size()));
  std::vector<Index> piece_of(scene.tets().size(), kInvalidIndex);
  for (Index i = 0; i < pieces.count(); ++i) {
    const std::vector<Index>& expected = reference.pieces[i];
    REQUIRE(pieces.tets(i) == expected);
    REQUIRE(pieces.tet_count(i) == static_cast<Index>(expected.size()));
    bool anchored = false;
    for (const Index t : expected) {
      piece_of[t] = i;
      for (const Index v : scene.tets()[t]) {
        anchored |= scene.is_fixed(v);
      }
    }
    REQUIRE(pieces.is_anchored(i) == anchored);
    if (!expected.empty()) {
      const Body& body = scene.body(pieces.body(i));
      REQUIRE(expected.front() >= body.first_tet);
      REQUIRE(expected.back() < body.first_tet + body.tet_count);
    }
  }
  Index wrong = 0;
  for (std::size_t t = 0; t < piece_of.size(); ++t) {
    wrong += pieces.piece_of(static_cast<Index>(t)) != piece_of[t];
  }
  REQUIRE(wrong == 0);
}

bool are_same(const LivePieces& a, const LivePieces& b) {
  bool same = a.count() == b.count();
  for (Index i = 0; same && i < a.count(); ++i) {
    same = a.tet_count(i) == b.tet_count(i) && a.is_anchored(i) == b.is_anchored(i) &&
           a.tets(i) == b.tets(i);
    for (const Index t : a.tets(i)) {
      same &= a.piece_of(t) == b.piece_of(t);
    }
  }
  return same;
}

}  // namespace

// Would catch a part that is not noticed, two that are taken for one, the wrong one keeping the id,
// counts that do not follow, and an undo that leaves anything behind.
TEST_CASE("live pieces: they equal those found afresh after any edits and undos", "[property]") {
  constexpr std::uint64_t kSequences = 120;  // of each scene
  Index freed = 0, emptied = 0;
  for (const testing::SampleScene& sample : testing::make_sample_scenes()) {
    INFO(sample.name);
    for (std::uint64_t sequence = 0; sequence < kSequences; ++sequence) {
      Solver solver(sample.scene, {.executor = executor::serial()});
      LivePieces pieces(solver.tissue());
      Reference reference(solver);
      check_pieces(pieces, reference, sample.scene);
      const Index most = sequence % 2 == 0 ? 40 : 150;
      for (std::uint64_t i = 0; i < 12; ++i) {
        const TopologyEdit edit =
            testing::random_removal(sample.scene, solver, most, 100 * sequence + i);
        const LivePieces before = pieces;
        solver.tissue().apply(edit);
        const Index first_freed = static_cast<Index>(reference.pieces.size());
        reference.follow(solver);
        check_pieces(pieces, reference, sample.scene);
        REQUIRE(pieces.first_freed() == first_freed);
        freed += pieces.count() - first_freed;
        if (random_bits(sequence, i) % 3 == 0) {
          solver.tissue().undo();
          REQUIRE(are_same(pieces, before));
          solver.tissue().apply(edit);
          check_pieces(pieces, reference, sample.scene);
        }
      }
      for (const std::vector<Index>& piece : reference.pieces) {
        emptied += piece.empty();
      }
    }
  }
  CHECK(freed > 300);
  CHECK(emptied > 300);
}

// Would catch new vertices and tetrahedra that searches do not reach, and tissue that hangs
// together through where it has moved away from.
TEST_CASE("live pieces: they follow tissue that parts and splits", "[property]") {
  const TetMesh mesh = testing::make_box({3, 3, 2}, testing::kEditEdge, 0.1);
  std::vector<bool> fixed(mesh.positions().size(), false);
  std::fill_n(fixed.begin(), 16, true);  // one side
  Index freed = 0;
  for (std::uint64_t sequence = 0; sequence < 60; ++sequence) {
    testing::EditedBody body(mesh, fixed);
    Tissue tissue(body.make_scene());
    LivePieces pieces(tissue);
    Reference reference(body.make_solver());
    for (std::uint64_t i = 0; i < 8; ++i) {
      const TopologyEdit edit = body.random_edit(100 * sequence + i);
      body.apply(edit);
      for (std::size_t t = 0; t < edit.new_tets.size(); ++t) {
        const Index piece = pieces.piece_of(edit.new_tets[t].parent);
        reference.pieces[piece].push_back(static_cast<Index>(tissue.tets().size() + t));
      }
      const LivePieces before = pieces;
      tissue.apply(edit);
      reference.follow(body.make_solver());
      check_pieces(pieces, reference, body.make_scene());
      freed += pieces.count() - pieces.first_freed();
      const LivePieces after = pieces;
      tissue.undo();
      REQUIRE(are_same(pieces, before));
      tissue.apply(edit);
      REQUIRE(are_same(pieces, after));
    }
  }
  CHECK(freed > 100);
}

// Would catch crumbs left behind, larger parts taken along, and a search that changes the pieces.
TEST_CASE("live pieces: crumbs go with the edit that frees them", "[property]") {
  Index dropped = 0;
  for (const testing::SampleScene& sample : testing::make_sample_scenes()) {
    INFO(sample.name);
    for (std::uint64_t sequence = 0; sequence < 200; ++sequence) {
      Solver solver(sample.scene, {.executor = executor::serial()});
      LivePieces pieces(solver.tissue());
      Reference reference(solver);
      for (std::uint64_t i = 0; i < 10; ++i) {
        const Index smallest = static_cast<Index>(random_bits(sequence, i) % 12);
        TopologyEdit edit = testing::random_removal(sample.scene, solver, 100, 100 * sequence + i);
        const std::set<Index> asked(edit.remove_tets.begin(), edit.remove_tets.end());
        std::set<Index> expected = asked;
        Crumbs expected_crumbs;
        Reference apart = reference;
        for (const std::vector<Index>& part : apart.take_apart(solver, asked)) {
          if (static_cast<Index>(part.size()) < smallest) {
            expected.insert(part.begin(), part.end());
            ++expected_crumbs.parts;
            expected_crumbs.tets += static_cast<Index>(part.size());
          }
        }
        const Crumbs crumbs = pieces.add_crumbs(solver.tissue(), edit, smallest);
        check_pieces(pieces, reference, sample.scene);
        CHECK(crumbs.parts == expected_crumbs.parts);
        CHECK(crumbs.tets == expected_crumbs.tets);
        CHECK(std::set<Index>(edit.remove_tets.begin(), edit.remove_tets.end()) == expected);
        CHECK(edit.remove_tets.size() == expected.size());
        solver.tissue().apply(edit);
        reference.follow(solver);
        check_pieces(pieces, reference, sample.scene);
        for (Index piece = pieces.first_freed(); piece < pieces.count(); ++piece) {
          CHECK(pieces.tet_count(piece) >= smallest);
        }
        dropped += crumbs.parts;
      }
    }
  }
  CHECK(dropped > 300);
}

// Would catch a search through the mesh for an edit in the middle of it, and one through the larger
// part for a corner that is cut off.
TEST_CASE("live pieces: searches stay where the edit is", "[property]") {
  constexpr Index kCells = 16;
  Scene scene;
  scene.add_body("block", testing::make_box({kCells, kCells, kCells}, 4e-3));
  Solver solver(scene, {.executor = executor::serial()});
  LivePieces pieces(solver.tissue());
  const auto in_box = [&](auto&& contains) {
    TopologyEdit edit;
    for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
      if (const auto cell = t / 6;
          contains(cell % kCells, cell / kCells % kCells, cell / kCells / kCells)) {
        edit.remove_tets.push_back(t);
      }
    }
    return edit;
  };
  solver.tissue().apply(
      in_box([](Index x, Index y, Index z) { return x == 8 && y == 8 && z == 8; }));
  CHECK(pieces.count() == 1);
  CHECK(pieces.visited() <= 5 * 5 * 5);

  // scattered changes do not look for each other
  solver.tissue().apply(in_box([](Index x, Index y, Index z) {
    return (x == 3 || x == 9) && (y == 3 || y == 9) && (z == 3 || z == 9);
  }));
  CHECK(pieces.count() == 1);
  CHECK(pieces.visited() <= 8 * 5 * 5 * 5);

  // all around a cell at a corner
  solver.tissue().apply(in_box([](Index x, Index y, Index z) { return std::max({x, y, z}) == 1; }));
  CHECK(pieces.count() == 2);
  CHECK(pieces.tet_count(1) == 6);
  CHECK(pieces.visited() <= 200);

  // a slice: the smaller side is searched through, and as much of the larger one
  solver.tissue().apply(in_box([](Index x, Index, Index) { return x == 12; }));
  CHECK(pieces.count() == 3);
  CHECK(pieces.tet_count(2) == 6 * 3 * kCells * kCells);
  CHECK(pieces.visited() <= 3 * 4 * (kCells + 1) * (kCells + 1));
}

TEST_CASE("live pieces: links and particles are no tissue", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({1, 1, 1}, 4e-3);
  scene.add_body("first", block);
  scene.add_particles("thread", std::vector<Eigen::Vector3d>{{0, 0, 0}, {1, 0, 0}}, 1e-6);
  scene.add_body("second", block);
  scene.fix_vertices(1, std::vector<Index>{0});
  scene.fix_vertices(2, std::vector<Index>{7});
  scene.add_link({0, 8, 1e-3F, {}});
  scene.add_link({8, 10, 1e-3F, {}});
  const Solver solver(scene);
  const LivePieces pieces(solver.tissue());
  REQUIRE(pieces.count() == 2);
  CHECK(pieces.body(0) == 0);
  CHECK(pieces.body(1) == 2);
  CHECK_FALSE(pieces.is_anchored(0));
  CHECK(pieces.is_anchored(1));
}

TEST_CASE("live pieces: a copy finds no crumbs, nor is what would be refused searched", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3));
  Solver solver(scene), other(scene);
  LivePieces pieces(solver.tissue());
  LivePieces copy = pieces;
  solver.tissue().apply({.remove_tets = {4}});
  CHECK(pieces.piece_of(4) == kInvalidIndex);
  CHECK(copy.piece_of(4) == 0);
  TopologyEdit edit{.remove_tets = {5}};
  CHECK_THROWS_WITH(copy.add_crumbs(solver.tissue(), edit, 3),
                    ContainsSubstring("does not follow this tissue"));
  CHECK_THROWS_WITH(pieces.add_crumbs(other.tissue(), edit, 3),
                    ContainsSubstring("does not follow this tissue"));
  CHECK(edit.remove_tets.size() == 1);

  // ids that the edit will be refused for are passed over, by pieces that come late, too
  LivePieces late(solver.tissue());
  for (LivePieces* const each : {&pieces, &late}) {
    TopologyEdit bad{.remove_tets = {4, 5, 5, -1, 1000}};
    each->add_crumbs(solver.tissue(), bad, 3);
    CHECK(bad.remove_tets.size() == 5);
  }
}

}  // namespace pbdsurg
