// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/emulated_rig.h"

#include <array>
#include <atomic>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/input.h>
#include <unistd.h>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/file_descriptor.h"

#include "apps/hdapi_emulator/emulator.h"

namespace rig {
namespace {

using hdapi_emulator::Emulator;
using hdapi_emulator::EmulatorOptions;
using hdapi_emulator::Fault;
using hdapi_emulator::FaultPlan;

// A hand that holds an instrument: within what was measured of arms that hold a place
// (Mussa-Ivaldi, Hogan and Bizzi, J. Neuroscience 5(10), 1985).
constexpr double kGripStiffness = 300;  // N/m
constexpr double kGripDamping = 5;      // N s/m
constexpr int kFirstButton = 1;         // HD_DEVICE_BUTTON_1

// The time of scripts: the scheduler's, which does not jump.
class ScriptClock final : public pbdsurg::Clock {
 public:
  [[nodiscard]] double now() const noexcept override { return now_; }
  void wait_until(double time) override { now_ = time; }

 private:
  std::atomic<double> now_ = 0;
};

// A keyboard of two keys: the kernel's records through a pipe.
class EmulatedPedals {
 public:
  EmulatedPedals() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) {
      throw pbdsurg::FileError("the system has no pipe left for emulated pedals");
    }
    reader_ = pbdsurg::FileDescriptor(ends[0]);
    writer_ = pbdsurg::FileDescriptor(ends[1]);
  }

  [[nodiscard]] PedalsDescription description() const {
    return {"/proc/self/fd/" + std::to_string(reader_.number()), {kCut, kCoagulation}};
  }

  void press(const pbdsurg::Pedals& pedals) {
    send(kCut, pedals.cut, pedals_.cut);
    send(kCoagulation, pedals.coagulation, pedals_.coagulation);
    pedals_ = pedals;
  }

 private:
  static constexpr std::uint16_t kCut = KEY_A, kCoagulation = KEY_B;

  void send(std::uint16_t key, bool is_down, bool was_down) {
    if (is_down == was_down) {
      return;
    }
    std::array<input_event, 2> records{};
    records[0].type = EV_KEY;
    records[0].code = key;
    records[0].value = is_down ? 1 : 0;
    records[1].type = EV_SYN;
    records[1].code = SYN_REPORT;
    // a full pipe loses them, as a kernel would whose reader is gone
    static_cast<void>(!write(writer_.number(), records.data(), sizeof records));
  }

  pbdsurg::FileDescriptor reader_, writer_;
  pbdsurg::Pedals pedals_;
};

// A hand between the thread that gives it scripts and the scheduler's, which asks where it is.
class RehearsedHand {
 public:
  RehearsedHand(const pbdsurg::InstrumentMapping& mapping, const Eigen::Vector3f& tip,
                EmulatedPedals& pedals)
      : mapping_(mapping), pedals_(pedals) {
    rehearse({{.tip = tip}});
  }

  void rehearse(std::vector<pbdsurg::Waypoint> waypoints) {
    scripts_.draft() = pbdsurg::scripted_hand("rehearsal", std::move(waypoints), clock_);
    scripts_.publish();
  }

  // The scheduler's thread.
  hdapi_emulator::Hand at(double time) {
    clock_.wait_until(time);
    scripts_.take();
    const pbdsurg::DeviceState state = scripts_.value()->state();
    if (!(state.pedals == last_)) {
      pedals_.press(state.pedals);
      last_ = state.pedals;
    }
    hdapi_emulator::Hand hand;
    hand.target = mapping_.arm_at(state.pose.translation()).cast<double>();
    hand.stiffness = kGripStiffness;
    hand.damping = kGripDamping;
    hand.buttons = state.jaw < 0.5F ? kFirstButton : 0;
    return hand;
  }

 private:
  pbdsurg::InstrumentMapping mapping_;
  EmulatedPedals& pedals_;
  ScriptClock clock_;
  pbdsurg::Mailbox<std::shared_ptr<pbdsurg::Device>> scripts_;
  pbdsurg::Pedals last_;
};

