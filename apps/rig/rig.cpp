// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig.h"

#include <cmath>
#include <limits>
#include <utility>

#include "pbdsurg/haptics/decorators.h"

namespace rig {
namespace {

constexpr double kPollPeriod = 1;             // s
constexpr std::size_t kMostSamples = 180000;  // of a recorded hand, that is asked each 10 ms
constexpr std::uint32_t kJawButton = 1;       // of an arm without a handle
constexpr float kJawSpeed = 4;                // 1/s: closed in a quarter of a second

// Somebody else's device.
class BorrowedDevice final : public pbdsurg::Device {
 public:
  explicit BorrowedDevice(pbdsurg::Device& device) : device_(device) {}
  [[nodiscard]] std::string name() const override { return device_.name(); }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override { return device_.state(); }
  void set_force(const Eigen::Vector3f& force) noexcept override { device_.set_force(force); }

 private:
  pbdsurg::Device& device_;
};

// An arm whose stylus is an instrument in a port. Its button closes the jaws.
class MappedArm final : public pbdsurg::Device {
 public:
  MappedArm(pbdsurg::Device& arm, const pbdsurg::InstrumentMapping& mapping)
      : arm_(arm), mapping_(mapping) {}
  [[nodiscard]] std::string name() const override { return arm_.name(); }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    pbdsurg::DeviceState state = arm_.state();
    state.pose = mapping_.map(state.pose).pose;
    const float way = kJawSpeed * static_cast<float>(std::max(0.0, state.time - time_));
    const bool is_closing = state.is_connected && (state.buttons & kJawButton) != 0;
    jaw_ = std::clamp(jaw_ + (is_closing ? -way : way), 0.0F, 1.0F);
    time_ = state.time;
    state.jaw = jaw_;
    return state;
  }

 private:
  pbdsurg::Device& arm_;
  pbdsurg::InstrumentMapping mapping_;
  double time_ = 0;  // s
  float jaw_ = 1;
};

// A device beside a mouse: keys and buttons on the screen are pedals, too.
class WithKeys final : public pbdsurg::Device {
 public:
  WithKeys(std::unique_ptr<pbdsurg::Device> device, pbdsurg::Device& mouse)
      : device_(std::move(device)), mouse_(mouse) {}
  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    pbdsurg::DeviceState state = device_->state();
    const pbdsurg::DeviceState keys = mouse_.state();
    state.pedals.cut = state.pedals.cut || keys.pedals.cut;
    state.pedals.coagulation = state.pedals.coagulation || keys.pedals.coagulation;
    return state;
  }

 private:
  std::unique_ptr<pbdsurg::Device> device_;
  pbdsurg::Device& mouse_;
};

pbdsurg::ServoOptions servo_options(const HandDescription& hand) {
  pbdsurg::ServoOptions options;
  options.mode = hand.servo;
  options.is_firm = hand.is_firm;
  options.force_scale = hand.force_scale;
  return options;
}

}  // namespace

// The simulation's side of an arm: tells the servo how the handle's wheel stands, and the window
// how the arm is.
class Rig::ArmHand final : public pbdsurg::Device {
 public:
  ArmHand(std::unique_ptr<pbdsurg::Device> device, Arms& arms, Hand& hand)
      : device_(std::move(device)), arms_(arms), hand_(hand) {}
  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    const pbdsurg::DeviceState state = device_->state();
    DeviceReport& report = hand_.reports.draft();
    report.is_connected = state.is_connected;
    report.arm = arms_.status(hand_.arm);
    if (hand_.handle) {
      const pbdsurg::HandleState& handle = hand_.handle->poll();
      hand_.servo->set_roll(handle.roll);
      report.handle = handle.condition;
    }
    hand_.reports.publish();
    return state;
  }

 private:
  std::unique_ptr<pbdsurg::Device> device_;
  Arms& arms_;
  Hand& hand_;
};

pbdsurg::InstrumentMapping mapping_of(const HandDescription& hand, const RigPlaces& places,
                                      Side side) {
  const std::size_t i = static_cast<std::size_t>(side);
  pbdsurg::InstrumentMappingOptions options;
  options.held = hand.held;
  options.motion_scale = hand.motion_scale;
  options.port = places.ports[i];
  Eigen::Vector3f origin = places.tips[i];
  if (hand.held == pbdsurg::HeldPart::handle) {
    const Eigen::Vector3f way = options.port - origin;
    origin += options.shaft_length * way.normalized();
  }
  options.to_scene.linear() = places.axes;
  options.to_scene.translation() = origin;
  return pbdsurg::InstrumentMapping(options);
}

