// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/heat_field.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <span>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/random.h"
#include "pbdsurg/mesh/topology.h"

#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

double sum(const HeatLedger& ledger) {
  return ledger.sensible + ledger.latent + ledger.removed;
}

}  // namespace

// A slab heated evenly at one end: T - T0 = 2 q/k sqrt(a t/pi) ierfc-like profile, at the face
// 2 q/k sqrt(a t / pi) (Carslaw and Jaeger 1959, section 2.9).
TEST_CASE("heat field: a half space under constant flux follows its closed form", "[validation]") {
  constexpr double kStep = 0.25e-3;
  const TetMesh bar = testing::make_box({60, 2, 2}, kStep);
  const TissueProperties dry{1000, 3600, 0.5, 0};
  HeatField field(bar, dry);
  const double flux = 5e3;  // W/m^2
  const double width = 2 * kStep;
  // a face vertex takes the flux through a third of each triangle around it
  std::vector<HeatSource> sources;
  std::vector<double> areas(bar.positions().size(), 0.0);
  for (const BoundaryTriangle& triangle : find_boundary(bar.tets())) {
    const auto& v = triangle.vertices;
    if (bar.positions()[v[0]].x() == 0 && bar.positions()[v[1]].x() == 0 &&
        bar.positions()[v[2]].x() == 0) {
      for (const Index corner : v) {
        areas[corner] += kStep * kStep / 6;
      }
    }
  }
  double area = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    if (areas[v] > 0) {
      sources.push_back({static_cast<Index>(v), flux * areas[v]});
      area += areas[v];
    }
  }
  REQUIRE(area == Approx(width * width));
  const double time = 4;
  for (int i = 0; i < 400; ++i) {
    field.step(time / 400, sources);
  }

  const double diffusivity = dry.conductivity / (dry.density * dry.specific_heat);
  const auto rise = [&](double x) {
    const double s = std::sqrt(diffusivity * time);
    return 2 * flux / dry.conductivity *
           (s / std::sqrt(3.14159265358979) * std::exp(-x * x / (4 * s * s)) -
            x / 2 * std::erfc(x / (2 * s)));
  };
  for (int i = 0; i <= 12; i += 3) {
    const double measured = field.temperatures()[i] - kBodyTemperature;
    CHECK(measured == Approx(rise(i * kStep)).epsilon(0.02).margin(0.01 * rise(0)));
  }
  CHECK(sum(field.ledger()) == Approx(flux * area * time));
}

// Would catch heat made or lost by conduction, boiling or removal.
TEST_CASE("heat field: every joule is accounted for", "[property]") {
  const TetMesh block = testing::make_box({6, 6, 6}, 1e-3, 0.1);
  Scene scene;
  scene.add_body("block", block);
  Solver solver(scene);
  HeatField field(block, kFat);
  EditParticipant* participants[] = {&field};
  std::vector<HeatSource> sources;
  for (const Index v : block.tets()[500]) {
    sources.push_back({v, 1.5});
  }
  for (int i = 0; i < 100; ++i) {
    field.step(5e-3, sources);
    if (i == 60) {
      TopologyEdit edit;
      for (Index t = 0; t < block.tet_count(); ++t) {
        if (field.boiling_vertices(t) == 4) {
          edit.remove_tets.push_back(t);
        }
      }
      REQUIRE_FALSE(edit.remove_tets.empty());
      apply_edit(solver, edit, participants);
    }
    CHECK(sum(field.ledger()) == Approx(field.ledger().in).epsilon(1e-9));
  }
  CHECK(field.ledger().latent > 0);
  CHECK(field.ledger().removed > 0);
}

