// SPDX-License-Identifier: Apache-2.0
// What a device does in a sweep with a lumen, done by a team of one on the host.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/device/filling_lists.h"
#include "lib/device/filling_sweep.h"
#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/stiff_links.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/lumen_cases.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::cuda {
namespace {

using pbdsurg::testing::ContainsSubstring;
using pbdsurg::testing::inspect;
using pbdsurg::testing::LumenSolver;

struct TeamOfOne {
  template <class Visit>
  void for_each(Index count, const Visit& visit) const {
    for (Index i = count; i-- > 0;) {  // no order is told
      visit(i);
    }
  }
  template <class Number>
  [[nodiscard]] Number sum(Number start, const Number* values, Index count) const {
    for (Index i = 0; i < count; ++i) {
      start = start + values[i];
    }
    return start;
  }
  template <class T>
  [[nodiscard]] T load(const T* from) const {
    return *from;
  }
  void store(Particle* to, const Vec3<float>& x, float w) const { *to = {x.x, x.y, x.z, w}; }
  void store(FixedPoint* to, const FixedPoint& point) const { *to = point; }
  void meet() const {}
  [[nodiscard]] bool is_leader() const { return true; }
};

/// A filling of one copy as a device has it.
struct Room {
  Room(const SolverData& data, const Filling& filling, float h)
      : lists(filling.surface(), data.place_of_vertex),
        input{filling.law(), h},
        copy{filling.state(0), {}, filling.is_new(0), false},
        ties(find_ties({{lists.places}}, data.free_pieces, data.particles.size())),
        is_of_blocks(moves_vertices(data.options)),
        ways(lists.places.size()),
        caps(lists.triangles.size()),
        volumes(lists.triangles.size()),
        thirds(lists.triangles.size()),
        gradients(lists.places.size()),
        gives(lists.places.size()) {}

  [[nodiscard]] FillingArrays arrays() {
    return {lists.places.data(),
            lists.triangles.data(),
            lists.firsts.data(),
            lists.triangles_at.data(),
            lists.hole_ends.data(),
            &input,
            &copy,
            &result,
            ways.data(),
            caps.data(),
            volumes.data(),
            thirds.data(),
            gradients.data(),
            gives.data(),
            is_of_blocks ? ties[0].is_shared.data() : nullptr,
            is_of_blocks ? ties[0].pieces.data() : nullptr,
            static_cast<Index>(lists.places.size()),
            static_cast<Index>(lists.triangles.size()),
            lists.wall_count,
            static_cast<Index>(lists.hole_ends.size()),
            static_cast<Index>(ties[0].pieces.size()),
            ties[0].is_anchored,
            true};
  }

  FillingLists lists;
  FillingInput input;
  FillingCopy copy;
  std::vector<WallTies> ties;
  bool is_of_blocks;
  FillingState result;
  std::vector<Vec3<double>> ways, caps;
  std::vector<double> volumes;
  std::vector<Vec3<float>> thirds, gradients;
  std::vector<float> gives;
};

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// What pushes of vertex blocks change.
struct BlockState {
  std::vector<Particle> moving, flights, end_ways;
  std::vector<FixedPoint> points;

  explicit BlockState(const StepScratch& scratch)
      : moving(scratch.displacements),
        flights(scratch.flights),
        end_ways(scratch.end_ways),
        points(scratch.fixed_points) {}

  [[nodiscard]] bool same_bits_as(const BlockState& other) const {
    return same_bits(moving, other.moving) && same_bits(flights, other.flights) &&
           same_bits(end_ways, other.end_ways) && same_bits(points, other.points);
  }
};

}  // namespace

