// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/heat_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/scenes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::ledger_error;
using testing::make_box;
using testing::make_jittered_box;
using testing::set_profile;

const ThermalProperties& kLiver = tissues::liver().heat;
const ThermalProperties& kFat = tissues::fat().heat;

// A block as the second of two bodies, so that its ids are not those of its mesh.
struct Blocks {
  explicit Blocks(TetMesh block) : mesh(std::move(block)) {
    scene.add_body("other", other);
    scene.add_body("block", mesh);
  }

  [[nodiscard]] HeatField field(const Tissue& tissue, const ThermalModel& model = {}) const {
    return {tissue, std::array{ThermalBody{1, kLiver}}, model};
  }

  TetMesh other = make_box({3, 3, 3}, 1e-3), mesh;
  Scene scene;
};

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
    mesh.for_each_tet(v, [&](Index t) { found.push_back(mesh.edge_coefficients(t)); });
    return found;
  }

  const Tissue& tissue_;
  std::map<Index, Eigen::Vector3d> points_;
  std::map<Index, Tet> tets_;  // live
  Index removed_of_other_ = 0;
};

bool same(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool same_ledger(const HeatLedger& a, const HeatLedger& b) {
  return a.in == b.in && a.sensible == b.sensible && a.latent == b.latent &&
         a.removed == b.removed && a.surface == b.surface && a.perfusion == b.perfusion;
}

bool same_state(const HeatField& a, const HeatField& b) {
  return same(a.temperatures(), b.temperatures()) && same(a.water(), b.water()) &&
         same(a.peak_temperatures(), b.peak_temperatures()) && same(a.survival(), b.survival()) &&
         same(a.collagen(), b.collagen()) && same(a.charred(), b.charred()) &&
         same_ledger(a.ledger(), b.ledger()) &&
         std::ranges::equal(a.active_vertices(), b.active_vertices()) &&
         std::ranges::equal(a.mesh().tets(), b.mesh().tets());
}

double energy(const HeatField& field) {
  return field.ledger().in - ledger_error(field.ledger());
}

// Sensible heat found afresh.
double sensible_heat(const HeatField& field) {
  double sum = 0;
  for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
    sum += field.capacity(v) * (field.temperatures()[v] - kBodyTemperature);
  }
  return sum;
}

}  // namespace

// Would catch heat made or lost by conduction, boiling, the surface, blood or removal, by a region
// that grows and shrinks, or by a ledger that drifts from the field.
TEST_CASE("heat field: every joule is accounted for in every step", "[property]") {
  const Blocks blocks(make_box({10, 10, 10}, 0.7e-3, 0.1));
  Tissue tissue(blocks.scene);
  ThermalModel model;
  model.has_perfusion = true;
  model.surface_transfer = 500;
  model.ambient_temperature = 22;
  HeatField field = blocks.field(tissue, model);
  const Body& body = tissue.body(1);
  std::vector<TetHeatSource> sources;
  for (Index t = 0; t < 6; ++t) {
    sources.push_back({body.first_tet + 2700 + t, 1.5});
  }
  for (int i = 0; i < 200; ++i) {
    const HeatReport report =
        field.step(5e-3, {}, i < 120 ? sources : std::vector<TetHeatSource>{});
    CHECK(report.converged);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-13 * field.ledger().in);
    CHECK(sensible_heat(field) == Approx(field.ledger().sensible).epsilon(1e-10));
    if (i == 100) {
      TopologyEdit edit;
      for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
        if (field.boiled_vertices(t) == 4) {
          edit.remove_tets.push_back(t);
        }
      }
      REQUIRE_FALSE(edit.remove_tets.empty());
      tissue.apply(edit);
    }
  }
  const HeatLedger& ledger = field.ledger();
  for (const double part : {ledger.latent, ledger.removed, ledger.surface, ledger.perfusion}) {
    CHECK(std::abs(part) > 1e-4 * ledger.in);  // blood warms what the ambient cools
  }
}

