// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/version.h"
#include "pbdsurg/surgery/cut.h"

#include "lib/base/checksum.h"
#include "lib/world/world_bytes.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::check_refused;
using testing::ContainsSubstring;
using testing::kDt;
using testing::read_bytes;
using testing::same;
using testing::SlabWorld;
using testing::TemporaryFolder;

void check_same(SlabWorld& slabs, World& other) {
  World& world = slabs.world;
  CHECK(same(world.tissue().masses(), other.tissue().masses()));
  REQUIRE(same(world.tissue().tets(), other.tissue().tets()));
  for (Index t = 0; t < static_cast<Index>(other.tissue().tets().size()); ++t) {
    REQUIRE(world.tissue().is_tet_alive(t) == other.tissue().is_tet_alive(t));
  }
  const HeatField& heat = world.cautery(slabs.burner).field();
  const HeatField& others = other.cautery(slabs.burner).field();
  CHECK(same(heat.temperatures(), others.temperatures()));
  CHECK(same(heat.water(), others.water()));
  CHECK(same(heat.collagen(), others.collagen()));
  CHECK(heat.ledger().in == others.ledger().in);
  CHECK(heat.ledger().removed == others.ledger().removed);
  CHECK(world.strands().whole_count() == other.strands().whole_count());
  REQUIRE(world.strands().events().size() == other.strands().events().size());
  for (std::size_t i = 0; i < other.strands().events().size(); ++i) {
    CHECK(world.strands().events()[i].link == other.strands().events()[i].link);
    CHECK(world.strands().events()[i].cause == other.strands().events()[i].cause);
  }
  CHECK(slabs.hash() == other.solver().state_hash());
  CHECK(world.force(slabs.grasper) == other.force(slabs.grasper));
}

// A cut, a burn, strands that part, tissue that comes and goes, jaws that hold.
void operate(SlabWorld& slabs) {
  World& world = slabs.world;
  world.step(kDt);
  world.edit(plan_cut(world.solver(), testing::cut_at(5e-3F, -0.01F, 5e-3F)).edit);
  REQUIRE(world.step(kDt).ok());
  const BodyId clip = world.add_body("clip", testing::slab(0.05, {1, 1, 1}), tissues::fat());
  REQUIRE(world.step(kDt).ok());
  REQUIRE(world.grasp_near(slabs.grasper, slabs.upper, 5e-3F, 1e-4F).size() > 4);
  slabs.burn();
  Index removed = 0;
  for (int step = 0; step < 60; ++step) {
    world.move(slabs.grasper, at({6e-3F, 6e-3F, 11e-3F + 5e-5F * static_cast<float>(step)}));
    removed += world.step(kDt).removed_tets;
  }
  world.remove_body(clip);
  world.step(kDt);
  REQUIRE(removed > 2);
  REQUIRE(world.strands().events().size() > 0);
}

World read_written(const World& world, const Executor& executor = {}) {
  const TemporaryFolder folder;
  write_world(folder / "a.world", world.save());
  return read_world(folder / "a.world", executor);
}

// Pulls, and burns on, in both.
void go_on(SlabWorld& slabs, World& other, int steps) {
  for (int step = 0; step < steps; ++step) {
    const float way = 1e-4F * static_cast<float>(step);
    for (World* each : {&slabs.world, &other}) {
      each->move(slabs.grasper, at({6e-3F, 6e-3F, 14e-3F + way}));
      each->move(slabs.hook, at(testing::kTop + Eigen::Vector3f(way, way / 2, -way)));
      each->step(kDt);
    }
    REQUIRE(slabs.hash() == other.solver().state_hash());
  }
}

}  // namespace

