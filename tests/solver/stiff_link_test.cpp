// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/stiff_link.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::neo_hookean;
using testing::run;
using testing::vertex_options;

constexpr double kLinkedEdge = 5e-3;
constexpr Index kLinkedCells = 4;
constexpr double kSide = kLinkedCells * kLinkedEdge;

TetMesh block_at(double height) {
  const TetMesh mesh = testing::make_box({kLinkedCells, kLinkedCells, kLinkedCells}, kLinkedEdge);
  std::vector<Eigen::Vector3d> positions(mesh.positions().begin(), mesh.positions().end());
  for (Eigen::Vector3d& x : positions) {
    x.z() += height;
  }
  return {std::move(positions), {mesh.tets().begin(), mesh.tets().end()}};
}

bool is_stiff(const Solver& solver) {
  return std::ranges::any_of(
      solver.plan().phases, [](const Phase& phase) { return phase.kind == PhaseKind::stiff_link; });
}

// One block held at its top, another hung on it by a link at each vertex of the faces between.
struct Hanging {
  Scene scene;
  std::vector<Index> links;

  Hanging(float upper, float lower, float compliance, float length) {
    scene.add_body("upper", block_at(0), neo_hookean(upper, 0.3F));
    scene.add_body("lower", block_at(-kSide - double{length}), neo_hookean(lower, 0.3F));
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() > kSide - 0.5 * kLinkedEdge; });
    scene.set_gravity({0, 0, -9.81F});
    const Index count = scene.body(0).vertex_count;
    for (Index a = 0; a < count; ++a) {
      for (Index b = count; b < 2 * count; ++b) {
        const Eigen::Vector3d d = scene.positions()[a] - scene.positions()[b];
        if (std::abs(d.x()) + std::abs(d.y()) < 1e-9 &&
            d.z() < double{length} + 0.5 * kLinkedEdge &&
            scene.positions()[a].z() < 0.5 * kLinkedEdge) {
          links.push_back(scene.add_link({a, b, length, {1, compliance}}));
        }
      }
    }
  }

  // m, of the lowest vertex, from where it was at rest
  static double sag(const Solver& solver) {
    double lowest = 0;
    for (const Eigen::Vector3f& x : solver.positions()) {
      lowest = std::min<double>(lowest, x.z());
    }
    return -lowest - kSide;
  }
};

}  // namespace

// Would catch a link that holds each end by the last place of the other: such bodies fell, the
// further the stiffer the link.
TEST_CASE("stiff link: bodies joined by any compliance hang as if they were one", "[validation]") {
  const float dt = GENERATE(1e-3F, 5e-3F, 16e-3F);
  const float length = GENERATE(0.0F, 3e-3F);
  Scene one;
  one.add_body("both",
               testing::make_box({kLinkedCells, kLinkedCells, 2 * kLinkedCells}, kLinkedEdge),
               neo_hookean(5e3F, 0.3F));
  one.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() > 2 * kSide - 0.5 * kLinkedEdge; });
  one.set_gravity({0, 0, -9.81F});
  Solver welded(one, vertex_options(1, 10, 20));
  run(welded, static_cast<int>(1 / dt), dt);
  const double expected = Hanging::sag(welded) + kSide;
  REQUIRE(expected > 0.05 * kSide);

  for (const float compliance : {0.0F, 1e-7F, 1e-5F, 1e-4F}) {
    const Hanging hanging(5e3F, 5e3F, compliance, length);
    REQUIRE(hanging.links.size() == (kLinkedCells + 1) * (kLinkedCells + 1));
    Solver solver(hanging.scene, vertex_options(1, 10, 20));
    CHECK(is_stiff(solver));
    run(solver, static_cast<int>(1 / dt), dt);
    CHECK(Hanging::sag(solver) - double{length} == Approx(expected).epsilon(0.01));
  }
}

TEST_CASE("stiff link: tissue may be a thousand times as stiff as what it holds", "[validation]") {
  const bool is_stiff_above = GENERATE(true, false);
  const Hanging hanging(is_stiff_above ? 5e6F : 5e3F, is_stiff_above ? 5e3F : 5e6F, 0, 0);
  Solver solver(hanging.scene, vertex_options(20, 5, 20));
  run(solver, 200);
  // the soft block alone: under its own weight, or with that of the other on it
  const double own = 1000 * 9.81 * kSide * kSide / 5e3;
  const double sag = Hanging::sag(solver);
  CHECK(sag > (is_stiff_above ? 0.35 : 1.1) * own);
  CHECK(sag < (is_stiff_above ? 0.55 : 1.9) * own);
}