// Would catch a rim that keeps heat in, or heat that is forgotten: the warm part alone gives what
// the whole mesh does, but for what is too little to be followed.
TEST_CASE("heat field: what rests does not matter", "[property]") {
  const TetMesh mesh = make_box({16, 16, 16}, 0.5e-3, 0.1);
  HeatField part(mesh, kLiver), whole(mesh, kLiver, {}, {.active_rise = 0});
  const std::vector<HeatSource> sources{{17 * 17 * 8 + 17 * 8 + 8, 2}};
  Index most = 0;
  for (int i = 0; i < 400; ++i) {
    const std::span<const HeatSource> now = i < 100 ? sources : std::span<const HeatSource>();
    most = std::max(most, part.step(0.01, now).active_vertices);
    whole.step(0.01, now);
    double largest = 0;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      largest = std::max(largest, std::abs(part.temperatures()[v] - whole.temperatures()[v]));
    }
    REQUIRE(largest < 0.1);
  }
  CHECK(most < mesh.vertex_count() * 3 / 5);
}

// Would catch work that grows with the organ: the same burn in ten times the tissue.
TEST_CASE("heat field: an equal burn costs the same in a larger organ", "[property]") {
  const auto burn = [](std::array<Index, 3> cells) {
    const TetMesh mesh = make_box(cells, 0.5e-3);
    HeatField field(mesh, kLiver);
    const Index middle = (cells[0] + 1) * (cells[1] / 2) + cells[0] / 2;  // of the face z = 0
    std::vector<Index> active;
    for (int i = 0; i < 100; ++i) {
      const HeatReport report = field.step(5e-3, std::vector<HeatSource>{{middle, 5}});
      active.push_back(report.active_vertices);
    }
    return active;
  };
  const std::vector<Index> small = burn({16, 16, 13});  // 20,000 tetrahedra
  CHECK(small == burn({48, 48, 15}));                   // 207,000
  CHECK(small.back() > 100);
  CHECK(small.back() < 17 * 17 * 14 / 2);
}

// Would catch active vertices that are those of the next step: what had changed would be missed.
TEST_CASE("heat field: the region shrinks as it cools, and rests", "[unit]") {
  const TetMesh mesh = make_box({12, 12, 12}, 0.5e-3);
  ThermalModel model;
  model.has_perfusion = true;
  HeatField field(mesh, kLiver, model);
  CHECK(field.step(1, {}).active_vertices == 0);
  Index most = 0;
  for (int i = 0; i < 20; ++i) {
    most = std::max(most, field.step(0.01, std::vector<HeatSource>{{0, 0.2}}).active_vertices);
  }
  REQUIRE(most > 50);
  for (int i = 0; i < 400; ++i) {
    const Index worked_on = field.step(1, {}).active_vertices;
    REQUIRE(static_cast<Index>(field.active_vertices().size()) == worked_on);
  }
  CHECK(field.active_vertices().empty());
  CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
}

// The paper's numbers as printed let heat cross the organ in one step: the region must follow
// within it, or its rim would be far too hot.
TEST_CASE("heat field: the region keeps up with heat that crosses it in a step", "[unit]") {
  const TetMesh mesh = make_box({20, 6, 6}, 1e-3);
  ThermalModel model = ThermalModel::paper();
  model.tissue->density = 3;
  model.tissue->specific_heat = 0.3;
  HeatField part(mesh, kLiver, model), whole(mesh, kLiver, model, {.active_rise = 0});
  const std::vector<HeatSource> sources{{0, 1e-2}};
  for (int i = 0; i < 5; ++i) {
    part.step(1e-4, sources);
    whole.step(1e-4, sources);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      REQUIRE(part.temperatures()[v] ==
              Approx(whole.temperatures()[v]).margin(1 + 0.02 * whole.temperatures()[v]));
    }
  }
  REQUIRE(whole.temperatures()[60] > 40);
}