TEST_CASE("heat field: temperature waits at 100 degrees until the water is gone", "[unit]") {
  const TetMesh block = testing::make_box({1, 1, 1}, 1e-3);
  HeatField field(block, kLiver);
  std::vector<HeatSource> everywhere;
  const std::vector<double> masses = lumped_masses(block, kLiver.density);
  for (Index v = 0; v < 8; ++v) {
    everywhere.push_back({v, 1e6 * masses[v]});  // 1 MW/kg
  }
  const double to_boil = 63 * kLiver.specific_heat / 1e6;                  // s
  const double to_dry = kLiver.water_fraction * kLatentHeatOfWater / 1e6;  // s

  field.step(0.99 * to_boil, everywhere);
  CHECK(field.temperatures()[3] < kBoilingTemperature);
  CHECK(field.water()[3] == 1);
  field.step(0.01 * to_boil + 0.5 * to_dry, everywhere);
  CHECK(field.temperatures()[3] == kBoilingTemperature);
  CHECK(field.water()[3] == Approx(0.5));
  field.step(0.6 * to_dry, everywhere);
  CHECK(field.water()[3] == 0);
  CHECK(field.temperatures()[3] ==
        Approx(kBoilingTemperature + 0.1 * to_dry * 1e6 / kLiver.specific_heat));
  CHECK(field.boiling_vertices(0) == 4);
}

// Would catch an unstable explicit step: flat and obtuse tetrahedra need tiny steps and have
// negative conductances, and must neither blow up nor cool below what surrounds them.
TEST_CASE("heat field: temperatures stay between those around, on the worst of meshes",
          "[property]") {
  const double height = GENERATE(1.0, 0.1, 0.03);  // of a cell, relative to its width
  const double dt = GENERATE(5e-3, 0.5);
  const TetMesh block = testing::make_box({6, 6, 4}, 1e-3, 0.2);
  std::vector<Eigen::Vector3d> points(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& p : points) {
    p.z() *= height;
  }
  const TetMesh flat(points, {block.tets().begin(), block.tets().end()});
  HeatField field(flat, kLiver);
  field.step(5e-3, std::vector<HeatSource>{{100, 0.05}});
  const double peak = *std::max_element(field.temperatures().begin(), field.temperatures().end());
  REQUIRE(peak > kBodyTemperature);
  for (int i = 0; i < 200; ++i) {
    field.step(dt, {});
    for (const double t : field.temperatures()) {
      REQUIRE(t >= kBodyTemperature - 1e-9);
      REQUIRE(t <= peak + 1e-9);
    }
  }
  CHECK(sum(field.ledger()) == Approx(field.ledger().in));
  if (height < 0.1 && dt > 0.1) {
    CHECK(field.limited_edge_count() > 0);
  }
}

TEST_CASE("heat field: it follows an edit of its own body only", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, 1e-3);
  scene.add_body("first", block);
  const Index second = scene.add_body("second", block);
  Solver solver(scene);
  HeatField field(block, kFat, scene.body(second));
  field.step(0.01, std::vector<HeatSource>{{13, 1.0}});
  EditParticipant* participants[] = {&field};

  apply_edit(solver, {.remove_tets = {0, 1, 2}}, participants);
  CHECK(field.ledger().removed == 0);

  TopologyEdit rest;
  for (Index t = 0; t < block.tet_count(); ++t) {
    rest.remove_tets.push_back(scene.body(second).first_tet + t);
  }
  apply_edit(solver, rest, participants);
  CHECK(field.ledger().removed == Approx(0.01));
  CHECK_FALSE(field.has_tissue(13));
  field.step(0.01, std::vector<HeatSource>{{13, 1.0}});
  CHECK(field.ledger().in == Approx(0.01));  // nothing to heat any more
}

namespace {

// What edits make of a block, in the numbering of a scene in which the block is not first and
// others get new vertices and tetrahedra, too. Edits are made by hand: what a solver would say of
// them is all that a field hears.
class EditedBlock {
 public:
  static constexpr Index kFirstVertex = 40, kFirstTet = 70;

