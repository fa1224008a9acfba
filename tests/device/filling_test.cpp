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
#include "lib/solver/methods/vertex_motion.h"
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
  void meet() const {}
  [[nodiscard]] bool is_leader() const { return true; }
};

/// A filling of one copy as a device has it.
struct Room {
  Room(const SolverData& data, const Filling& filling, float h)
      : lists(filling.surface(), data.place_of_vertex),
        input{filling.law(), h},
        copy{filling.state(0), {}, filling.is_new(0)},
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
            static_cast<Index>(lists.places.size()),
            static_cast<Index>(lists.triangles.size()),
            lists.wall_count,
            static_cast<Index>(lists.hole_ends.size())};
  }

  FillingLists lists;
  FillingInput input;
  FillingCopy copy;
  FillingState result;
  std::vector<Vec3<double>> ways, caps;
  std::vector<double> volumes;
  std::vector<Vec3<float>> thirds, gradients;
  std::vector<float> gives;
};

bool same_bits(const std::vector<Particle>& a, const std::vector<Particle>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Particle)) == 0;
}

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
      project_filling(TeamOfOne{}, room.arrays(), {data.particles.data(), own.data()},
                      lengths.inverse_dt_squared, sweep == 0);
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
  project_filling(TeamOfOne{}, room.arrays(), {data.particles.data(), moving.data()}, 1e6F, true);
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
                    ContainsSubstring("'lumen' needs a CPU, or projections in compliance mode"));
}

}  // namespace pbdsurg::cuda