Rig::Rig(const RigDescription& description, const RigPlaces& places,
         const std::array<pbdsurg::Device*, 2>& mice, EmulatedRig* emulated, pbdsurg::Clock& clock,
         bool has_virtual_time, bool is_recorded)
    : emulated_(emulated), clock_(clock), begin_(clock.now()) {
  std::vector<ArmOptions> arms;
  for (const Side side : kSides) {
    const HandDescription& described = description.hand(side);
    Hand& made = hand(side);
    made.mover = described.mover;
    if (described.mover == Mover::arm) {
      made.servo = std::make_unique<HandServo>(servo_options(described),
                                               mapping_of(described, places, side));
      made.arm = static_cast<int>(arms.size());
      arms.push_back(
          {name_of(side), described.arm_name, described.serial_number, made.servo.get()});
      if (described.handle) {
        made.handle = std::make_unique<pbdsurg::Handle>(described.handle->port,
                                                        described.handle->range, clock);
      }
    } else if (described.mover == Mover::trace) {
      const pbdsurg::DeviceTrace trace = pbdsurg::read_device_trace(described.trace);
      made.servo =
          std::make_unique<HandServo>(servo_options(described), pbdsurg::InstrumentMapping());
      made.device = pbdsurg::replayed(trace, clock);
      made.ticked = pbdsurg::replayed(trace, clock);
    } else {
      made.device = std::make_unique<BorrowedDevice>(*mice[static_cast<std::size_t>(side)]);
    }
  }
  std::vector<PedalsDescription> pedals = description.pedals;
  if (emulated != nullptr) {
    pedals.push_back(emulated->pedals());
  }
  for (const PedalsDescription& described : pedals) {
    pedals_.push_back(
        std::make_unique<pbdsurg::PedalKeyboard>(described.keyboard, described.keys, clock));
  }
  if (!arms.empty()) {
    arms_ = open_arms(arms, description.is_emulated, clock);
  }
  for (const Side side : kSides) {
    Hand& made = hand(side);
    if (made.mover == Mover::arm) {
      std::unique_ptr<pbdsurg::Device> device =
          std::make_unique<MappedArm>(arms_->device(made.arm), made.servo->mapping());
      if (made.handle) {
        device = pbdsurg::with_handle(std::move(device), *made.handle);
      }
      made.device = std::make_unique<ArmHand>(std::move(device), *arms_, made);
    }
  }
  // feet belong to no hand: a hand that is lost lifts its own pedals alone
  const Side with_feet = hand(Side::right).mover == Mover::trace ? Side::left : Side::right;
  for (const std::unique_ptr<pbdsurg::PedalKeyboard>& keyboard : pedals_) {
    Hand& made = hand(with_feet);
    made.device = pbdsurg::with_pedals(std::move(made.device), *keyboard);
  }
  for (const Side side : kSides) {
    Hand& made = hand(side);
    if (made.mover != Mover::mouse) {
      made.device =
          std::make_unique<WithKeys>(std::move(made.device), *mice[static_cast<std::size_t>(side)]);
    }
    made.status.mover = made.mover;
    made.status.name = made.device->name();
    if (is_recorded) {
      made.device = pbdsurg::recorded(std::move(made.device), made.trace, kMostSamples, clock);
    }
  }
  if (description.has(Mover::trace) && !has_virtual_time) {
    ticking_ = std::thread([this] {
      for (double next = clock_.now(); !is_ending_; next += HandServo::kPeriod) {
        clock_.wait_until(next);
        tick_traces();
      }
    });
  }
}

Rig::~Rig() {
  is_ending_ = true;
  if (ticking_.joinable()) {
    ticking_.join();
  }
}

pbdsurg::Device& Rig::device(Side side) {
  return *hand(side).device;
}

void Rig::publish(Side side, const pbdsurg::ContactPacket& packet) {
  Hand& felt = hand(side);
  if (!felt.servo || (emulated_ != nullptr && emulated_->is_stale(side))) {
    return;
  }
  pbdsurg::ContactPacket& draft = felt.servo->packets.draft();
  draft = packet;
  if (emulated_ != nullptr && emulated_->is_not_a_number(side)) {
    draft.force.fill(std::numeric_limits<float>::quiet_NaN());
  }
  felt.servo->packets.publish();
}

void Rig::rehearse(Side side, std::vector<pbdsurg::Waypoint> waypoints) {
  if (emulated_ != nullptr && hand(side).mover == Mover::arm) {
    emulated_->rehearse(side, std::move(waypoints));
  }
}

const HdapiLimits* Rig::limits(Side side) const {
  return hand(side).mover == Mover::arm ? &arms_->limits(hand(side).arm) : nullptr;
}

void Rig::tick_traces() noexcept {
  for (Hand& felt : hands_) {
    if (felt.ticked) {
      const pbdsurg::DeviceState state = felt.ticked->state();
      const double now = clock_.now();
      felt.ticked->set_force(felt.servo->tick(now, state.pose, state.is_connected, false));
    }
  }
}

void Rig::tick() {
  if (emulated_ != nullptr) {
    emulated_->tick();
  } else {
    clock_.wait_until(begin_ + HandServo::kPeriod * static_cast<double>(++ticks_));
  }
  tick_traces();
}

void Rig::write_traces(const std::filesystem::path& folder) const {
  for (const Side side : kSides) {
    pbdsurg::write_device_trace(folder / (std::string(name_of(side)) + ".trace"), hand(side).trace);
  }
}

void Rig::poll() {
  if (arms_ && clock_.now() >= next_poll_) {
    arms_->poll();
    next_poll_ = clock_.now() + kPollPeriod;
  }
}

const HandStatus& Rig::status(Side side) {
  Hand& told = hand(side);
  if (told.reports.take() > 0) {
    const DeviceReport& report = told.reports.value();
    told.status.is_connected = report.is_connected;
    told.status.arm = report.arm;
    told.status.handle = report.handle;
  }
  if (told.servo && told.servo->reports.take() > 0) {
    told.status.servo = told.servo->reports.value();
  }
  return told.status;
}

}  // namespace rig