  explicit EditedBlock(const TetMesh& mesh) {
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      points_[kFirstVertex + v] = mesh.positions()[v];
    }
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      Tet& tet = tets_[kFirstTet + t] = mesh.tets()[t];
      for (Index& v : tet) {
        v += kFirstVertex;
      }
    }
    next_vertex_ = kFirstVertex + mesh.vertex_count() + 5;
    next_tet_ = kFirstTet + mesh.tet_count() + 5;
  }

  static Body place() {
    Body body;
    body.first_vertex = kFirstVertex;
    body.first_tet = kFirstTet;
    return body;
  }

  // Removes tetrahedra, splits an edge and parts some tetrahedra from a vertex, at random.
  void change(std::uint64_t seed, bool grows, TopologyEdit& edit, EditResult& result) {
    std::uint64_t round = 0;
    const auto random = [&] { return random_unit(seed, ++round); };
    result.first_new_vertex = next_vertex_;
    result.first_new_tet = next_tet_;
    edit.new_vertices.push_back({0, 1, 0.5F});  // of another body
    std::map<Index, Tet> free = tets_;          // neither removed nor divided yet
    const auto any = [&] {
      return *std::next(free.begin(),
                        static_cast<Index>(random() * static_cast<double>(free.size())));
    };
    for (int i = 0; i < 4 && !free.empty(); ++i) {
      const Index t = any().first;
      edit.remove_tets.push_back(t);
      free.erase(t);
    }
    edit.remove_tets.push_back(3);  // of another body
    result.tets = edit.remove_tets;
    std::map<Index, Tet> children;
    if (grows && !free.empty()) {
      const Tet tet = any().second;
      const Index a = tet[0], b = tet[2];
      const auto share = static_cast<float>(0.3 + 0.4 * random());
      const Index middle = next_vertex_ + static_cast<Index>(edit.new_vertices.size());
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
          children[next_tet_ + static_cast<Index>(edit.new_tets.size())] = child;
          edit.new_tets.push_back({id, child});
        }
        result.tets.push_back(id);
        entry = free.erase(entry);
      }
    }
    if (grows && !free.empty()) {
      const Index from = any().second[1];
      const Index to = next_vertex_ + static_cast<Index>(edit.new_vertices.size());
      edit.new_vertices.push_back({from, from, 0});
      points_[to] = points_[from];
      for (auto& [id, tet] : free) {
        if (std::count(tet.begin(), tet.end(), from) > 0 && random() < 0.5) {
          edit.corner_moves.push_back({id, from, to});
          std::replace(tet.begin(), tet.end(), from, to);
        }
      }
    }
    free.insert(children.begin(), children.end());
    tets_ = free;
    next_vertex_ += static_cast<Index>(edit.new_vertices.size()) + 2;
    next_tet_ += static_cast<Index>(edit.new_tets.size()) + 2;
  }

  [[nodiscard]] bool is_empty() const { return tets_.empty(); }

  // Compares a field's operator with that of a field of what lives.
  void check(const HeatField& field, const TissueProperties& tissue) const {
    std::vector<Eigen::Vector3d> points(static_cast<std::size_t>(next_vertex_),
                                        Eigen::Vector3d::Zero());
    for (const auto& [v, point] : points_) {
      points[v] = point;
    }
    std::vector<Tet> live;
    for (const auto& [id, tet] : tets_) {
      live.push_back(tet);
    }
    const HeatField expected(TetMesh(points, live), tissue);
    for (Index v = 0; v < static_cast<Index>(field.capacities().size()); ++v) {
      CHECK(field.capacities()[v] ==
            Approx(expected.capacities()[field.scene_vertex(v)]).epsilon(1e-12));
      CHECK(field.find_vertex(field.scene_vertex(v)) == v);
    }
    std::map<Edge, double> conductances;
    for (std::size_t e = 0; e < expected.edges().size(); ++e) {
      conductances[expected.edges()[e]] = expected.conductances()[e];
    }
    std::map<Edge, double> found;
    for (std::size_t e = 0; e < field.edges().size(); ++e) {
      const auto [a, b] = field.edges()[e];
      const Edge edge{std::min(field.scene_vertex(a), field.scene_vertex(b)),
                      std::max(field.scene_vertex(a), field.scene_vertex(b))};
      if (conductances.count(edge) == 0) {
        CHECK(field.conductances()[e] == 0);
      } else {
        found[edge] += field.conductances()[e];
      }
    }
    CHECK(found.size() == conductances.size());
    for (const auto& [edge, conductance] : conductances) {
      CHECK(found[edge] == Approx(conductance).epsilon(1e-12).margin(1e-16));
    }
  }

 private:
  std::map<Index, Eigen::Vector3d> points_;
  std::map<Index, Tet> tets_;  // live
  Index next_vertex_, next_tet_;
};

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

bool same_state(const HeatField& a, const HeatField& b) {
  const HeatLedger x = a.ledger(), y = b.ledger();
  return same(a.temperatures(), b.temperatures()) && same(a.water(), b.water()) &&
         same(a.peak_temperatures(), b.peak_temperatures()) &&
         same(a.capacities(), b.capacities()) && same(a.conductances(), b.conductances()) &&
         same(a.edges(), b.edges()) && same(a.tets(), b.tets()) && x.in == y.in &&
         x.sensible == y.sensible && x.latent == y.latent && x.removed == y.removed &&
         a.limited_edge_count() == b.limited_edge_count();
}

}  // namespace

