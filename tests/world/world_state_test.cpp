// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/world/world.h"

#include "examples/tether/tethers.h"
#include "lib/world/edit_journal.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::check_refused;
using testing::kDt;
using testing::same;
using testing::SlabWorld;

void check_same_topology(const Tissue& a, const Tissue& b) {
  REQUIRE(a.vertex_count() == b.vertex_count());
  CHECK(same(a.masses(), b.masses()));
  REQUIRE(same(a.tets(), b.tets()));
  REQUIRE(a.links().size() == b.links().size());
  for (Index t = 0; t < static_cast<Index>(a.tets().size()); ++t) {
    REQUIRE(a.is_tet_alive(t) == b.is_tet_alive(t));
  }
  for (Index l = 0; l < static_cast<Index>(a.links().size()); ++l) {
    REQUIRE(a.is_link_alive(l) == b.is_link_alive(l));
  }
}

void check_same_heat(const HeatField& a, const HeatField& b) {
  CHECK(same(a.temperatures(), b.temperatures()));
  CHECK(same(a.peak_temperatures(), b.peak_temperatures()));
  CHECK(same(a.water(), b.water()));
  CHECK(same(a.survival(), b.survival()));
  CHECK(same(a.collagen(), b.collagen()));
  CHECK(same(a.charred(), b.charred()));
  CHECK(same(a.active_vertices(), b.active_vertices()));
  CHECK(a.ledger().in == b.ledger().in);
  CHECK(a.ledger().removed == b.ledger().removed);
}

void check_same_events(const ConnectiveTissue& a, const ConnectiveTissue& b) {
  CHECK(a.whole_count() == b.whole_count());
  REQUIRE(a.events().size() == b.events().size());
  for (std::size_t i = 0; i < a.events().size(); ++i) {
    CHECK(a.events()[i].link == b.events()[i].link);
    CHECK(a.events()[i].cause == b.events()[i].cause);
  }
}

void check_same_world(SlabWorld& slabs, World& other) {
  check_same_topology(slabs.world.tissue(), other.tissue());
  CHECK(slabs.world.tissue().version() == other.tissue().version());
  check_same_heat(slabs.world.cautery(slabs.burner).field(), other.cautery(slabs.burner).field());
  check_same_events(slabs.world.strands(), other.strands());
  CHECK(slabs.hash() == other.solver().state_hash());
  CHECK(slabs.world.force(slabs.grasper) == other.force(slabs.grasper));
}

// Burns while the grasper pulls, until tissue and strands have gone, and some steps more.
void burn_and_pull(SlabWorld& slabs) {
  World& world = slabs.world;
  REQUIRE(world.grasp_near(slabs.grasper, slabs.upper, 5e-3F, 1e-4F).size() > 4);
  slabs.burn();
  Index removed = 0;
  for (int step = 0; step < 60; ++step) {
    world.move(slabs.grasper, at({6e-3F, 6e-3F, 11e-3F + 5e-5F * static_cast<float>(step)}));
    removed += world.step(kDt).removed_tets;
  }
  REQUIRE(removed > 2);
  REQUIRE(world.strands().events().size() > 0);
}

}  // namespace

// Would catch a set that a saved world takes along by half, or one that a loaded world cannot have.
TEST_CASE("world state: a program adds its own constraints again and goes on with the same bits",
          "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const Index v = world.tissue().vertex_count() - 1;
  const std::vector<Tether> wanted{
      {.vertex = v, .point = {0, 0, 0.03F}, .length = 0.01F, .compliance = 0.5F}};
  const auto tethers = std::make_shared<Tethers>(wanted);
  world.add_constraints(tethers);
  world.record();
  world.step(kDt);
  CHECK(tethers->tension(0) > 0);
  const WorldState state = world.save();
  World loaded(state);
  World without(state);
  loaded.add_constraints(std::make_shared<Tethers>(wanted));
  for (World* const each : {&world, &loaded, &without}) {
    each->step(kDt);
    each->step(kDt);
  }
  CHECK(loaded.solver().state_hash() == world.solver().state_hash());
  CHECK(without.solver().state_hash() != world.solver().state_hash());
  world.compact();
  CHECK(world.step(kDt).ok());
  CHECK(tethers->tension(0) > 0);
}