TEST_CASE("stiff link: what tissue takes as a spring stays one", "[unit]") {
  CHECK_FALSE(is_stiff(Solver(Hanging(5e3F, 5e3F, 5e-3F, 0).scene, vertex_options())));
  CHECK(is_stiff(Solver(Hanging(5e3F, 5e3F, 5e-4F, 0).scene, vertex_options())));
  CHECK_FALSE(is_stiff(Solver(Hanging(5e5F, 5e5F, 5e-4F, 0).scene, vertex_options())));
  // the stiffer end, which the softer one follows
  CHECK_FALSE(is_stiff(Solver(Hanging(5e5F, 5e3F, 5e-4F, 0).scene, vertex_options())));
  CHECK_FALSE(is_stiff(Solver(Hanging(5e3F, 5e5F, 5e-4F, 0).scene, vertex_options())));
  CHECK_FALSE(
      is_stiff(Solver(Hanging(5e3F, 5e3F, 0, 0).scene, testing::small_steps())));  // projections
}

// Would catch springs that are too stiff for it: these bodies fell, as far as their sweeps were
// few.
TEST_CASE("stiff link: between stiff and soft tissue a spring serves as well", "[validation]") {
  const bool is_stiff_above = GENERATE(true, false);
  const float dt = GENERATE(1e-3F, 5e-3F);
  const auto sag_of = [&](float compliance) {
    const Hanging hanging(is_stiff_above ? 5e5F : 5e3F, is_stiff_above ? 5e3F : 5e5F, compliance,
                          0);
    Solver solver(hanging.scene, vertex_options(1, 10, 20));
    CHECK(is_stiff(solver) == (compliance == 0));
    run(solver, static_cast<int>(1 / dt), dt);
    return Hanging::sag(solver);
  };
  CHECK(sag_of(5e-4F) == Approx(sag_of(0)).epsilon(0.02));
}

// The tension of a thread is what hangs below: the tool that holds it feels it all.
TEST_CASE("stiff link: a chain keeps its length and carries its weight", "[validation]") {
  constexpr Index kCount = 12;
  const double spacing = 2e-3, mass = 1e-3;
  Scene scene;
  std::vector<Eigen::Vector3d> positions;
  for (Index i = 0; i < kCount; ++i) {
    positions.emplace_back(0, 0, -spacing * i);
  }
  scene.add_particles("chain", positions, mass);
  for (Index i = 0; i + 1 < kCount; ++i) {
    scene.add_link({i, i + 1, static_cast<float>(spacing), {1, 0}});
  }
  scene.set_gravity({0, 0, -9.81F});
  const bool is_fixed = GENERATE(true, false);
  if (is_fixed) {
    scene.fix_vertices(0, std::vector<Index>{0});
  }
  Solver solver(scene, vertex_options(4, 10, 20));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  if (!is_fixed) {
    solver.grasp(tool, std::vector<Index>{0});
  }
  run(solver, 400, 2e-3F);
  CHECK(solver.positions()[kCount - 1].z() == Approx(-spacing * (kCount - 1)).epsilon(1e-3));
  if (!is_fixed) {
    CHECK(solver.tool_force(tool).z() == Approx(-kCount * mass * 9.81).epsilon(0.01));
  }
}

// Would catch forces of a link that are not opposite: nothing but gravity moves the centre.
TEST_CASE("stiff link: two free bodies fall as one", "[validation]") {
  Scene scene;
  scene.add_body("a", block_at(0), neo_hookean(2e4F, 0.4F));
  scene.add_body("b", block_at(-1.2 * kSide), neo_hookean(5e3F, 0.3F));
  const Index count = scene.body(0).vertex_count;
  for (Index v = 0; v < 5; ++v) {
    scene.add_link({v, 2 * count - 1 - v, 0, {1, 0}});  // far apart: they are pulled together
  }
  scene.set_gravity({0, 0, -9.81F});
  Solver solver(scene, vertex_options(1, 10));
  const auto center = [&] {
    const auto masses = solver.tissue().masses();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double mass = 0;
    for (std::size_t v = 0; v < masses.size(); ++v) {
      sum += masses[v] * solver.positions()[v].cast<double>();
      mass += masses[v];
    }
    return Eigen::Vector3d(sum / mass);
  };
  const Eigen::Vector3d before = center();
  run(solver, 100, 1e-3F);
  const Eigen::Vector3d fallen = center() - before;
  CHECK(fallen.z() == Approx(-9.81 * 1e-6 * 100 * 101 / 2).epsilon(0.02));
  CHECK(fallen.head<2>().norm() < 0.02 * std::abs(fallen.z()));
}