// Would catch an operator that drifts from the tissue there is, heat made or lost by an edit, a new
// vertex hotter or colder than all others, and any bit that an undo leaves behind.
TEST_CASE("heat field: edits keep operator and energy, and an undo all bits", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 9));
  const bool grows = GENERATE(false, true);
  const TetMesh mesh = testing::make_box({4, 4, 4}, 1e-3, 0.1);
  EditedBlock block(mesh);
  HeatField field(mesh, kLiver, EditedBlock::place());
  Scene scene;
  scene.add_body("block", mesh);
  const Solver solver(scene);  // which a field does not look at
  for (std::uint64_t i = 0; i < 60 && !block.is_empty(); ++i) {
    std::vector<HeatSource> sources;
    for (std::uint64_t k = 0; k < 6; ++k) {
      sources.push_back({static_cast<Index>(random_unit(seed, i, k) * mesh.vertex_count()), 0.5});
    }
    field.step(0.02, sources);
    const HeatField before = field;
    const auto [coldest, hottest] =
        std::minmax_element(before.temperatures().begin(), before.temperatures().end());

    TopologyEdit edit;
    EditResult result;
    block.change(100 * seed + i, grows, edit, result);
    field.apply(solver, edit, result);

    CHECK(sum(field.ledger()) == Approx(sum(before.ledger())).epsilon(1e-12));
    for (const double t : field.temperatures()) {
      CHECK((t >= *coldest && t <= *hottest));
    }
    if (i % 10 == 9) {
      block.check(field, kLiver);
    }

    field.undo(solver, edit, result);
    REQUIRE(same_state(field, before));
    HeatField again = before;
    field.step(0.01, sources);
    again.step(0.01, sources);
    REQUIRE(same_state(field, again));

    // with steps between, what comes back is charged for
    field.apply(solver, edit, result);
    field.step(0.05, {});
    field.undo(solver, edit, result);
    CHECK(sum(field.ledger()) == Approx(field.ledger().in).epsilon(1e-9));
    CHECK(same(field.capacities(), before.capacities()));
    field.apply(solver, edit, result);
  }
  CHECK(field.ledger().latent > 0);
}

TEST_CASE("heat field: bad values are refused by name", "[unit]") {
  const TetMesh block = testing::make_box({1, 1, 1}, 1e-3);
  CHECK_THROWS_WITH(HeatField(block, {0, 1, 1, 0}), ContainsSubstring("density"));
  CHECK_THROWS_WITH(HeatField(block, {1, 1, 1, 1.5}), ContainsSubstring("water fraction is 1.5"));
  HeatField field(block, kFat);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(field.step(0, {}), InvalidArgument);
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{8, 1}}), ContainsSubstring("vertex 8"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, nan}}), ContainsSubstring("power"));
  CHECK(field.ledger().in == 0);
}

// Would catch a field of a late body that is refused or at the wrong ids, and heat that is not
// counted when its body goes.
TEST_CASE("heat field: of a body that comes in late, and goes with its heat", "[unit]") {
  const TetMesh box = testing::make_box({2, 2, 2}, 2e-3);
  Scene scene, late;
  scene.add_body("block", box);
  late.add_body("clot", box);
  Solver solver(scene);
  HeatField first(box, kLiver, solver.body(0));
  EditParticipant* const one[] = {&first};
  apply_edit(solver, {.remove_tets = {0}, .new_bodies = late}, one);
  CHECK_THROWS_WITH(HeatField(box, kLiver, solver, 0), ContainsSubstring("body 'block'"));
  HeatField field(box, kLiver, solver, 1);
  CHECK(field.scene_vertex(3) == box.vertex_count() + 3);
  const HeatSource source{4, 1.0};
  field.step(0.1, {&source, 1});
  const double held = field.ledger().in;
  EditParticipant* const both[] = {&first, &field};
  apply_edit(solver, {.remove_bodies = {1}}, both);
  CHECK(field.ledger().removed == Approx(held));
  CHECK(first.ledger().removed == 0);
}

}  // namespace pbdsurg
