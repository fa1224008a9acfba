// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/simulation_thread.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "apps/cholecystectomy/play/hand.h"
#include "tests/support/catch.h"
#include "tests/support/eventually.h"

namespace cholecystectomy {

using pbdsurg::testing::ContainsSubstring;
using pbdsurg::testing::kPatience;

namespace {

struct Threaded {
  explicit Threaded(SimulationThread::Options options)
      : thread(std::move(options), {&hands[0], &hands[1]}, clock) {}

  static SimulationThread::Options options() {
    SimulationThread::Options options;
    options.detail = Detail::low;
    options.executor = [] { return pbdsurg::executor::threads(); };
    return options;
  }

  // Takes states as a window does, until one is as wanted.
  template <class Condition>
  const SceneState& await(Condition condition) {
    const double end = clock.now() + kPatience;
    while (clock.now() < end) {
      if (thread.states.take() > 0) {
        const SceneState& state = thread.states.value();
        thread.seen.draft() = {thread.states.sequence(), state.generation, state.triangle_versions,
                               state.burn_versions, state.vertex_counts};
        thread.seen.publish();
        generations = std::max(generations, state.generation);
        if (condition(state)) {
          return state;
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    FAIL("no such state in time");
    return thread.states.value();
  }

  void order(const Orders& orders) {
    thread.orders.draft() = orders;
    thread.orders.publish();
  }

  pbdsurg::RealClock clock;
  std::array<MouseHand, 2> hands{
      {{"left", {{-0.05F, 0.05F, -0.16F}, {0.03F, 0, 0}, 0.14F}, {-0.04F, 0.03F, -0.06F}, clock},
       {"right", {{0.12F, -0.08F, -0.16F}, {0.03F, 0, 0}, 0.14F}, {0.1F, -0.04F, -0.06F}, clock}}};
  std::uint32_t generations = 0;
  SimulationThread thread;  // last: it uses the hands
};

}  // namespace

// Would catch a window that stays black while a solver is made, a pause that goes on, a step too
// many, or a restart that keeps the old scene.
TEST_CASE("simulation thread: shows organs first, plays, pauses, steps and begins anew",
          "[session]") {
  Threaded play(Threaded::options());
  const SceneState& first = play.await([](const SceneState&) { return true; });
  CHECK(first.phase == Phase::loading);
  CHECK(first.generation == 0);
  CHECK(first.whole.size() == kOrganCount + 1);
  play.await([](const SceneState& state) {
    return state.phase == Phase::playing && state.generation == 1 && !state.whole.empty();
  });
  play.await([](const SceneState& state) { return state.step > 3 && state.whole.empty(); });

  Orders orders;
  orders.is_paused = true;
  play.order(orders);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const std::int64_t paused = play.await([](const SceneState&) { return true; }).step;
  const double later = play.clock.now() + 0.3;
  const std::int64_t still =
      play.await([&](const SceneState&) { return play.clock.now() > later; }).step;
  CHECK(still == paused);
  orders.single_steps = 2;
  play.order(orders);
  CHECK(play.await([&](const SceneState& state) { return state.step >= still + 2; }).step ==
        still + 2);
  orders.undos = 3;  // heard though time stands still
  play.order(orders);
  const auto undos = [](const SceneState& state) {
    return state.events[static_cast<std::size_t>(Event::undone)] +
           state.events[static_cast<std::size_t>(Event::no_undo)];
  };
  CHECK(undos(play.await([&](const SceneState& state) { return undos(state) > 2; })) == 3);

  orders.is_paused = false;
  orders.restarts = 1;
  play.order(orders);
  const SceneState& anew = play.await([](const SceneState& state) {
    return state.events[static_cast<std::size_t>(Event::restarted)] == 1 && !state.whole.empty();
  });
  CHECK(anew.whole.size() == kOrganCount + 1);
  CHECK(anew.step < 100);
  CHECK(anew.all_steps >= still + 2 + anew.step);
}

// Would catch a rig whose pedals burn on when the window has lost the keyboard.
TEST_CASE("simulation thread: lets go of pedals as often as it is told", "[session]") {
  std::atomic<int> let_gos = 0;
  SimulationThread::Options options = Threaded::options();
  options.on_let_go = [&] { ++let_gos; };
  Threaded play(std::move(options));
  const auto step_on = [&] {
    const std::int64_t step = play.await([](const SceneState&) { return true; }).all_steps;
    play.await([&](const SceneState& state) { return state.all_steps > step + 3; });
  };
  step_on();
  CHECK(let_gos == 0);
  for (const int told : {1, 2}) {
    Orders orders;
    orders.let_gos = static_cast<std::uint32_t>(told);
    play.order(orders);
    step_on();
    CHECK(let_gos == told);
  }
}

// Would catch an undo that no state tells of, a pedal that burns on, or a clock that stands still.
TEST_CASE("simulation thread: takes a stroke back and plays on", "[session]") {
  Threaded play(Threaded::options());
  const SceneState& begin = play.await([](const SceneState& state) { return state.step > 0; });
  const auto& fat = begin.changes[static_cast<std::size_t>(Organ::calot_fat)].positions;
  const auto depth = [](const Eigen::Vector3f& x) { return x.y() + x.z(); };
  const Eigen::Vector3f facing = *std::ranges::min_element(fat, {}, depth);
  play.hands[1].move(facing - play.hands[1].tip());
  play.await([&](const SceneState& state) {
    return (state.hook.pose.translation() - facing).norm() < 1e-4F;
  });
  play.hands[1].set_pedals({.coagulation = true});
  const SceneState& burnt = play.await([&](const SceneState& state) {
    play.hands[1].refresh();
    return state.generator.energy > 1;
  });
  const std::uint32_t generation = burnt.generation;
  Orders orders;
  orders.undos = 1;
  play.order(orders);
  const SceneState& undone = play.await([](const SceneState& state) {
    return state.events[static_cast<std::size_t>(Event::undone)] == 1;
  });
  CHECK(undone.generation == generation + 1);
  CHECK(undone.generator.energy == 0);
  const std::int64_t step = undone.step;
  const SceneState& later = play.await([&](const SceneState& state) {
    play.hands[1].refresh();
    return state.step > step + 20;
  });
  CHECK(later.generator.energy == 0);
  CHECK(later.generator.activation == pbdsurg::Activation::none);
}

// Would catch a thread that dies without a word.
TEST_CASE("simulation thread: what goes wrong is told in a state", "[session]") {
  SimulationThread::Options options = Threaded::options();
  options.executor = []() -> pbdsurg::Executor {
    throw pbdsurg::BackendUnavailable("no such device");
  };
  Threaded play(std::move(options));
  const SceneState& state =
      play.await([](const SceneState& now) { return now.phase == Phase::failed; });
  CHECK_THAT(state.message, ContainsSubstring("no such device"));
}

// Would catch a program that hangs when it is closed while it loads.
TEST_CASE("simulation thread: ends while it loads", "[session]") {
  const Threaded play(Threaded::options());
}

}  // namespace cholecystectomy