// Would catch sums that depend on who adds first.
TEST_CASE("heat field: the same bits for any number of threads", "[property]") {
  const TetMesh mesh = make_box({19, 19, 19}, 0.5e-3, 0.1);  // large enough to be shared
  std::vector<HeatField> fields;
  for (const int threads : {1, 2, 3}) {
    fields.emplace_back(mesh, kLiver, ThermalModel{},
                        HeatOptions{.active_rise = 0, .executor = executor::threads(threads)});
  }
  for (int i = 0; i < 30; ++i) {
    for (HeatField& field : fields) {
      field.step(5e-3, std::vector<HeatSource>{{4000, 4}, {20, 1}});
      REQUIRE(same_state(field, fields[0]));
    }
  }
  CHECK(fields[0].ledger().latent > 0);
}

// Would catch coefficients of flat tetrahedra that overflow or take the solver's digits.
TEST_CASE("heat field: slivers are counted and do no harm", "[property]") {
  const double height = GENERATE(1e-3, 1e-6, 1e-9);  // of cells, relative to their width
  const TetMesh block = make_box({5, 5, 3}, 1e-3);
  std::vector<Eigen::Vector3d> points(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& p : points) {
    p.z() = p.z() > 1.5e-3 ? p.z() : height * p.z();  // all below the middle
  }
  const TetMesh flat(points, {block.tets().begin(), block.tets().end()});
  HeatField field(flat, kLiver);
  HeatReport report;
  for (int i = 0; i < 50; ++i) {
    report = field.step(5e-3, std::vector<HeatSource>{{60, 0.2}, {120, 0.2}});
    CHECK(report.accepted);
    CHECK(report.converged);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
  }
  CHECK((report.slivers > 0) == (height < 1e-4));
  for (const double t : field.temperatures()) {
    REQUIRE(std::isfinite(t));
    REQUIRE(t > 30);
  }
}

TEST_CASE("heat field: a step without a finite result is reported and not taken", "[unit]") {
  const TetMesh mesh = make_box({4, 4, 4}, 1e-3);
  HeatField field(mesh, kLiver);
  field.step(0.01, std::vector<HeatSource>{{60, 1}});
  const HeatField before = field;
  const HeatReport report = field.step(0.01, std::vector<HeatSource>{{60, 1e308}, {61, 1e308}});
  CHECK_FALSE(report.accepted);
  CHECK(same(field.temperatures(), before.temperatures()));
  CHECK(same_ledger(field.ledger(), before.ledger()));
  CHECK(field.step(0.01, std::vector<HeatSource>{{60, 1}}).accepted);
}

TEST_CASE("heat field: a solver that has too few iterations is reported, and loses no heat",
          "[unit]") {
  const TetMesh mesh = make_box({6, 6, 6}, 0.5e-3, 0.1);
  HeatField field(mesh, kLiver, {}, {.tolerance = 1e-10, .most_iterations = 1});
  for (int i = 0; i < 20; ++i) {
    const HeatReport report = field.step(0.05, std::vector<HeatSource>{{171, 1}});
    CHECK_FALSE(report.converged);
    CHECK(report.residual > 1e-10);
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
  }
}

TEST_CASE("heat field: power in a tetrahedron goes to its corners", "[unit]") {
  const TetMesh mesh = make_box({3, 3, 3}, 1e-3);
  HeatField by_tet(mesh, kFat), by_vertex(mesh, kFat);
  const Tet& tet = mesh.tets()[80];
  by_tet.step(0.01, {}, std::vector<TetHeatSource>{{80, 2}});
  by_vertex.step(
      0.01, std::vector<HeatSource>{{tet[0], 0.5}, {tet[1], 0.5}, {tet[2], 0.5}, {tet[3], 0.5}});
  CHECK(same(by_tet.temperatures(), by_vertex.temperatures()));
  CHECK(by_tet.ledger().in == Approx(0.02));
}

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

