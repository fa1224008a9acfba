// SPDX-License-Identifier: Apache-2.0
// Heat fields whose tissue is edited.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"

#include "tests/support/catch.h"
#include "tests/support/heat_blocks.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/heat_tissues.h"
#include "tests/support/scenes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Blocks;
using testing::ContainsSubstring;
using testing::kLiver;
using testing::ledger_error;
using testing::make_box;
using testing::make_jittered_box;
using testing::same_state;
using testing::sensible_heat;

// What edits make of a block, in the numbering of a scene in which the block is not first and
// others get new vertices and tetrahedra, too.
class EditedBlock {
 public:
  EditedBlock(const Tissue& tissue, Index body) : tissue_(tissue) {
    const Body& where = tissue.body(body);
    for (Index v = where.first_vertex; v < where.first_vertex + where.vertex_count; ++v) {
      points_[v] = tissue.rest_positions()[v];
    }
    for (Index t = where.first_tet; t < where.first_tet + where.tet_count; ++t) {
      tets_[t] = tissue.tets()[t];
    }
  }

  // Removes tetrahedra, splits an edge and parts some tetrahedra from a vertex, at random.
  TopologyEdit change(std::uint64_t seed, bool grows) {
    std::uint64_t round = 0;
    const auto random = [&] { return random_unit(seed, ++round); };
    TopologyEdit edit;
    const Index next_vertex = tissue_.vertex_count();
    const auto next_tet = static_cast<Index>(tissue_.tets().size());
    change_other(edit);
    std::map<Index, Tet> free = tets_;  // neither removed nor divided yet
    const auto any = [&] {
      return *std::next(free.begin(),
                        static_cast<Index>(random() * static_cast<double>(free.size())));
    };
    for (int i = 0; i < 4 && !free.empty(); ++i) {
      const Index t = any().first;
      edit.remove_tets.push_back(t);
      free.erase(t);
    }
    std::map<Index, Tet> children;
    if (grows && !free.empty()) {
      const Tet tet = any().second;
      const Index a = tet[0], b = tet[2];
      const auto share = static_cast<float>(0.3 + 0.4 * random());
      const Index middle = next_vertex + static_cast<Index>(edit.new_vertices.size());
      edit.new_vertices.push_back({a, b, share});
      points_[middle] = (1 - static_cast<double>(share)) * points_[a] + share * points_[b];
      for (auto entry = free.begin(); entry != free.end();) {
        const auto [id, parent] = *entry;
        if (std::count(parent.begin(), parent.end(), a) +
                std::count(parent.begin(), parent.end(), b) <
            2) {
          ++entry;
          continue;
        }
        for (const Index gone : {a, b}) {
          Tet child = parent;
          std::replace(child.begin(), child.end(), gone, middle);
          children[next_tet + static_cast<Index>(edit.new_tets.size())] = child;
          edit.new_tets.push_back({id, child});
        }
        entry = free.erase(entry);
      }
    }
    if (grows && !free.empty()) {
      const Index from = any().second[1];
      const Index to = next_vertex + static_cast<Index>(edit.new_vertices.size());
      std::vector<CornerMove> moves;
      for (auto& [id, tet] : free) {
        if (std::count(tet.begin(), tet.end(), from) > 0 && random() < 0.5) {
          moves.push_back({id, from, to});
          std::replace(tet.begin(), tet.end(), from, to);
        }
      }
      if (!moves.empty()) {  // a new vertex must have tissue
        edit.new_vertices.push_back({from, from, 0});
        points_[to] = points_[from];
        edit.corner_moves.insert(edit.corner_moves.end(), moves.begin(), moves.end());
      }
    }
    free.insert(children.begin(), children.end());
    tets_ = free;
    return edit;
  }

  [[nodiscard]] bool is_empty() const { return tets_.empty(); }

  // Compares a mesh with one of what lives: the same bits, however it came to be.
  void check(const ThermalMesh& mesh) const {
    std::vector<Eigen::Vector3d> points(mesh.rest_positions().begin(), mesh.rest_positions().end());
    for (const auto& [vertex, point] : points_) {
      REQUIRE(points[vertex] == point);
    }
    std::vector<Tet> live;
    for (const auto& [id, tet] : tets_) {
      live.push_back(tet);
    }
    const ThermalMesh expected(TetMesh(points, live), mesh.tissues()[0]);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      REQUIRE(mesh.mass(v) == expected.mass(v));
      REQUIRE(mesh.surface_share(v) == expected.surface_share(v));
      REQUIRE(coefficients_at(mesh, v) == coefficients_at(expected, v));
    }
  }

 private:
  // A new vertex and a removal, of the body that is not looked at.
  void change_other(TopologyEdit& edit) {
    const Index tet = removed_of_other_++, parted = tet + 1;
    const Index from = tissue_.tets()[parted][0];
    edit.new_vertices.push_back({from, from, 0});
    edit.corner_moves.push_back({parted, from, tissue_.vertex_count()});
    edit.remove_tets.push_back(tet);
  }

  static std::vector<std::array<double, 6>> coefficients_at(const ThermalMesh& mesh, Index v) {
    std::vector<std::array<double, 6>> found;
    mesh.for_each_element(v, [&](Index t) { found.push_back(mesh.edge_coefficients(t)); });
    return found;
  }

  const Tissue& tissue_;
  std::map<Index, Eigen::Vector3d> points_;
  std::map<Index, Tet> tets_;  // live
  Index removed_of_other_ = 0;
};