// Would catch anything that a state forgets: constraints, shrunk tissue, heat, doses of links, what
// tools hold, speed, forces, or the settings of a generator.
TEST_CASE("world state: a world goes on as the one that was saved, to the bit", "[property]") {
  const SolverOptions blocks{.method = SolverMethod::vertex_block, .damping = 20};
  SolverOptions bdf2 = blocks;
  bdf2.integration = TimeIntegration::bdf2;
  const SolverOptions projection{.method = SolverMethod::projection, .damping = 20};
  SolverOptions roomy = projection;
  roomy.spare = {.vertices = 20, .tets = 60, .edges = 90, .links = 10};
  for (const SolverOptions& options : {blocks, bdf2, projection, roomy}) {
    SlabWorld slabs(options);
    World& world = slabs.world;
    world.record();
    burn_and_pull(slabs);
    world.energise(slabs.burner, off_settings());
    world.step(kDt);
    const WorldState state = world.save();
    World other(state);
    check_same_world(slabs, other);
    Index removed = 0;
    for (int step = 0; step < 40; ++step) {
      for (World* each : {&world, &other}) {
        each->move(slabs.grasper, at({6e-3F, 6e-3F, 14e-3F + 1e-4F * static_cast<float>(step)}));
        removed += each->step(kDt).removed_links;
      }
      REQUIRE(slabs.hash() == other.solver().state_hash());
    }
    CHECK(removed > 0);
    check_same_world(slabs, other);
    // a beginning anew, on tissue that was edited
    world.record();
    World rebased(world.save());
    for (int step = 0; step < 10; ++step) {
      world.step(kDt);
      rebased.step(kDt);
    }
    check_same_world(slabs, rebased);
    // the same moment again, though the world went on; and from a world that was made of it
    World again(state);
    World third(again.save());
    for (int step = 0; step < 40; ++step) {
      third.move(slabs.grasper, at({6e-3F, 6e-3F, 14e-3F + 1e-4F * static_cast<float>(step)}));
      third.step(kDt);
    }
    for (int step = 0; step < 10; ++step) {
      third.step(kDt);
    }
    check_same_world(slabs, third);
  }
}

// Would catch a state without forces or gravity, one that has those of the beginning, and a copy
// that gets another's.
TEST_CASE("world state: forces and gravity go along, of each replica its own", "[property]") {
  for (const SolverMethod method : {SolverMethod::vertex_block, SolverMethod::projection}) {
    SlabWorld slabs(SolverOptions{.method = method, .damping = 20, .copies = 2});
    World& world = slabs.world;
    const std::array<Index, 2> vertices{90, 200};
    const std::array<Eigen::Vector3f, 2> forces{{{0, 1e-4F, 0}, {1e-4F, 0, 2e-4F}}};
    world.replica(ReplicaId(1)).set_forces(vertices, forces);
    world.record();
    world.set_forces(slabs.upper,
                     [](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f { return 1e-3F * x; });
    world.set_gravity(slabs.upper, {0, 0, -3});
    world.edit({.remove_tets = {world.tissue().tets_of(0).back()}});
    world.step(kDt);
    World other(world.save());
    CHECK(other.solver().gravity(0) == Eigen::Vector3f(0, 0, 0));
    CHECK(other.solver().gravity(1) == Eigen::Vector3f(0, 0, -3));
    CHECK(other.solver().forces(0) == world.solver().forces(0));
    CHECK(other.solver().forces(1)[200] == forces[1]);
    for (int step = 0; step < 10; ++step) {
      for (World* each : {&world, &other}) {
        each->step(kDt);
      }
      for (const Index copy : {0, 1}) {
        REQUIRE(world.solver().state_hash(copy) == other.solver().state_hash(copy));
      }
    }
    CHECK(world.solver().state_hash(0) != world.solver().state_hash(1));
  }
}

// Would catch a step that begins with the velocities of another moment.
TEST_CASE("world state: explicit steps go on to the bit, too", "[unit]") {
  TissueRecord fat = tissues::fat();
  fat.mechanics.damping = 0;
  World world({.method = SolverMethod::explicit_steps, .damping = 20});
  const BodyId body = world.add_body("body", testing::slab(0), fat);
  world.fix(body, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * testing::kEdge; });
  world.record();
  world.step(kDt);
  world.edit({.remove_tets = {world.tissue().tets_of(0).back()}});
  world.step(kDt);
  World other(world.save());
  for (int step = 0; step < 20; ++step) {
    world.step(kDt);
    other.step(kDt);
    REQUIRE(world.solver().state_hash() == other.solver().state_hash());
  }
}