// Would catch a link that turns its whole force at once: a slanted thread under tension burst.
TEST_CASE("stiff link: a slanted thread with a weight swings down and hangs", "[validation]") {
  const float dt = GENERATE(5e-3F, 16e-3F);
  const double weight = GENERATE(1e-3, 0.1);
  constexpr Index kCount = 20;
  Scene scene;
  std::vector<Eigen::Vector3d> positions;
  for (Index i = 0; i < kCount; ++i) {
    positions.emplace_back(1e-4 * i, 0, -2e-3 * i);
  }
  scene.add_particles("thread", positions, 1e-3);
  scene.add_particles("weight", std::vector<Eigen::Vector3d>{{1e-4 * kCount, 0, -2e-3 * kCount}},
                      weight);
  const auto length = static_cast<float>(std::hypot(2e-3, 1e-4));
  for (Index i = 0; i < kCount; ++i) {
    scene.add_link({i, i + 1, length, {1, 0}});
  }
  scene.fix_vertices(0, std::vector<Index>{0});
  scene.set_gravity({0, 0, -9.81F});
  Solver solver(scene, vertex_options(1, 10, 20));
  run(solver, static_cast<int>(3 / dt), dt);
  for (const Eigen::Vector3f& x : solver.positions()) {
    CHECK(x.head<2>().norm() < 1e-4F);
    CHECK(x.z() > -1.0F);  // ten sweeps of a long step let it stretch
  }
}

// Would catch vertices that go beyond their least energy, which a link does not count on.
TEST_CASE("stiff link: over-relaxed sweeps come to the same rest", "[validation]") {
  const Hanging hanging(5e3F, 5e3F, GENERATE(0.0F, 1e-4F), GENERATE(0.0F, 2e-3F));
  Solver plain(hanging.scene, vertex_options(1, 10, 20));
  SolverOptions options = vertex_options(1, 10, 20);
  options.over_relaxation = GENERATE(1.5F, 1.7F);
  Solver relaxed(hanging.scene, options);
  run(plain, 200);
  run(relaxed, 200);
  CHECK(Hanging::sag(relaxed) == Approx(Hanging::sag(plain)).epsilon(0.005));
}

// A whole face drawn to a corner: no rest is asked for, but numbers.
TEST_CASE("stiff link: many links at one vertex do not burst", "[validation]") {
  Scene scene;
  scene.add_body("upper", block_at(0), neo_hookean(5e3F, 0.3F));
  scene.add_body("lower", block_at(-1.1 * kSide), neo_hookean(5e3F, 0.3F));
  const Index count = scene.body(0).vertex_count;
  for (Index v = 0; v < 8; ++v) {
    scene.add_link({0, count + 2 * v + 1, 0, {1, 0}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() > kSide - 0.5 * kLinkedEdge; });
  scene.set_gravity({0, 0, -9.81F});
  Solver solver(scene, vertex_options(1, 10, 10));
  run(solver, 400);
  for (const Eigen::Vector3f& velocity : solver.velocities()) {
    CHECK(velocity.norm() < 1);
  }
}

TEST_CASE("stiff link: who is lost takes nobody along", "[unit]") {
  Scene scene;
  scene.add_body("block", block_at(0), neo_hookean(5e3F, 0.3F));
  scene.add_particles("clip", std::vector<Eigen::Vector3d>{scene.positions()[0]}, 1e-4);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() > kSide - 0.5 * kLinkedEdge; });
  const Index clip = scene.vertex_count() - 1;
  scene.add_link({0, clip, 0, {1, 0}});
  Solver solver(scene, vertex_options(1, 10, 20));
  REQUIRE(is_stiff(solver));
  std::vector<Eigen::Vector3f> positions = solver.positions();
  positions[clip].setConstant(GENERATE(1e7F, 1e12F, 1e18F));
  solver.write_positions(positions);
  run(solver, 20);
  CHECK((solver.positions()[0] - scene.positions()[0].cast<float>()).norm() < 0.2 * kSide);
}