double energy(const HeatField& field) {
  return field.ledger().in - ledger_error(field.ledger());
}

}  // namespace

TEST_CASE("heat field: it follows an edit of its own body only", "[unit]") {
  const Blocks blocks(make_box({2, 2, 2}, 1e-3));
  Tissue tissue(blocks.scene);
  HeatField field = blocks.field(tissue);
  const Body& body = tissue.body(1);
  const std::vector<HeatSource> middle{{body.first_vertex + 13, 1.0}};
  field.step(0.01, middle);

  tissue.apply({.remove_tets = {0, 1, 2}});
  CHECK(field.ledger().removed == 0);
  CHECK(field.step(0.01, std::vector<HeatSource>{{0, 1.0}}).active_vertices > 0);
  CHECK(field.ledger().in == Approx(0.01));  // the other body takes none

  TopologyEdit rest;
  for (Index t = 0; t < body.tet_count; ++t) {
    rest.remove_tets.push_back(body.first_tet + t);
  }
  tissue.apply(rest);
  CHECK(field.ledger().removed == Approx(0.01));
  CHECK_FALSE(field.mesh().has_tissue(body.first_vertex + 13));
  field.step(0.01, middle);
  CHECK(field.ledger().in == Approx(0.01));  // nothing to heat any more
}

// Would catch an operator that drifts from the tissue there is, heat made or lost by an edit, a new
// vertex hotter or colder than all others, and any bit that an undo leaves behind.
TEST_CASE("heat field: edits keep operator and energy, and an undo all bits", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 9));
  const bool grows = GENERATE(false, true);
  const Blocks blocks(make_box({4, 4, 4}, 1.0 / 1024, 0));
  Tissue tissue(blocks.scene);
  EditedBlock block(tissue, 1);
  HeatField field = blocks.field(tissue);
  const Body body = tissue.body(1);
  for (std::uint64_t i = 0; i < 40 && !block.is_empty(); ++i) {
    std::vector<HeatSource> sources;
    for (std::uint64_t k = 0; k < 6; ++k) {
      sources.push_back(
          {body.first_vertex + static_cast<Index>(random_unit(seed, i, k) * body.vertex_count),
           0.5});
    }
    field.step(0.02, sources);
    const HeatField before = field;  // does not follow
    const std::vector<Tet> tets_before(tissue.tets().begin(), tissue.tets().end());
    const auto [coldest, hottest] =
        std::minmax_element(before.temperatures().begin(), before.temperatures().end());

    const TopologyEdit edit = block.change(100 * seed + i, grows);
    tissue.apply(edit);

    CHECK(energy(field) == Approx(energy(before)).epsilon(1e-12));
    CHECK(sensible_heat(field) == Approx(field.ledger().sensible).epsilon(1e-9).margin(1e-12));
    for (const double t : field.temperatures()) {
      CHECK((t >= *coldest && t <= *hottest));
    }
    if (i % 10 == 9) {
      block.check(field.mesh());
    }

    tissue.undo();
    REQUIRE(same_state(field, before));
    REQUIRE(std::ranges::equal(field.mesh().tets(), tets_before));
    HeatField again = before;
    field.step(0.01, sources);
    again.step(0.01, sources);
    REQUIRE(same_state(field, again));

    // with steps between, what comes back is charged for
    tissue.apply(edit);
    field.step(0.05, {});
    tissue.undo();
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
    CHECK(sensible_heat(field) == Approx(field.ledger().sensible).epsilon(1e-9).margin(1e-12));
    tissue.apply(edit);
  }
  CHECK(field.ledger().latent > 0);
}