// Would catch a burn that a state stops, or that begins with other tissue, energy or generator.
TEST_CASE("world state: current goes on, too, to the tolerance of its potential", "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.record();
  burn_and_pull(slabs);
  World other(world.save());
  Index removed = 0, others = 0;
  for (int step = 0; step < 40; ++step) {
    const float way = 5e-5F * static_cast<float>(step);
    for (World* each : {&world, &other}) {
      each->move(slabs.hook, at(testing::kTop + Eigen::Vector3f(way, way, -way)));
    }
    removed += world.step(kDt).removed_tets;
    others += other.step(kDt).removed_tets;
  }
  CAPTURE(removed, others);
  CHECK(removed > 15);
  CHECK(std::abs(removed - others) <= 2);
  const double energy = world.cautery(slabs.burner).field().ledger().in;
  CHECK(other.cautery(slabs.burner).field().ledger().in == testing::Approx(energy).epsilon(2e-2));
}

// Would catch edits that are done in another order, or not at all, and ids that differ.
TEST_CASE("world state: takes part in edits of all kinds, and not in those undone", "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.step(kDt);
  world.record();
  world.edit(plan_cut(world.solver(), testing::cut_at(5e-3F, -0.01F, 5e-3F)).edit);
  world.step(kDt);
  const BodyId clip = world.add_body("clip", testing::slab(0.05, {1, 1, 1}), tissues::artery());
  world.remove_body(slabs.upper);
  world.step(kDt);
  world.edit({.remove_tets = {world.tissue().tets_of(0).front()}});
  world.step(kDt);
  world.undo();
  const ToolId blade = world.add_tool({}, at({0, 0, 0.06F}));
  const CauteryId second = world.add_cautery(blade, {clip});
  slabs.burn();
  for (int step = 0; step < 30; ++step) {
    world.step(kDt);
  }
  world.energise(slabs.burner, off_settings());
  const BodyId waits = world.add_body("waits", testing::slab(0.1, {1, 1, 1}), tissues::fat());
  World other(world.save());
  check_same_topology(world.tissue(), other.tissue());
  CHECK(other.find_body("clip") == clip);
  CHECK(other.cautery(second).field().mesh().tets().size() == world.tissue().tets().size());
  check_refused([&] { (void)other.body_in_tissue(waits); }, "not there any more");
  const Surface& mine = world.surface(slabs.lower);
  const Surface& others = other.surface(slabs.lower);
  CHECK(same(mine.triangles(), others.triangles()));
  CHECK(same(mine.vertices(), others.vertices()));
  CHECK(same(mine.marks(), others.marks()));
  CHECK(std::ranges::any_of(mine.marks(), [](const BurnBytes& m) { return m != BurnBytes{}; }));
  const std::size_t bodies = world.tissue().bodies().size();
  other.step(kDt);
  CHECK(other.tissue().bodies().size() == bodies);  // nothing came that waited
}

// Would catch burners that heat another body than theirs, or one that has gone.
TEST_CASE("world state: burners keep their bodies over removals and compactions", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.record();
  burn_and_pull(slabs);
  world.energise(slabs.burner, off_settings());
  world.remove_body(slabs.lower);
  world.step(kDt);
  const auto go_on = [&] {
    World other(world.save());
    for (int step = 0; step < 10; ++step) {
      world.step(kDt);
      other.step(kDt);
    }
    check_same_heat(world.cautery(slabs.burner).field(), other.cautery(slabs.burner).field());
    CHECK(slabs.hash() == other.solver().state_hash());
    CHECK(other.body_in_tissue(slabs.upper) == world.body_in_tissue(slabs.upper));
    check_refused([&] { (void)other.body_in_tissue(slabs.lower); }, "not there any more");
    const Index tet = world.tissue().tets_of(world.body_in_tissue(slabs.upper)).back();
    CHECK(other.cautery(slabs.burner).field().mesh().is_alive(tet));
  };
  go_on();
  world.record();
  go_on();
  world.compact();
  world.record();
  REQUIRE(world.body_in_tissue(slabs.upper) == 0);
  go_on();
}