// Would catch all that a file forgets: shape, speed, heat, strands, what jaws hold, plan and
// colours of edited tissue, the past of a substep.
TEST_CASE("world file: a world goes on as the one that was saved, to the bit", "[property]") {
  const SolverOptions blocks{.method = SolverMethod::vertex_block, .damping = 20};
  SolverOptions bdf2 = blocks;
  bdf2.integration = TimeIntegration::bdf2;
  const SolverOptions projection{.method = SolverMethod::projection, .damping = 20};
  SolverOptions roomy = projection;
  roomy.spare = {.vertices = 20, .tets = 60, .edges = 90, .links = 10};
  SolverOptions serial = blocks;
  serial.executor = executor::serial();
  for (const SolverOptions& options : {blocks, bdf2, projection, roomy, serial}) {
    SlabWorld slabs(options);
    slabs.world.record();
    operate(slabs);
    slabs.world.energise(slabs.burner, off_settings());
    slabs.world.step(kDt);
    World other = read_written(slabs.world, options.executor);
    check_same(slabs, other);
    go_on(slabs, other, 40);
    check_same(slabs, other);
    // again, of the one that was read, and recorded anew
    other.record();
    World third = read_written(other, options.executor);
    go_on(slabs, third, 10);
    check_same(slabs, third);
  }
}

// Would catch a burn that starts from another potential or with other conductivities, where
// nothing stops it before the file is written.
TEST_CASE("world file: a burn goes on, to the bit", "[property]") {
  SlabWorld slabs;
  slabs.world.record();
  operate(slabs);
  slabs.world.record();
  World other = read_written(slabs.world);
  check_same(slabs, other);
  const auto tets = static_cast<Index>(slabs.world.tissue().tets().size());
  const auto count_dead = [&] {
    Index dead = 0;
    for (Index t = 0; t < tets; ++t) {
      dead += slabs.world.tissue().is_tet_alive(t) ? 0 : 1;
    }
    return dead;
  };
  const Index before = count_dead();
  go_on(slabs, other, 40);
  CHECK(count_dead() > before);
  check_same(slabs, other);
}

// Would catch bits that depend on who steps.
TEST_CASE("world file: another executor goes on with the same bits, in strict mode", "[property]") {
  SlabWorld slabs({.method = SolverMethod::vertex_block,
                   .damping = 20,
                   .executor = executor::serial(),
                   .math = MathMode::strict});
  slabs.world.record();
  operate(slabs);
  slabs.world.energise(slabs.burner, off_settings());
  World other = read_written(slabs.world, executor::threads(2));
  CHECK(std::string(other.solver().backend_name()).starts_with("threaded, 2 threads"));
  go_on(slabs, other, 20);
  check_same(slabs, other);
}