// A field from which edits take tetrahedra, against one that meets the same edits in tissue of its
// own and lays its part out anew after each: would catch conductances, masses and rims that are not
// dropped to the bit.
TEST_CASE("heat field: tissue that goes leaves the bits of a part laid out anew", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 7));
  const TetMesh block = make_jittered_box({4, 4, 4}, 1e-3, 0.2);
  ThermalProperties properties = kLiver;
  properties.conductivity_rise = seed % 2 == 0 ? 0 : 0.002;
  ThermalModel model;
  model.surface_transfer = 1e4;
  Tissue tissue(testing::scene_of(block)), tissue_anew(testing::scene_of(block));
  const std::array body{ThermalBody{0, properties}};
  HeatField field(tissue, body, model), anew(tissue_anew, body, model);
  for (std::uint64_t i = 0; i < 25; ++i) {
    std::vector<HeatSource> sources;
    for (std::uint64_t k = 0; k < 4; ++k) {
      const double at = random_unit(seed, i, k) * block.vertex_count();
      sources.push_back({static_cast<Index>(at), 0.3});
    }
    TopologyEdit edit;
    for (std::uint64_t k = 4; k < 10; ++k) {
      const auto t = static_cast<Index>(random_unit(seed, i, k) * block.tet_count());
      if (field.mesh().is_alive(t) && std::ranges::count(edit.remove_tets, t) == 0) {
        edit.remove_tets.push_back(t);
      }
    }
    tissue.apply(edit);
    tissue_anew.apply(edit);
    tissue_anew.undo();  // after which nothing is dropped in place
    tissue_anew.apply(edit);
    field.step(0.02, sources);
    anew.step(0.02, sources);
    REQUIRE(same_state(field, anew));
  }
  CHECK(field.ledger().removed > 0);
}

// Would catch copies that read what an edit has made of the tissue by tables of before.
TEST_CASE("heat field: a copy is refused once its tissue is edited", "[unit]") {
  const TetMesh box = make_box({2, 2, 2}, 1e-3);
  Tissue tissue(testing::scene_of(box));
  HeatField field(tissue, std::array{ThermalBody{0, kLiver}});
  const ThermalMesh mesh = field.mesh();
  PotentialField potential(mesh);
  const std::vector<double> conductivities(box.tets().size(), 0.3);
  potential.set_patch(std::array{PatchVertex{0, 1}}, 1e-6);
  CHECK(potential.solve(conductivities).vertex_count > 0);
  {
    HeatField copy = field;
    copy.step(0.01, {});  // until then
    tissue.add_follower(copy, FollowerRank::heat);
    CHECK_THROWS_WITH(tissue.apply({.remove_tets = {0}}),
                      ContainsSubstring("the mesh of a heat field does not follow"));
  }
  CHECK(tissue.version() == 0);
  HeatField copy = field;
  tissue.apply({.remove_tets = {0}});
  field.step(0.01, {});
  CHECK_THROWS_WITH(copy.step(0.01, {}),
                    ContainsSubstring("a heat field is at topology version 0"));
  CHECK_THROWS_WITH(copy.set_temperatures(std::array<Index, 1>{0}, std::array{40.0}),
                    ContainsSubstring("copies do not follow edits"));
  CHECK_THROWS_WITH(potential.solve(conductivities),
                    ContainsSubstring("the mesh of a potential is at topology version 0"));
  CHECK_THROWS_WITH(potential.find_region(conductivities),
                    ContainsSubstring("the mesh of a potential is at topology version 0"));
}

// Would catch a mesh or a field of a later day that differs from one that followed all edits.
TEST_CASE("heat field: made after edits, it is as one that followed them", "[property]") {
  const Blocks blocks(make_box({4, 4, 4}, 1.0 / 1024, 0));
  Tissue tissue(blocks.scene);
  EditedBlock block(tissue, 1);
  HeatField early = blocks.field(tissue);
  for (std::uint64_t i = 0; i < 12; ++i) {
    tissue.apply(block.change(900 + i, true));
  }
  HeatField late = blocks.field(tissue);
  block.check(late.mesh());
  for (std::uint64_t i = 0; i < 12; ++i) {
    const auto at = static_cast<Index>(random_unit(3, i) * tissue.vertex_count());
    const std::vector<HeatSource> sources{{at, 0.5}};
    early.step(0.02, sources);
    late.step(0.02, sources);
    REQUIRE(same_state(early, late));
    if (i % 3 == 2) {
      tissue.apply(block.change(950 + i, true));
    }
  }
  CHECK(late.ledger().in > 0);
}

// Would catch a field of a late body that is refused or at the wrong ids, and heat that is not
// counted when its body goes.
TEST_CASE("heat field: of a body that comes in late, and goes with its heat", "[unit]") {
  const TetMesh box = testing::make_box({2, 2, 2}, 2e-3);
  Scene scene, late;
  scene.add_body("block", box);
  late.add_body("clot", box);
  Tissue tissue(scene);
  const HeatField first(tissue, std::array{ThermalBody{0, kLiver}});
  tissue.apply({.remove_tets = {0}, .new_bodies = late});
  HeatField field(tissue, std::array{ThermalBody{1, kLiver}});
  const HeatSource source{tissue.body(1).first_vertex + 4, 1.0};
  field.step(0.1, {&source, 1});
  const double held = field.ledger().in;
  CHECK(held > 0);
  tissue.apply({.remove_bodies = {1}});
  CHECK(field.ledger().removed == Approx(held));
  CHECK(field.ledger().sensible == Approx(0).margin(1e-12));
  CHECK(first.ledger().removed == 0);
}

}  // namespace pbdsurg