// Would catch heat of another tissue, or of none, where the removed body was still warm when the
// recording began anew.
TEST_CASE("world state: heat goes on to the bit where a warm body has gone", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  slabs.burn();
  for (int step = 0; step < 30; ++step) {
    world.step(kDt);
  }
  world.move(slabs.hook, at({6e-3F, 6e-3F, 11.2e-3F}));
  world.step(kDt);
  slabs.burn(8);
  for (int step = 0; step < 6; ++step) {
    world.step(kDt);
  }
  world.energise(slabs.burner, off_settings());
  const HeatField& field = world.cautery(slabs.burner).field();
  for (const BodyId body : {slabs.upper, slabs.lower}) {
    const Tissue& tissue = world.tissue();
    const Index in_tissue = world.body_in_tissue(body);
    const auto is_of_body = [&](Index v) { return tissue.body_of_vertex(v) == in_tissue; };
    world.remove_body(body);
    world.step(kDt);
    CAPTURE(body.value);
    if (body == slabs.upper) {
      REQUIRE(std::ranges::any_of(field.active_vertices(), is_of_body));
    }
    world.record();
    World other(world.save());
    const HeatField& others = other.cautery(slabs.burner).field();
    for (const Index v : others.active_vertices()) {
      REQUIRE(others.mesh().tissue_of_vertex(v) != kInvalidIndex);
    }
    for (int step = 0; step < 5; ++step) {
      world.step(kDt);
      other.step(kDt);
      check_same_heat(field, others);
    }
    CHECK(slabs.hash() == other.solver().state_hash());
    other.energise(slabs.burner, cut_settings(20));
    CHECK(other.step(kDt).ok());
  }
}

// Would catch room that grows with each state that a world is made of, and room that is lost.
TEST_CASE("world state: worlds have the spare room that was asked for", "[unit]") {
  const SpareRoom spare{.vertices = 2000, .tets = 6000, .edges = 9000, .links = 100};
  for (const SolverMethod method : {SolverMethod::vertex_block, SolverMethod::projection}) {
    SlabWorld slabs({.method = method, .damping = 20, .spare = spare});
    const auto bytes = static_cast<double>(slabs.world.solver().memory_bytes());
    const auto tissue_bytes = static_cast<double>(slabs.world.tissue().memory_bytes());
    const std::uint64_t hash = slabs.hash();
    World world = std::move(slabs.world);
    for (int i = 0; i < 5; ++i) {
      world.record();
      world = World(world.save());
      CHECK(static_cast<double>(world.solver().memory_bytes()) ==
            testing::Approx(bytes).epsilon(0.1));
      CHECK(static_cast<double>(world.tissue().memory_bytes()) ==
            testing::Approx(tissue_bytes).epsilon(0.1));
    }
    CHECK(world.solver().state_hash() == hash);
  }
}

// Would catch replicas that share one state.
TEST_CASE("world state: has all replicas", "[unit]") {
  SlabWorld slabs({.damping = 20, .copies = 3});
  slabs.world.record();
  slabs.world.replica(ReplicaId(1)).move(slabs.grasper, at({6e-3F, 6e-3F, 20e-3F}));
  const std::vector<Index> some = slabs.world.tissue().vertices_of(1);
  slabs.world.replica(ReplicaId(2)).grasp(slabs.grasper, {some.data(), 3});
  slabs.world.replica(ReplicaId(2)).move(slabs.grasper, at({6e-3F, 6e-3F, 12e-3F}));
  slabs.world.step(kDt);
  World other(slabs.world.save());
  for (int step = 0; step < 5; ++step) {
    slabs.world.step(kDt);
    other.step(kDt);
  }
  for (Index i = 0; i < 3; ++i) {
    CHECK(other.replica(ReplicaId(i)).state_hash() ==
          slabs.world.replica(ReplicaId(i)).state_hash());
  }
  CHECK(other.replica(ReplicaId(0)).state_hash() != other.replica(ReplicaId(2)).state_hash());
}