// Would catch a coarse correction that takes the force of such a link for one that whole bodies
// must follow: two strips of liver with one stiff thread between them shook, and threads over a
// whole face tore them apart; and links of an edit, of which the substeps hear nothing.
TEST_CASE("stiff link: stitches between soft bodies come to rest by default", "[validation]") {
  const float compliance = GENERATE(0.0F, 2e-4F);
  const std::size_t stitches = GENERATE(1, 25);
  const bool comes_later = GENERATE(false, true);
  Hanging hanging(5e3F, 5e3F, compliance, 4e-3F);
  REQUIRE(hanging.links.size() == 25);
  Scene bare;
  bare.set_gravity(hanging.scene.gravity());
  for (const Body& body : hanging.scene.bodies()) {
    bare.add_body(body.name, block_at(body.name == "upper" ? 0 : -kSide - 4e-3), body.material);
  }
  for (Index b = 0; b < 2;
       ++b) {  // held at both ends, so that a stitch alone bears next to nothing
    bare.fix_where(b, [](const Eigen::Vector3d& x) {
      return x.z() > kSide - 0.5 * kLinkedEdge || x.z() < -kSide - 4e-3 + 0.5 * kLinkedEdge;
    });
  }
  TopologyEdit edit;
  for (std::size_t i = 0; i < stitches; ++i) {
    edit.new_links.push_back(hanging.scene.links()[i == 0 ? 12 : (12 + i) % 25]);
  }
  if (!comes_later) {
    for (const Link& link : edit.new_links) {
      bare.add_link(link);
    }
  }
  Solver solver(bare, {.damping = 20});
  REQUIRE(solver.options().coarse_correction == CoarseCorrection::on);
  if (comes_later) {
    const std::string before = solver.plan().name;
    solver.tissue().apply(edit);
    CHECK(solver.plan().name != before);  // which says how many sweeps there are
  }
  REQUIRE(is_stiff(solver));
  run(solver, 200);
  const auto x = solver.positions();
  const auto v = solver.velocities();
  for (const Link& link : solver.tissue().links()) {
    CHECK((x[link.first] - x[link.second]).norm() == Approx(4e-3).epsilon(0.05));
    CHECK(v[link.first].norm() < 1e-3);
  }
}

// Would catch a compaction that asks anew what is stiff, of tissue that has lost mass since.
TEST_CASE("stiff link: a compaction keeps what is stiff and what is not", "[unit]") {
  const Hanging hanging(5e3F, 5e3F, 5e-3F, 0);
  Solver solver(hanging.scene, vertex_options(1, 10, 20));
  REQUIRE_FALSE(is_stiff(solver));
  TopologyEdit edit;  // all but a tetrahedron at each linked vertex
  std::vector<bool> is_kept(hanging.scene.positions().size());
  for (Index t = 0; t < static_cast<Index>(hanging.scene.tets().size()); ++t) {
    bool has_new = false;
    for (const Index v : hanging.scene.tets()[t]) {
      const bool is_linked = std::abs(hanging.scene.positions()[v].z()) < 0.5 * kLinkedEdge;
      has_new = has_new || (is_linked && !is_kept[v]);
      is_kept[v] = is_kept[v] || is_linked;
    }
    if (!has_new) {
      edit.remove_tets.push_back(t);
    }
  }
  solver.tissue().apply(edit);
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  CHECK_FALSE(is_stiff(solver));
  const auto links = solver.tissue().links();
  solver.tissue().apply({.new_links = {links.begin(), links.end()}});  // as tissue is now, some are
  CHECK(is_stiff(solver));
}

TEST_CASE("stiff link: edits cut, bring back and add links", "[unit]") {
  const Hanging hanging(5e3F, 5e3F, 0, 0);
  Solver solver(hanging.scene, vertex_options(1, 10, 20));
  Solver other(hanging.scene, vertex_options(1, 10, 20));
  run(solver, 50);
  run(other, 50);
  const double held = Hanging::sag(solver);

  solver.tissue().apply({.remove_links = hanging.links});
  CHECK_FALSE(is_stiff(solver));
  solver.tissue().undo();
  run(solver, 20);
  run(other, 20);
  CHECK(solver.state_hash() == other.state_hash());

  solver.tissue().apply({.remove_links = hanging.links});
  run(solver, 20);
  CHECK(Hanging::sag(solver) > held + 0.2 * kSide);

  const auto from = solver.positions();
  TopologyEdit edit;
  for (const Index link : hanging.links) {
    const Link& old = hanging.scene.links()[link];
    const float length = (from[old.first] - from[old.second]).norm();
    edit.new_links.push_back({old.first, old.second, length, {1, 0}});
  }
  const double before = Hanging::sag(solver);
  solver.tissue().apply(edit);
  CHECK(is_stiff(solver));
  run(solver, 200);
  CHECK(Hanging::sag(solver) < before + 0.3 * kSide);
}

}  // namespace pbdsurg