// Would catch replicas that share one state, and reports that are lost.
TEST_CASE("world file: has all replicas", "[unit]") {
  SlabWorld slabs({.damping = 20, .copies = 3});
  slabs.world.record();
  const std::vector<Index> some = slabs.world.tissue().vertices_of(1);
  slabs.world.replica(ReplicaId(2)).grasp(slabs.grasper, {some.data(), 3});
  slabs.world.replica(ReplicaId(2)).move(slabs.grasper, at({6e-3F, 6e-3F, 12e-3F}));
  slabs.world.solver().watch(std::span(some).first(2));
  slabs.world.step(kDt);
  World other = read_written(slabs.world);
  CHECK(same(slabs.world.solver().watched_positions(2), other.solver().watched_positions(2)));
  CHECK(slabs.world.solver().last_report(1).substeps == other.solver().last_report(1).substeps);
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

// Would catch a file without forces or gravity, one that has those of the scene, and replicas that
// get those of another.
TEST_CASE("world file: has forces of all replicas, and gravity of all bodies", "[property]") {
  for (const SolverMethod method : {SolverMethod::vertex_block, SolverMethod::projection}) {
    SlabWorld slabs({.method = method, .damping = 20, .copies = 2});
    World& world = slabs.world;
    world.record();
    const std::array<Index, 2> vertices{90, 200};
    const std::array<Eigen::Vector3f, 2> forces{{{0, 1e-4F, 0}, {1e-4F, 0, 2e-4F}}};
    world.replica(ReplicaId(1)).set_forces(vertices, forces);
    world.set_gravity({0.5F, 0, 0});
    const auto check_goes_on = [&](World& other) {
      for (const Index body : {0, 1}) {
        CHECK(other.solver().gravity(body) == world.solver().gravity(body));
      }
      for (int step = 0; step < 10; ++step) {
        world.step(kDt);
        other.step(kDt);
        for (const Index copy : {0, 1}) {
          REQUIRE(other.solver().forces(copy) == world.solver().forces(copy));
          REQUIRE(other.solver().state_hash(copy) == world.solver().state_hash(copy));
        }
      }
    };
    world.step(kDt);
    World first = read_written(world);
    CHECK(first.solver().gravity(1) == Eigen::Vector3f(0.5F, 0, 0));
    CHECK(first.solver().forces(0).empty());
    CHECK(first.solver().forces(1)[200] == forces[1]);
    check_goes_on(first);

    // with vertices and a body that came, and gravities of bodies
    world.set_forces(slabs.upper,
                     [](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f { return 1e-3F * x; });
    world.set_gravity(slabs.upper, {0, 0, -3});
    world.edit(plan_cut(world.solver(), testing::cut_at(5e-3F, -0.01F, 5e-3F)).edit);
    const BodyId clip = world.add_body("clip", testing::slab(0.05, {1, 1, 1}), tissues::fat());
    REQUIRE(world.step(kDt).ok());
    const Index clip_in_tissue = world.body_in_tissue(clip);
    world.set_gravity(clip, {0, 2, 0});
    World second = read_written(world);
    CHECK(second.solver().gravity(1) == Eigen::Vector3f(0, 0, -3));
    CHECK(second.solver().gravity(clip_in_tissue) == Eigen::Vector3f(0, 2, 0));
    check_goes_on(second);
    CHECK(world.solver().state_hash(0) != world.solver().state_hash(1));
    // again, of the one that was read, without forces
    second.clear_forces();
    world.clear_forces();
    World third = read_written(second);
    CHECK(third.solver().forces(0).empty());
    CHECK_FALSE(third.solver().forces(1).empty());
    check_goes_on(third);
  }
}

// Would catch a file or a saved world that forgets what jaws hold with a limit, how far that slid,
// or which of them do not push; grips of one replica in another; and a torn one that is open.
TEST_CASE("world file: has grips of all replicas", "[property]") {
  for (const SolverMethod method : {SolverMethod::vertex_block, SolverMethod::projection}) {
    SlabWorld slabs({.method = method, .damping = 20, .copies = 2});
    World& world = slabs.world;
    world.record();
    const Grip grip{.pad = {.half_length = 8e-3F, .half_width = 8e-3F}, .clamp_force = 4e-3F};
    REQUIRE(world.grasp_between(slabs.grasper, slabs.upper, 12e-3F, grip) > 20);
    REQUIRE(world.grip(slabs.grasper).state == GripState::holding);
    const ToolId second = world.add_tool({}, at({6e-3F, 6e-3F, 1e-3F}));
    std::vector<TissuePoint> points;
    for (const GraspedPoint& held : world.grip(slabs.grasper).points) {
      points.push_back(held.point);
    }
    Grip weak = grip;
    weak.tear_strength = 1e-4F;
    world.replica(ReplicaId(1)).move(second, at({6e-3F, 6e-3F, 9e-3F}));
    world.step(kDt);
    world.replica(ReplicaId(1)).grasp(second, points, weak);
    const auto step_both = [&](World* other, int step) {
      const ToolPose pose = at({6e-3F + 2e-4F * static_cast<float>(step), 6e-3F, 11e-3F});
      for (World* each : {&world, other}) {
        if (each != nullptr) {
          each->move(slabs.grasper, pose);
          each->replica(ReplicaId(1)).move(second, pose);
          each->step(kDt);
        }
      }
    };
    for (int step = 0; step < 20; ++step) {
      step_both(nullptr, step);
    }
    REQUIRE(world.grip(slabs.grasper).state == GripState::slipping);
    REQUIRE(world.replica(ReplicaId(1)).grip(second).state == GripState::torn);
    World other = read_written(world);
    CHECK(other.replica(ReplicaId(1)).grip(second).torn_vertices ==
          world.replica(ReplicaId(1)).grip(second).torn_vertices);
    CHECK(other.grip(second).state == GripState::open);
    for (int step = 20; step < 30; ++step) {
      step_both(&other, step);
      for (const Index copy : {0, 1}) {
        REQUIRE(other.solver().state_hash(copy) == world.solver().state_hash(copy));
      }
      const GripReport here = world.grip(slabs.grasper), there = other.grip(slabs.grasper);
      CHECK(here.state == there.state);
      CHECK(here.pull == there.pull);
      CHECK(here.points.size() == there.points.size());
    }
    world.set_clamp_force(slabs.grasper, 0);
    step_both(nullptr, 30);
    CHECK(world.grip(slabs.grasper).pull.norm() < 5e-5F);
  }
}

// Would catch a file, or a saved world, that has these as the scene had them; and edits of one step
// of which one is lost.
TEST_CASE("world file: has what is fixed, how stiff tissue is, its fibres, factors and links",
          "[property]") {
  World world(SolverOptions{.damping = 20, .copies = 2});
  const BodyId body = world.add_body("body", testing::slab(0, {4, 4, 2}), tissues::liver());
  world.fix(body, {0, 1, 2});
  world.set_stiffnesses(body, [](const Eigen::Vector3d& x) { return x.x() > 0 ? 3.0F : 1.0F; });
  world.set_fibres(body, [](const Eigen::Vector3d& x) {
    return Fibre{{0.6F, 0.8F, 0}, x.y() > 0 ? 5e3F : 0};
  });
  const CopyFactors heavy{.stiffness = 0.5F, .density = 1.5F, .gravity = 0.25F};
  world.record();
  world.replica(ReplicaId(1)).set_factors(heavy);
  world.step(kDt);
  const std::span<const Tet> tets = world.tissue().tets();
  const auto stiff = std::ranges::find_if(
      tets, [&](const Tet& t) { return world.tissue().stiffness(&t - tets.data()) == 3; });
  REQUIRE(stiff != tets.end());
  const auto tet = static_cast<Index>(stiff - tets.begin());
  world.edit({.new_links = {{0, world.tissue().vertex_count() - 1, 0.02F, {1, 1e-2F}}}});
  REQUIRE(world.step(kDt).ok());
  const Fibre across{{0, 0, 1}, 2e3F};
  world.edit({.stiffnesses = {{tet, 2}}, .fibres = {{tet, across}}, .fix_vertices = {9, 10}});
  world.edit({.link_lengths = {{0, 0.015F}}, .fix_vertices = {10, 11}, .unfix_vertices = {1}});
  REQUIRE(world.step(kDt).ok());
  World read = read_written(world), saved(world.save());
  for (World* each : {&world, &read, &saved}) {
    const Tissue& tissue = each->tissue();
    CHECK(tissue.links()[0].rest_length == 0.015F);
    CHECK(tissue.stiffness(tet) == 2);
    CHECK(tissue.fibre(tet).direction == across.direction);
    CHECK(tissue.fibre(tet).stiffness == across.stiffness);
    CHECK(each->replica(ReplicaId(0)).factors() == CopyFactors{});
    CHECK(each->replica(ReplicaId(1)).factors() == heavy);
    const auto fibred = std::ranges::count_if(tissue.tets_of(body), [&](Index t) {
      return tissue.fibre(t).stiffness == 5e3F && tissue.fibre(t).direction.y() == 0.8F;
    });
    CHECK(fibred > 10);
    CHECK(std::ranges::equal(
        std::array{tissue.is_fixed(0), tissue.is_fixed(1), tissue.is_fixed(9), tissue.is_fixed(10),
                   tissue.is_fixed(11), tissue.is_fixed(12)},
        std::array{true, false, true, true, true, false}));
  }
  for (int step = 0; step < 10; ++step) {
    world.step(kDt);
    for (World* each : {&read, &saved}) {
      each->step(kDt);
      REQUIRE(each->solver().state_hash() == world.solver().state_hash());
      REQUIRE(each->solver().state_hash(1) == world.solver().state_hash(1));
    }
  }
}

// Would catch edits that a later recording forgets, and devices that come too early or too late.
TEST_CASE("world file: has all edits, however often the world was recorded", "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.record();
  operate(slabs);
  world.energise(slabs.burner, off_settings());
  world.record();
  CHECK(world.save().edit_count() == 0);
  const BodyId late = world.add_body("late", testing::slab(0.08, {2, 2, 2}), tissues::fat());
  REQUIRE(world.step(kDt).ok());
  const CauteryId second = world.add_cautery(slabs.grasper, {late});
  world.edit({.remove_tets = {world.tissue().tets_of(world.body_in_tissue(late)).back()}});
  REQUIRE(world.step(kDt).ok());
  World other = read_written(world);
  CHECK(other.save().edit_count() > world.save().edit_count());
  CHECK(other.find_body("late") == late);
  CHECK(same(world.cautery(second).field().temperatures(),
             other.cautery(second).field().temperatures()));
  check_same(slabs, other);
  go_on(slabs, other, 10);
  check_same(slabs, other);
}

struct SmallFile {
  SmallFile() {
    World world(SolverOptions{.damping = 20});
    const BodyId body = world.add_body("body", testing::slab(0, {1, 1, 1}), tissues::fat());
    const ToolId tool = world.add_tool({Capsule{.radius = 1e-3F}}, at({0, 0, 0.1F}));
    world.grasp(tool, std::vector<Index>{0, 1});
    world.add_cautery(tool, {body});
    world.record();
    world.step(kDt);
    world.edit({.remove_tets = {0}});
    world.set_forces(std::array<Index, 1>{3}, std::array{Eigen::Vector3f(1e-5F, 0, 0)});
    world.set_gravity(body, {0, 0, -9.81F});
    world.step(kDt);
    const TemporaryFolder folder;
    write_world(folder / "a.world", world.save());
    bytes = read_bytes(folder / "a.world");
  }

  std::string bytes;
};

[[nodiscard]] World world_of(const std::string& bytes) {
  return world_of_bytes({"a.world", bytes, 0});
}

// The checksum is made that of the bytes.
[[nodiscard]] std::string with_checksum(std::string bytes) {
  std::uint64_t sum = checksum(std::string_view(bytes).substr(0, bytes.size() - 8));
  for (std::size_t i = bytes.size() - 8; i < bytes.size(); ++i, sum >>= 8) {
    bytes[i] = static_cast<char>(sum & 0xFF);
  }
  return bytes;
}

// Would catch bytes that nothing guards.
TEST_CASE("world file: refuses every byte that was changed, and every end that was cut off",
          "[property]") {
  const std::string bytes = SmallFile().bytes;
  CHECK_NOTHROW(world_of(bytes));
  std::size_t refused = 0;
  const auto refuse = [&](const std::string& changed) {
    try {
      static_cast<void>(world_of(changed));
    } catch (const FileError&) {
      ++refused;
    }
  };
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ (1 << (i % 8)));
    refuse(changed);
    refuse(bytes.substr(0, i));
  }
  refuse(bytes + '\0');
  CHECK(refused == 2 * bytes.size() + 1);
}