// Would catch a state of ids that mean nothing any more, and sizes that nobody can rely on.
TEST_CASE("world state: refuses what it cannot be", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  check_refused([&] { (void)world.save(); }, "from record() on");
  check_refused([] { World(WorldState{}); }, "of no world");
  CHECK(WorldState{}.memory_bytes() == 0);
  CHECK(WorldState{}.shared_bytes() == 0);
  CHECK(WorldState{}.edit_count() == 0);
  world.record();
  const std::size_t tissue_bytes = world.tissue().memory_bytes();
  const std::size_t solver_bytes = world.solver().memory_bytes();
  slabs.burn();
  for (int step = 0; step < 40; ++step) {
    world.step(kDt);
  }
  const WorldState before = world.save();
  const std::uint64_t before_compaction = world.tissue().version();
  REQUIRE(before_compaction > 2);
  // as documented
  const double expected = (40.0 + 48.0) * world.tissue().vertex_count() +
                          8.0 * static_cast<double>(world.tissue().links().size()) +
                          16.0 * static_cast<double>(before.edit_count());
  CHECK(static_cast<double>(before.memory_bytes()) == testing::Approx(expected).epsilon(0.1));
  CHECK(before.shared_bytes() > tissue_bytes);
  CHECK(before.shared_bytes() < tissue_bytes + solver_bytes);
  world.compact();
  check_refused([&] { (void)world.save(); }, "compaction");
  world.record();
  CHECK(before.edit_count() == before_compaction);
  CHECK(world.save().edit_count() == 0);
  World other(world.save());
  CHECK(other.tissue().tets().size() == world.tissue().tets().size());
  CHECK(other.solver().state_hash() == slabs.hash());
  World earlier(before);  // stays of use
  CHECK(earlier.tissue().tets().size() > other.tissue().tets().size());
}

// Would catch an edit that brings a body and is counted without it.
TEST_CASE("world state: edits count with the bodies that they bring", "[unit]") {
  SlabWorld slabs;
  slabs.world.record();
  const std::size_t before = slabs.world.save().shared_bytes();
  const TetMesh mesh = testing::slab(0.05);
  slabs.world.add_body("clip", mesh, tissues::artery());
  slabs.world.step(kDt);
  const WorldState state = slabs.world.save();
  REQUIRE(state.edit_count() == 1);
  CHECK(state.shared_bytes() - before > mesh.positions().size_bytes() + mesh.tets().size_bytes());
}