// Would catch a device that measures a lumen, makes out what flows, or pushes its wall otherwise
// than a CPU does, at first, in the sweeps after it, in later substeps, and once there are holes.
TEST_CASE("cuda fillings: a team projects a lumen with the bits of a solver on a CPU",
          "[equivalence]") {
  const bool is_gas = GENERATE(true, false);
  const bool is_pricked = GENERATE(false, true);
  INFO("gas " << is_gas << ", pricked " << is_pricked);
  LumenSolver ball(pbdsurg::testing::ball_scene(),
                   {.method = SolverMethod::projection, .substeps = 2, .iterations = 3},
                   is_gas ? LumenOptions{} : pbdsurg::testing::kWater);
  ball.lumen->set_reservoir(1e-5F, 300);
  ball.lumen->set_leak(1e-7F);
  ball.lumen->set_inflow(1e-7F);
  ball.run(2);
  if (is_pricked) {
    ball.solver.tissue().apply(pbdsurg::testing::puncture(ball.solver.tissue(), 1));
  }
  SolverData& data = inspect(ball.solver);
  constexpr float kStep = 2e-3F, kSubstep = kStep / 2;  // s
  const Substep<float> lengths{1 / kSubstep, 1 / (kSubstep * kSubstep)};
  data.part = whole_step(kStep, {2, 3});
  data.step_scratch.fit(data);
  data.custom.begin_step(data);
  const StepContext step{data, data, data.step_scratch};
  Filling& filling = *ball.lumen->filling();
  REQUIRE(filling.is_new(0) == is_pricked);
  REQUIRE((filling.surface().hole_ends.size() > 0) == is_pricked);
  Room room(data, filling, data.part.h);
  std::vector<Particle>& moving = data.step_scratch.displacements;
  for (int substep = 0; substep < 3; ++substep) {
    for (std::size_t place = 0; place < data.particles.size(); ++place) {
      const Particle& p = data.particles[place];
      const float share = (place % 3 == 0 ? 0.02F : -0.01F) * static_cast<float>(1 + substep);
      moving[place] = {share * p.y, share * p.z, 0.05F * p.x, p.w};
    }
    for (int sweep = 0; sweep < 3; ++sweep) {
      INFO("substep " << substep << ", sweep " << sweep);
      std::vector<Particle> own = moving;
      project_custom(step, 0, lengths, sweep);
      project_filling(
          TeamOfOne{}, room.arrays(),
          FreeVertices{data.particles.data(), own.data(), 1 / lengths.inverse_dt_squared},
          sweep == 0);
      REQUIRE_FALSE(data.custom.has_failed(0));
      REQUIRE(same_bits(own, moving));
      const LumenState expected = ball.lumen->state();
      REQUIRE(room.result.amount == expected.amount);
      REQUIRE(room.result.pressure == expected.pressure);
      REQUIRE(expected.pressure != 0);
    }
  }
  filling.take(0, {2e-5, 7});
  CHECK(ball.lumen->state().amount == 2e-5);
  CHECK(ball.lumen->pressure() == 7);
  CHECK_FALSE(filling.is_new(0));
}