// Would catch a file of another version or build that is read all the same, and a message that
// does not say what is wrong and where.
TEST_CASE("world file: says what it refuses", "[unit]") {
  const std::string bytes = SmallFile().bytes;
  const auto check_says = [](const std::string& changed, const std::string& what) {
    CHECK_THROWS_WITH(world_of(changed),
                      ContainsSubstring("a.world: byte ") && ContainsSubstring(what));
  };
  check_says("solid", "does not begin as a world does");
  std::string other = bytes;
  other[8] = 1;
  check_says(other, "version 1 of the format");
  check_says(bytes.substr(0, 100), "it must be whole");
  other = bytes;
  other[200] ^= 1;
  check_says(other, "the file was changed");
  other = bytes;
  other[other.find(build_id()) + 2] ^= 1;
  check_says(with_checksum(other), "only on the build that wrote it");
  other = bytes;
  other[other.find("scene")] = 'S';
  check_says(with_checksum(other), "has a section 'Scene'; it must be 'scene'");
  other = bytes;
  other[other.find("scene") + 5] ^= 1;  // its size
  CHECK_THROWS_AS(world_of(with_checksum(other)), FileError);
  other = bytes;
  other.replace(other.find("scene") + 13, 8, 8, '\xFF');  // how many bodies
  check_says(with_checksum(other), "bytes cannot hold so many");
  other = bytes;
  other.replace(other.size() - 12, 4, 4, '\xFF');  // gravity of the body, the last number
  check_says(with_checksum(other), "it must be finite");
}