TEST_CASE("heat field: bad values are refused by name", "[unit]") {
  const TetMesh block = make_box({1, 1, 1}, 1e-3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(HeatField(block, {0, 1, 1, 0}), ContainsSubstring("density"));
  CHECK_THROWS_WITH(HeatField(block, kFat, {}, {.active_rise = -1}),
                    ContainsSubstring("active_rise"));
  CHECK_THROWS_WITH(HeatField(block, kFat, {}, {.tolerance = 0}), ContainsSubstring("tolerance"));
  ThermalModel model;
  model.theta = 0.3;
  CHECK_THROWS_WITH(HeatField(block, kFat, model), ContainsSubstring("theta"));
  HeatField field(block, kFat);
  CHECK_THROWS_AS(field.step(0, {}), InvalidArgument);
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{8, 1}}), ContainsSubstring("vertex 8"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, nan}}), ContainsSubstring("power"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, 1}, {2, -1}}),
                    ContainsSubstring("vertex 2"));
  CHECK_THROWS_WITH(field.step(1, {}, std::vector<TetHeatSource>{{6, 1}}),
                    ContainsSubstring("tet 6"));
  const std::vector<Index> first{0}, wrong{-1};
  CHECK_THROWS_WITH(field.set_temperatures(first, std::vector<double>{nan}),
                    ContainsSubstring("vertex 0"));
  CHECK_THROWS_WITH(field.set_temperatures(wrong, std::vector<double>{40}),
                    ContainsSubstring("vertex -1"));
  CHECK_THROWS_WITH(field.hold(wrong), ContainsSubstring("vertex -1"));
  CHECK(field.ledger().in == 0);
  CHECK(field.temperatures()[0] == kBodyTemperature);
}

// Would catch temperatures, states, held vertices or warm regions that are lost in a compaction or
// go to others, and slivers or bodies that are gone and still count.
TEST_CASE("heat field: it goes along with a compaction", "[property]") {
  const TetMesh box = testing::make_box({4, 4, 4}, 1e-3, 0.05);
  Scene scene;
  scene.add_body("gone", box);
  scene.add_body("other", testing::make_box({2, 2, 2}, 1e-3));
  scene.add_body("block", box);
  Solver solver(scene, {.executor = executor::serial()});
  Tissue& tissue = solver.tissue();
  Tissue old_tissue(scene);  // has the same edits, and is not compacted
  const std::array bodies{ThermalBody{0, kFat}, ThermalBody{2, kLiver}};
  ThermalModel model;
  model.surface_transfer = 20;
  HeatField field(tissue, bodies, model, {.tolerance = 1e-12});
  HeatField unchanged(old_tissue, bodies, model, {.tolerance = 1e-12});
  const auto apply = [&](const TopologyEdit& edit) {
    tissue.apply(edit);
    old_tissue.apply(edit);
  };
  const Index first = tissue.body(2).first_vertex;
  const Index first_tet = tissue.body(2).first_tet;
  const Index held = first + 7, cold = first + box.vertex_count() - 1;
  const std::vector<HeatSource> sources{{5, 2.0}, {first + 62, 3.0}};
  for (HeatField* each : {&field, &unchanged}) {
    each->set_temperatures(std::array{held, cold}, std::array{80.0, 30.0});
    each->hold(std::array{held, Index{4}, cold});
    for (int i = 0; i < 20; ++i) {
      each->step(0.02, sources);
    }
  }
  for (Index i = 0; i < 4; ++i) {
    apply(testing::split_edge(solver, tissue.tet_edges(first_tet + 50 + 9 * i)[1], 0.4F));
    apply(testing::part_vertex(solver, first + 30 + i, 3));
  }
  TopologyEdit corner{.remove_bodies = {0}};
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (tissue.is_tet_alive(t) && testing::has_corner(tissue.tets()[t], cold)) {
      corner.remove_tets.push_back(t);
    }
  }
  corner.new_bodies.add_body("guest", box);
  apply(corner);
  REQUIRE(field.ledger().removed > 0);

  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  CHECK(field.mesh().vertex_count() == tissue.vertex_count());
  CHECK(field.mesh().tet_count() == static_cast<Index>(tissue.tets().size()));
  CHECK(field.mesh().version() != unchanged.mesh().version());
  CHECK(field.ledger().in == unchanged.ledger().in);
  const auto farthest = [&] {
    double most = 0;
    for (Index v = 0; v < unchanged.mesh().vertex_count(); ++v) {
      if (const Index id = ids.vertices[v]; id != kInvalidIndex) {
        most = std::max({most, std::abs(field.temperatures()[id] - unchanged.temperatures()[v]),
                         std::abs(field.peak_temperatures()[id] - unchanged.peak_temperatures()[v]),
                         std::abs(field.water()[id] - unchanged.water()[v]),
                         std::abs(field.survival()[id] - unchanged.survival()[v]),
                         std::abs(field.collagen()[id] - unchanged.collagen()[v]),
                         std::abs(field.charred()[id] - unchanged.charred()[v])});
      }
    }
    return most;
  };
  CHECK(farthest() == 0);
  // the region is the same: heat that it left out would show
  const HeatSource old_source{first + 62, 3.0}, source{ids.vertices[first + 62], 3.0};
  for (int i = 0; i < 50; ++i) {
    const HeatReport report = field.step(0.05, {&source, 1});
    const HeatReport expected = unchanged.step(0.05, {&old_source, 1});
    CHECK(report.slivers == expected.slivers);
    REQUIRE(farthest() < 1e-8);
  }
  CHECK(field.temperatures()[ids.vertices[held]] == 80);
  CHECK(field.ledger().in == Approx(unchanged.ledger().in).epsilon(1e-10));
  CHECK(field.ledger().sensible == Approx(unchanged.ledger().sensible).epsilon(1e-10));
  CHECK(field.ledger().latent == Approx(unchanged.ledger().latent).epsilon(1e-10));
  CHECK(field.ledger().surface == Approx(unchanged.ledger().surface).epsilon(1e-10));
  CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
}