// Would catch likewise with vertex blocks: forces with which sweeps begin, yields of tissue, loads,
// points, guards, gradients for the coarse correction, pieces that a wall joins.
TEST_CASE("cuda fillings: a team projects a lumen with the bits of vertex blocks on a CPU",
          "[equivalence]") {
  const bool is_free = GENERATE(true, false);
  INFO("free " << is_free);
  Scene scene = pbdsurg::testing::ball_scene();
  if (!is_free) {
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -0.015; });
  }
  LumenSolver ball(scene, {.method = SolverMethod::vertex_block, .substeps = 2, .iterations = 3},
                   {});
  ball.lumen->set_reservoir(1e-5F, 300);
  ball.run(2);
  SolverData& data = inspect(ball.solver);
  StepScratch& scratch = data.step_scratch;
  constexpr float kStep = 2e-3F, kSubstep = kStep / 2;  // s
  const Substep<float> lengths{1 / kSubstep, 1 / (kSubstep * kSubstep)};
  data.part = whole_step(kStep, {2, 3});
  scratch.fit(data);
  data.custom.begin_step(data);
  const StepContext step{data, data, scratch};
  gather_holds(step);
  Room room(data, *ball.lumen->filling(), data.part.h);
  std::vector<Index> lane_of_place, groups(static_cast<std::size_t>(data.free_pieces.count()));
  for (Index place = 0; place < static_cast<Index>(data.particles.size()); ++place) {
    const auto [block, lane] = data.vertex_blocks.place_of(place);
    lane_of_place.push_back(block == kInvalidIndex ? block : block * kBlockLanes + lane);
  }
  std::vector<float> guards(static_cast<std::size_t>(kBlockLanes) * scratch.guards.size());
  for (int substep = 0; substep < 2; ++substep) {
    for (std::size_t place = 0; place < data.particles.size(); ++place) {
      const Particle& p = data.particles[place];
      const float share = (place % 3 == 0 ? 2e-3F : -1e-3F) * static_cast<float>(1 + substep);
      const Particle way{share * p.y, share * p.z, 5e-3F * p.x, p.w};
      scratch.displacements[place] = way;
      scratch.flights[place] = {way.y, way.z, way.x, kToLeastEnergy};
      scratch.fixed_points[place] = fixed_point(load(p), load(way), data.vertex_blocks.unit());
    }
    const VertexState state = vertex_state(step, lengths, 1);
    for (Index block = 0; block < data.vertex_blocks.block_count(); ++block) {
      find_loose_ends(step, state, block, scratch.linked[block]);
    }
    find_lone_ends(step, state);
    scratch.pushed.begin();
    scratch.coarse.wide.clear();
    for (int sweep = -1; sweep < 3; ++sweep) {
      INFO("substep " << substep << ", sweep " << sweep);
      BlockState own(scratch);
      std::vector<Particle> gives = scratch.end_gives, shears = scratch.end_shears;
      project_custom(step, 0, lengths, sweep);
      const auto project = [&](auto vertices) {
        vertices.bases = data.particles.data();
        vertices.moving = own.moving.data();
        vertices.square_of_dt = 1 / lengths.inverse_dt_squared;
        vertices.ends = {own.end_ways.data(), gives.data(), shears.data()};
        vertices.flights = own.flights.data();
        vertices.points = own.points.data();
        vertices.lane_of_place = lane_of_place.data();
        vertices.guards = guards.data();
        vertices.groups = groups.data();
        vertices.group_count = static_cast<Index>(groups.size());
        vertices.inverse_dt_squared = lengths.inverse_dt_squared;
        project_filling(TeamOfOne{}, room.arrays(), vertices, sweep < 0);
      };
      if (sweep < 0) {
        project(HeldVertices<true>{});
      } else {
        project(HeldVertices<false>{});
      }
      REQUIRE_FALSE(data.custom.has_failed(0));
      REQUIRE(own.same_bits_as(BlockState(scratch)));
      REQUIRE(room.result.pressure == ball.lumen->state().pressure);
      REQUIRE(room.result.pressure != 0);
      for (const Index place : room.lists.places) {
        const auto [block, lane] = data.vertex_blocks.place_of(place);
        const float expected =
            block == kInvalidIndex ? 0.0F : scratch.guards[block].stiffness[lane];
        const float guard = block == kInvalidIndex ? 0.0F : guards[lane_of_place[place]];
        REQUIRE(guard == expected);
      }
      if (sweep == 0) {
        const auto corners = scratch.coarse.wide.corners(0);
        REQUIRE(scratch.coarse.wide.compliance(0) == room.copy.compliance);
        REQUIRE(corners.size() == room.gradients.size());
        for (std::size_t i = 0; i < corners.size(); ++i) {
          REQUIRE(corners[i].place == room.lists.places[i]);
          const Vec3<float>& here = corners[i].gradient;
          const Vec3<float>& there = room.gradients[i];
          REQUIRE((here.x == there.x && here.y == there.y && here.z == there.z));
        }
      }
      for (Index piece = 0; piece < data.free_pieces.count(); ++piece) {
        bool moves = false;
        scratch.pushed.for_each_with(piece, [&](Index) { moves = true; });
        REQUIRE((groups[piece] == piece) == moves);
      }
    }
  }
  CHECK(groups.size() == (is_free ? 1 : 0));
}

// Would catch vertices that count as shared with a later wall, with one that is gone or not with
// both, and pieces that are listed twice or for what is no wall's.
TEST_CASE("cuda fillings: ties of walls", "[unit]") {
  struct Pieces : PieceLists {
    Pieces() {
      firsts_ = {0, 2, 4};
      places_ = {1, 2, 5, 6};
    }
  };
  const std::vector<Index> first{1, 2, 5}, gone, other{2, 5, 6, 7}, last{0, 7};
  const std::vector<std::span<const Index>> walls{first, gone, other, last};
  const std::vector<WallTies> ties = find_ties(walls, Pieces(), 8);
  REQUIRE(ties.size() == 4);
  CHECK(ties[0].is_shared == std::vector<Index>{0, 0, 0});
  CHECK(ties[0].pieces == std::vector<Index>{0, 1});
  CHECK_FALSE(ties[0].is_anchored);
  CHECK(ties[1].is_shared.empty());
  CHECK(ties[1].pieces.empty());
  CHECK(ties[2].is_shared == std::vector<Index>{1, 1, 0, 0});
  CHECK(ties[2].pieces == std::vector<Index>{0, 1});
  CHECK(ties[2].is_anchored);
  CHECK(ties[3].is_shared == std::vector<Index>{0, 1});
  CHECK(ties[3].pieces.empty());
  CHECK(ties[3].is_anchored);
}