// Would catch what worlds change of a state that others read.
TEST_CASE("world state: several threads make worlds of one", "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.record();
  burn_and_pull(slabs);
  world.energise(slabs.burner, off_settings());
  const WorldState state = world.save();
  std::vector<std::uint64_t> hashes(4);
  std::vector<std::thread> threads;
  for (std::uint64_t& hash : hashes) {
    threads.emplace_back([&hash, &state] {
      World other(state);
      for (int step = 0; step < 5; ++step) {
        other.step(kDt);
      }
      hash = other.solver().state_hash();
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (int step = 0; step < 5; ++step) {
    world.step(kDt);
  }
  CHECK(std::ranges::count(hashes, slabs.hash()) == 4);
}

// Would catch energy that heat has spent on tissue that is there again.
TEST_CASE("world state: an undo after a restore gives energy back", "[unit]") {
  SlabWorld slabs;
  const Cautery& cautery = slabs.world.cautery(slabs.burner);
  slabs.burn();
  double before = 0;
  Index removed = 0;
  for (int step = 0; step < 60 && removed == 0; ++step) {
    before = cautery.removal_energy();
    removed = slabs.world.step(kDt).removed_tets;
  }
  REQUIRE(removed > 0);
  REQUIRE(cautery.removal_energy() > before);
  slabs.world.cautery(slabs.burner).restore(cautery.snapshot());
  slabs.world.undo();
  CHECK(cautery.removal_energy() == before);
}

// Would catch memory that grows with edits that no state can take part in.
TEST_CASE("world state: no edits are kept after a compaction", "[unit]") {
  SlabWorld slabs;
  Tissue& tissue = slabs.world.tissue();
  EditJournal journal;
  tissue.add_follower(journal);
  tissue.apply({.remove_tets = {3}});
  CHECK(journal.edits().size() == 1);
  tissue.undo();
  CHECK(journal.edits().empty());
  tissue.apply({.remove_tets = {3}});
  slabs.world.compact();
  CHECK(journal.was_renumbered());
  tissue.apply({.remove_tets = {3}});
  CHECK(journal.edits().empty());
  tissue.undo();
  CHECK(journal.edits().empty());
}

// Would catch a cautery that goes back by half.
TEST_CASE("world state: heat refuses snapshots that are of no field", "[unit]") {
  SlabWorld slabs;
  slabs.world.record();
  burn_and_pull(slabs);
  Cautery& cautery = slabs.world.cautery(slabs.burner);
  const CauterySnapshot good = cautery.snapshot();
  const auto refused = [&](auto spoil, const char* what) {
    CauterySnapshot bad = good;
    spoil(bad);
    check_refused([&] { cautery.restore(bad); }, what);
    const CauterySnapshot now = cautery.snapshot();
    CHECK(now.heat.temperatures == good.heat.temperatures);
    CHECK(now.link_doses == good.link_doses);
    CHECK(now.electrode_energy == good.electrode_energy);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused([](CauterySnapshot& s) { s.heat.water.pop_back(); }, "values of water");
  refused([](CauterySnapshot& s) { s.heat.temperatures[3] = kNan; }, "temperature of vertex 3");
  refused([](CauterySnapshot& s) { s.heat.survival[2] = 1.5; }, "must be in [0, 1]");
  refused([](CauterySnapshot& s) { s.heat.charred[2] = -1; }, "char of vertex 2");
  refused([](CauterySnapshot& s) { s.heat.held = {-1}; }, "vertex -1");
  refused([](CauterySnapshot& s) { s.heat.active = {4, 4}; }, "vertex 4 is twice");
  const std::vector<Index> of_strands = slabs.world.tissue().vertices_of(
      static_cast<Index>(slabs.world.tissue().bodies().size()) - 1);
  refused([&](CauterySnapshot& s) { s.heat.active = {of_strands.front()}; },
          "no tissue of the field is or was at it");
  refused([](CauterySnapshot& s) { s.heat.pending = {1 << 30}; }, "there is no vertex");
  refused([](CauterySnapshot& s) { s.link_doses.push_back(0); }, "links");
  refused([](CauterySnapshot& s) { s.link_doses[1] = -1; }, "the dose of link 1");
  refused([](CauterySnapshot& s) { s.due = {{1 << 30, false}}; }, "there is no tet");
  refused([](CauterySnapshot& s) { s.due = {{5, false}, {4, true}}; }, "must ascend");
  refused([](CauterySnapshot& s) { s.removal_energy = -1; }, "removal_energy");
  refused([](CauterySnapshot& s) { s.electrode_temperature = kNan; }, "electrode_temperature");
  // and the good one takes back what came since
  slabs.world.energise(slabs.burner, off_settings());
  const std::uint64_t version = slabs.world.tissue().version();
  slabs.world.step(kDt);
  REQUIRE(slabs.world.tissue().version() == version);
  cautery.restore(good);
  CHECK(cautery.field().ledger().in == good.heat.ledger.in);
  CHECK(cautery.snapshot().heat.temperatures == good.heat.temperatures);
  // not where tissue has gone since, or where there is other tissue
  refused([](CauterySnapshot& s) { s.heat.tissue = {}; }, "of another tissue");
  const HeatField& field = cautery.field();
  Index hottest = kInvalidIndex;
  for (const Index v : field.active_vertices()) {
    if (field.mesh().has_tissue(v) &&
        (hottest == kInvalidIndex || field.temperatures()[v] > field.temperatures()[hottest])) {
      hottest = v;
    }
  }
  REQUIRE(hottest != kInvalidIndex);
  std::vector<Index> tets;
  field.mesh().for_each_element(hottest, [&](Index t) { tets.push_back(t); });
  slabs.world.tissue().apply({.remove_tets = tets});
  const CauterySnapshot after = cautery.snapshot();
  check_refused([&] { cautery.restore(good); }, "the snapshot is of topology version");
  CHECK(cautery.snapshot().heat.temperatures == after.heat.temperatures);
  CHECK(field.ledger().removed == after.heat.ledger.removed);
}

}  // namespace pbdsurg
