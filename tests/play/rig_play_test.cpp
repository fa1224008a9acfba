// SPDX-License-Identifier: Apache-2.0
// Servos, contacts, the simulation and a window's side, each in its thread.
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "apps/cholecystectomy/play/contact_thread.h"
#include "apps/cholecystectomy/play/places.h"
#include "apps/cholecystectomy/play/rehearsal.h"
#include "apps/cholecystectomy/play/simulation_thread.h"
#include "apps/rig/rig.h"
#include "tests/support/catch.h"
#include "tests/support/eventually.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::kPatience;
using rig::kSides;
using rig::Side;

struct PlayedRig {
  explicit PlayedRig(const rig::RigDescription& rig_description = rig::read_rig("emulator"))
      : rig(rig_description, places, false) {
    SimulationThread::Options options;
    options.detail = Detail::low;
    options.executor = [] { return pbdsurg::executor::serial(); };
    options.on_begin = [this](const SurgicalScene& scene) {
      rig.begin(make_rehearsal(scene, places.tips).hands);
    };
    simulation = std::make_unique<SimulationThread>(
        std::move(options), Hands{&rig.device(Side::left), &rig.device(Side::right), {&rig.feet()}},
        rig.clock(), &contacts);
  }

  // Takes states as a window does, until one is as wanted.
  template <class Condition>
  void await(Condition condition) {
    for (const double end = rig.clock().now() + kPatience; rig.clock().now() < end;) {
      if (simulation->states.take() > 0) {
        const SceneState& state = simulation->states.value();
        REQUIRE(state.phase != Phase::failed);
        simulation->seen.draft() = {simulation->states.sequence(), state.generation,
                                    state.triangle_versions, state.burn_versions,
                                    state.vertex_counts};
        simulation->seen.publish();
      }
      rig.poll();
      contacts.ages.take();
      if (condition(simulation->states.value())) {
        return;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    const rig::HandStatus& left = rig.status(Side::left);
    FAIL("not in time; the left hand: lost "
         << left.arm.is_lost << ", connected " << left.is_connected << ", ticks "
         << left.servo.tick_count << ", commanded " << left.servo.force.commanded.norm() << " N");
  }

  rig::RigPlaces places = hand_places();
  rig::Rig rig;
  ContactThread contacts{rig, {Side::left, Side::right}, rig.clock()};
  std::unique_ptr<SimulationThread> simulation;
};

}  // namespace

// Would catch, under a thread sanitizer, a race between any two of the four; and packets or pedals
// that get lost between them.
TEST_CASE("rig play: four threads drag an organ and burn", "[rig]") {
  PlayedRig play;
  float most = 0;
  bool is_slow = false;  // under a sanitizer: then hands are gone before the scene has seen them
  double begin = -1;
  play.await([&](const SceneState& state) {
    most = std::max(most, play.rig.status(Side::left).servo.force.commanded.norm());
    begin = begin < 0 && state.phase == Phase::playing ? play.rig.clock().now() : begin;
    is_slow = is_slow || state.factor < 0.9;
    const bool is_over = begin >= 0 && play.rig.clock().now() > begin + 15;
    return state.generator.energy > 1 || (is_over && state.all_steps > 50);
  });
  const SceneState& state = play.simulation->states.value();
  CHECK((is_slow || state.generator.energy > 1));
  CHECK((is_slow || most > 0.5F));  // what the drag pulls with
  CHECK((is_slow || state.events[static_cast<std::size_t>(Event::grasped)] > 0));
  for (const Side side : kSides) {
    const rig::ServoReport& servo = play.rig.status(side).servo;
    CHECK(servo.packet_ages.count() > 100);
    CHECK(servo.faults.count(pbdsurg::ServoFault::bad_packet) == 0);
  }
  CHECK(play.contacts.ages.value().count() > 50);
}

// Would catch an operation that ends with the arm, or a force that stays on.
TEST_CASE("rig play: the operation goes on without an arm that is lost", "[rig]") {
  rig::RigDescription description = rig::read_rig("emulator");
  description.faults.push_back({.fault = "unplugged", .side = Side::left, .begin = 4});
  PlayedRig play(description);
  play.await([&](const SceneState& state) {
    return state.phase == Phase::playing && !play.rig.status(Side::left).is_connected;
  });
  const std::int64_t steps = play.simulation->states.value().all_steps;
  play.await([&](const SceneState& state) {  // a servo that gets no processor is late
    return state.all_steps > steps + 20 &&
           play.rig.status(Side::left).servo.force.commanded.isZero(0);
  });
  CHECK(play.rig.status(Side::left).arm.is_lost);
  CHECK(play.rig.status(Side::right).is_connected);
}

}  // namespace cholecystectomy