Fault fault_named(const std::string& name) {
  std::string known;
  for (std::size_t i = 0; i < hdapi_emulator::kFaultCount; ++i) {
    const auto fault = static_cast<Fault>(i);
    if (name == hdapi_emulator::name_of(fault)) {
      return fault;
    }
    known += std::string(known.empty() ? "" : ", ") + hdapi_emulator::name_of(fault);
  }
  throw pbdsurg::InvalidArgument("fault '" + name + "' is none of " + known);
}

class Emulation final : public EmulatedRig {
 public:
  Emulation(const RigDescription& description, const RigPlaces& places, bool has_virtual_time)
      : mappings_{mapping_of(description.hands[0], places, Side::left),
                  mapping_of(description.hands[1], places, Side::right)},
        hands_{{{mappings_[0], places.tips[0], pedals_}, {mappings_[1], places.tips[1], pedals_}}} {
    EmulatorOptions options;
    options.has_real_time = !has_virtual_time;
    options.devices.clear();
    for (const Side side : kSides) {
      const std::size_t i = static_cast<std::size_t>(side);
      const HandDescription& hand = description.hands[i];
      if (hand.mover != Mover::arm) {
        continue;
      }
      hdapi_emulator::DeviceOptions device;
      device.name = hand.arm_name.empty() ? "Default Device" : hand.arm_name;
      device.serial_number = hand.serial_number.empty() ? std::string("EMULATED-") + name_of(side)
                                                        : hand.serial_number;
      device.position = mappings_[i].arm_at(places.tips[i]).cast<double>();
      device.hand = [&emulated = hands_[i]](double time) { return emulated.at(time); };
      indices_[i] = static_cast<int>(options.devices.size());
      options.devices.push_back(std::move(device));
    }
    emulator_ = std::make_unique<Emulator>(options);
    for (const FaultDescription& fault : description.faults) {
      const int device = indices_[static_cast<std::size_t>(fault.side)];
      if (device < 0) {
        throw pbdsurg::InvalidArgument("fault '" + fault.fault + "' is of the " +
                                       name_of(fault.side) + " hand, which holds no arm");
      }
      const FaultPlan plan{fault_named(fault.fault), fault.begin, fault.duration, device};
      if (fault.begin > 0) {
        plans_.push_back(plan);
      } else {
        emulator_->inject(plan);
      }
    }
  }

  [[nodiscard]] pbdsurg::Clock& clock() override { return emulator_->clock(); }
  void tick() override { emulator_->step(1); }
  [[nodiscard]] PedalsDescription pedals() const override { return pedals_.description(); }
  void rehearse(Side side, std::vector<pbdsurg::Waypoint> waypoints) override {
    hands_[static_cast<std::size_t>(side)].rehearse(std::move(waypoints));
  }
  void begin() override {
    for (FaultPlan plan : std::exchange(plans_, {})) {
      plan.begin += emulator_->scheduler_time();
      emulator_->inject(plan);
    }
  }
  [[nodiscard]] bool is_stale(Side side) const override {
    return is_active(Fault::stale_packets, side);
  }
  [[nodiscard]] bool is_not_a_number(Side side) const override {
    return is_active(Fault::simulation_nan, side);
  }

 private:
  [[nodiscard]] bool is_active(Fault fault, Side side) const {
    const int device = indices_[static_cast<std::size_t>(side)];
    return device >= 0 && emulator_->is_active(fault, device);
  }

  std::array<pbdsurg::InstrumentMapping, 2> mappings_;
  EmulatedPedals pedals_;
  std::array<RehearsedHand, 2> hands_;
  std::vector<FaultPlan> plans_;        // until a scene begins
  std::array<int, 2> indices_{-1, -1};  // of the emulator's devices, [side]
  std::unique_ptr<Emulator> emulator_;  // first to go: its thread asks the others
};

}  // namespace

std::unique_ptr<EmulatedRig> emulate(const RigDescription& description, const RigPlaces& places,
                                     bool has_virtual_time) {
  return std::make_unique<Emulation>(description, places, has_virtual_time);
}

}  // namespace rig