// Would catch a potential that takes ids of one numbering for those of another, and ground that
// gives way to a ball because its tissue has gone.
TEST_CASE("heat field: a potential goes along with a compaction of its mesh", "[unit]") {
  const TetMesh box = testing::make_box({6, 6, 6}, 1e-3, 0.05);
  Scene scene;
  scene.add_body("gone", testing::make_box({2, 2, 2}, 1e-3));
  scene.add_body("block", box);
  Solver solver(scene, {.executor = executor::serial()});
  Tissue& tissue = solver.tissue();
  Tissue old_tissue(scene);  // has the same edit, and is not compacted
  const std::array bodies{ThermalBody{1, kLiver}};
  const ThermalMesh mesh(tissue, bodies), old_mesh(old_tissue, bodies);
  PotentialField potential(mesh, {.tolerance = 1e-10});
  PotentialField expected(old_mesh, {.tolerance = 1e-10});
  const Index first = tissue.body(1).first_vertex, last = first + box.vertex_count() - 1;
  const bool loses_ground = GENERATE(false, true);
  TopologyEdit edit{.remove_bodies = {0}};
  for (Index t = tissue.body(1).first_tet; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (loses_ground && testing::has_corner(tissue.tets()[t], last)) {
      edit.remove_tets.push_back(t);
    }
  }
  for (PotentialField* each : {&potential, &expected}) {
    each->set_patch(std::array{PatchVertex{first, 1}, PatchVertex{first + 1, 0.5}}, 1e-6);
    each->set_ground(std::array{last});
  }
  tissue.apply(edit);
  old_tissue.apply(edit);
  const auto solve = [](PotentialField& field, const ThermalMesh& of) {
    return field.solve(std::vector<double>(static_cast<std::size_t>(of.tet_count()), 0.3));
  };
  const double conductance = solve(expected, old_mesh).conductance;
  CHECK((conductance == 0) == loses_ground);
  solve(potential, mesh);

  Compaction compaction(solver);
  compaction.build();
  CHECK(potential.report().conductance == conductance);
  compaction.finish(solver);
  CHECK(potential.vertices().empty());
  CHECK(potential.report().conductance == 0);  // until the next solve()
  CHECK(solve(potential, mesh).conductance == Approx(conductance).epsilon(1e-9));
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