// Would catch pieces that stay apart though a wall has them both, or one that is anchored and goes
// on alone.
TEST_CASE("cuda fillings: walls join free pieces, and anchor them", "[unit]") {
  const auto group = GENERATE(
      table<std::vector<Index>, bool, std::vector<Index>>({{{1, 3}, false, {0, 1, 2, 1, 4}},
                                                           {{1, 3}, true, {0, -1, 2, -1, 4}},
                                                           {{}, true, {0, 1, 2, 3, 4}}}));
  const auto& [pieces, is_anchored, expected] = group;
  std::vector<Index> groups(5);
  HeldVertices<true> vertices{};
  vertices.groups = groups.data();
  vertices.group_count = 5;
  vertices.begin(TeamOfOne{});
  FillingArrays filling{};
  filling.pieces = pieces.data();
  filling.piece_count = static_cast<Index>(pieces.size());
  filling.is_anchored = is_anchored;
  vertices.join(TeamOfOne{}, filling);
  CHECK(groups == expected);
  // another one, whose pieces go along with those of the first
  const std::vector<Index> others{0, 3};
  filling.pieces = others.data();
  filling.piece_count = 2;
  filling.is_anchored = false;
  vertices.join(TeamOfOne{}, filling);
  const bool is_one = pieces.size() == 2;
  CHECK(groups[0] == (!is_one ? 0 : is_anchored ? -1 : 0));
  CHECK(groups[1] == (!is_one ? 1 : groups[0]));
  CHECK(groups[3] == groups[0]);
  CHECK(groups[2] == 2);
}

// Would catch what is undefined where there is nothing to push: no wall, a lost vertex.
TEST_CASE("cuda fillings: a lost vertex or a wall that is gone leaves the rest in place",
          "[unit]") {
  LumenSolver ball(pbdsurg::testing::ball_scene(),
                   {.method = SolverMethod::projection, .substeps = 1, .iterations = 1}, {});
  ball.lumen->set_reservoir(1e-5F, 300);
  ball.run(1);
  const bool is_lost = GENERATE(true, false);
  if (!is_lost) {
    TopologyEdit all;
    for (Index t = 0; t < static_cast<Index>(ball.solver.tissue().tets().size()); ++t) {
      all.remove_tets.push_back(t);
    }
    ball.solver.tissue().apply(all);
  }
  SolverData& data = inspect(ball.solver);
  data.custom.begin_step(data);
  Room room(data, *ball.lumen->filling(), 1e-3F);
  std::vector<Particle> moving(data.particles.size());
  for (std::size_t place = 0; place < moving.size(); ++place) {
    moving[place] = {0, 0, 0, data.particles[place].w};
  }
  if (is_lost) {
    moving[static_cast<std::size_t>(room.lists.places[5])].x = NAN;
  }
  const std::vector<Particle> before = moving;
  project_filling(TeamOfOne{}, room.arrays(),
                  FreeVertices{data.particles.data(), moving.data(), 1e-6F}, true);
  CHECK(same_bits(moving, before));
  CHECK(std::isfinite(room.result.amount));
  CHECK((room.result.amount > 0) == is_lost);
}

// Would catch a device that takes a lumen in silence, and steps without it.
TEST_CASE("cuda fillings: a device that projects none refuses a lumen", "[unit]") {
  Solver solver(pbdsurg::testing::ball_scene(),
                pbdsurg::testing::small_steps({.executor = pbdsurg::testing::fake_device()}));
  const auto lumen =
      std::make_shared<Lumen>(solver.tissue(), find_cavities(solver.tissue(), 0).at(0));
  CHECK_THROWS_AS(solver.add_constraints(lumen), BackendUnavailable);
  CHECK_THROWS_WITH(solver.add_constraints(lumen),
                    ContainsSubstring("'lumen' needs a CPU, or compliance mode"));
}

}  // namespace pbdsurg::cuda
