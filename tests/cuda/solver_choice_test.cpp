// SPDX-License-Identifier: Apache-2.0
// The device and the strategy that a solver was asked for.
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/small_steps.h"
#include "tests/support/spring_block.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::make_spring_block;

constexpr float kTimeStep = testing::kEventfulTimeStep;

}  // namespace

TEST_CASE("cuda solver: what it is and what it holds", "[device]") {
  SolverOptions options = pbdsurg::testing::small_steps({.executor = cuda::best()});
  Solver chosen(make_spring_block(), options);
  CHECK_THAT(chosen.backend_name(), ContainsSubstring("cuda") && ContainsSubstring("fast"));
  options.executor = executor::serial();
  const Solver serial(make_spring_block(), options);
  CHECK(chosen.memory_bytes() > serial.memory_bytes());

  options.executor = cuda::device();
  options.method = SolverMethod::vertex_block;
  const Scene soft = make_spring_block({6, 5, 5}, options.method);
  CHECK_THAT(Solver(soft, options).backend_name(), ContainsSubstring("cooperative"));
  options.device_strategy = DeviceStrategy::cluster;
  CHECK_THROWS_WITH(Solver(soft, options), ContainsSubstring("vertex-block"));
  Scene linked = make_spring_block({6, 5, 5}, options.method);
  linked.add_body("linked", testing::make_box({2, 2, 2}, testing::kEventfulEdge, 0.1), {});
  linked.add_link({0, linked.body(1).first_vertex, 0, {0.5F, 0}});
  options.device_strategy = DeviceStrategy::cooperative;
  CHECK_THROWS_WITH(Solver(linked, options), ContainsSubstring("stiff links"));
  options.device_strategy = DeviceStrategy::automatic;
  CHECK_THAT(Solver(linked, options).backend_name(), ContainsSubstring("graph"));
  options.device_strategy = DeviceStrategy::automatic;
  options.executor = cuda::best();
  CHECK_THAT(Solver(soft, options).backend_name(), ContainsSubstring("cuda"));
}

// Would catch memory, streams or limits that are another device's, where there are several; and a
// device that stays the thread's after a call.
TEST_CASE("cuda solver: every device of the machine has the serial bits", "[device]") {
  const cuda::DeviceList list = cuda::find_devices();
  SolverOptions options = pbdsurg::testing::small_steps({.executor = executor::serial(),
                                                         .math = MathMode::strict,
                                                         .composition = PlanComposition::separate});
  const Scene scene = make_spring_block();
  Solver serial(scene, options);
  std::vector<Solver> solvers;
  for (const cuda::DeviceInfo& info : list.devices) {
    options.executor = cuda::device(info.id);
    CHECK_THAT(options.executor.name(), ContainsSubstring(info.name));
    solvers.emplace_back(scene, options);
  }
  for (int step = 0; step < 5; ++step) {
    serial.step(kTimeStep);
    for (Solver& solver : solvers) {
      solver.start_step(kTimeStep);
    }
    for (Solver& solver : solvers) {
      solver.finish_step();
      CHECK(solver.state_hash() == serial.state_hash());
    }
  }
  const int none = list.devices.back().id + 1;
  CHECK_THROWS_AS(cuda::device(none), BackendUnavailable);
  CHECK_THROWS_WITH(cuda::device(none),
                    ContainsSubstring("no CUDA device " + std::to_string(none) + ";"));
  CHECK_THROWS_AS(cuda::device(-1), BackendUnavailable);
}

TEST_CASE("cuda solver: a strategy that was asked for and cannot be had is refused", "[device]") {
  SolverOptions options = pbdsurg::testing::small_steps({.executor = cuda::device(),
                                                         .device_strategy = DeviceStrategy::cluster,
                                                         .composition = PlanComposition::joint});
  CHECK_THROWS_AS(Solver(make_spring_block(), options), BackendUnavailable);
  options.device_strategy = DeviceStrategy::automatic;
  CHECK_THAT(Solver(make_spring_block(), options).backend_name(), ContainsSubstring("graph"));
  options.composition = PlanComposition::automatic;
  CHECK_THAT(Solver(make_spring_block(), options).backend_name(), ContainsSubstring("cluster"));
}

}  // namespace pbdsurg