// Would catch ids, counts and numbers that crash a world, where the checksum is right.
// Not under an address sanitizer, which ends a program that asks for more memory than there is.
TEST_CASE("world file: a forged file is refused or makes a world that steps", "[property][long]") {
  const std::string bytes = SmallFile().bytes;
  const std::size_t begin = bytes.find("options");
  std::size_t refused = 0, made = 0;
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    std::string forged = bytes;
    const std::size_t at = begin + random_bits(1, trial) % (bytes.size() - 8 - begin);
    const std::uint64_t kind = random_bits(2, trial) % 3;
    if (kind == 0) {
      forged[at] = static_cast<char>(random_bits(3, trial));
    } else if (kind == 1) {
      forged[at] ^= static_cast<char>(1 << (random_bits(3, trial) % 8));
    } else {
      forged.replace(at, std::min<std::size_t>(4, bytes.size() - 8 - at), "\xFF\xFF\xFF\x7F", 0,
                     std::min<std::size_t>(4, bytes.size() - 8 - at));
    }
    CAPTURE(trial, at, kind);
    try {
      World world = world_of(with_checksum(forged));
      ++made;
      const SolverOptions& options = world.solver().options();
      if (options.substeps < 100 && options.iterations < 100 &&
          options.longest_step > kDt / 100) {  // others are as good, and slow
        static_cast<void>(world.step(kDt));
        world.compact();
        static_cast<void>(world.step(kDt));
      }
    } catch (const FileError&) {
      ++refused;
    } catch (const InvalidArgument&) {  // of the step
    }
  }
  CHECK(refused > 300);
  CHECK(made > 300);
}

// Would catch a sum of numbers that overflows, and whatever else than a FileError leaves a file.
// Not under an address sanitizer, as above.
TEST_CASE("world file: refuses more spare room than there can be", "[unit][long]") {
  const Index odd = 123457, most = std::numeric_limits<Index>::max();  // a number of no other use
  World world(SolverOptions{.damping = 20, .spare = {.vertices = 1, .links = odd}});
  world.add_body("body", testing::slab(0, {1, 1, 1}), tissues::fat());
  world.record();
  world.step(kDt);
  const TemporaryFolder folder;
  write_world(folder / "a.world", world.save());
  std::string bytes = read_bytes(folder / "a.world");
  CHECK_NOTHROW(world_of(bytes));
  const std::string from(reinterpret_cast<const char*>(&odd), sizeof odd);
  const std::size_t place = bytes.find(from);
  REQUIRE(place != std::string::npos);
  bytes.replace(place, sizeof most, reinterpret_cast<const char*>(&most), sizeof most);
  CHECK_THROWS_AS(world_of(with_checksum(bytes)), FileError);
}

// Would catch a file that is not of the scene that it says.
TEST_CASE("world file: refuses states whose scene is not known", "[unit]") {
  const TemporaryFolder folder;
  check_refused([&] { write_world(folder / "a", WorldState{}); }, "of no world");
  SlabWorld slabs;
  slabs.world.step(kDt);
  slabs.world.edit({.remove_tets = {0}});
  slabs.world.step(kDt);
  slabs.world.record();
  check_refused([&] { write_world(folder / "a", slabs.world.save()); }, "after an edit");
  SlabWorld compacted;
  compacted.world.record();
  compacted.world.compact();
  compacted.world.record();
  check_refused([&] { write_world(folder / "a", compacted.world.save()); }, "a compaction");
  CHECK_FALSE(std::filesystem::exists(folder / "a"));
  CHECK_THROWS_WITH(read_world(folder / "a"), ContainsSubstring("no such file"));
}

}  // namespace pbdsurg
