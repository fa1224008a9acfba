// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "pbdsurg/haptics/decorators.h"

namespace rig {
namespace {

constexpr double kPollPeriod = 1;        // s
constexpr std::uint32_t kJawButton = 1;  // of an arm without a handle
constexpr float kJawSpeed = 4;           // 1/s: closed in a quarter of a second

// An arm whose stylus is an instrument in a port. Its button closes the jaws, which open when the
// arm is lost.
class MappedArm final : public pbdsurg::Device {
 public:
  MappedArm(pbdsurg::Device& arm, const pbdsurg::InstrumentMapping& mapping,
            const pbdsurg::Clock& clock)
      : arm_(arm), mapping_(mapping), clock_(clock), time_(clock.now()) {}
  [[nodiscard]] std::string name() const override { return arm_.name(); }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    pbdsurg::DeviceState state = arm_.state();
    state.pose = mapping_.map(state.pose).pose;
    const double now = clock_.now();
    const float way = kJawSpeed * static_cast<float>(now - time_);
    const bool is_closing = state.is_connected && (state.buttons & kJawButton) != 0;
    jaw_ = std::clamp(jaw_ + (is_closing ? -way : way), 0.0F, 1.0F);
    time_ = now;
    state.jaw = jaw_;
    return state;
  }

 private:
  pbdsurg::Device& arm_;
  pbdsurg::InstrumentMapping mapping_;
  const pbdsurg::Clock& clock_;
  double time_;  // s
  float jaw_ = 1;
};

pbdsurg::ServoOptions servo_options(const HandDescription& hand) {
  pbdsurg::ServoOptions options;
  options.mode = hand.servo;
  options.is_firm = hand.is_firm;
  options.motion_scale = hand.motion_scale;
  options.force_scale = hand.force_scale;
  return options;
}

void check_virtual(const RigDescription& description) {
  if (description.has(Mover::arm) && !description.is_emulated) {
    throw pbdsurg::InvalidArgument("--virtual-time: real arms know real time alone");
  }
  if (!description.pedals.empty()) {
    throw pbdsurg::InvalidArgument("--virtual-time: the pedals " +
                                   description.pedals.front().keyboard.string() +
                                   " know real time alone");
  }
  for (const HandDescription& hand : description.hands) {
    if (hand.handle) {
      throw pbdsurg::InvalidArgument("--virtual-time: the handle at " + hand.handle->port.string() +
                                     " knows real time alone");
    }
  }
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

// The simulation's side of a recorded hand.
class Rig::TraceHand final : public pbdsurg::Device {
 public:
  explicit TraceHand(Hand& hand) : hand_(hand) {}
  [[nodiscard]] std::string name() const override { return hand_.trace.name; }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    hand_.now.take();
    const pbdsurg::DeviceState& state = hand_.now.value();
    hand_.reports.draft() = {state.is_connected, {}, {}};
    hand_.reports.publish();
    return state;
  }

 private:
  Hand& hand_;
};

// Pedals without a hand.
class Rig::Feet final : public pbdsurg::Device {
 public:
  explicit Feet(Rig& rig) : rig_(rig) {}
  [[nodiscard]] std::string name() const override { return "feet"; }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    pbdsurg::DeviceState state;
    state.time = rig_.clock().now();
    bool are_connected = true;
    for (const std::unique_ptr<pbdsurg::PedalKeyboard>& keyboard : rig_.pedals_) {
      keyboard->poll();
      const pbdsurg::Pedals& pedals = keyboard->event().pedals;
      state.pedals.cut = state.pedals.cut || pedals.cut;
      state.pedals.coagulation = state.pedals.coagulation || pedals.coagulation;
      are_connected = are_connected && keyboard->is_connected();
    }
    rig_.are_pedals_connected_ = are_connected;
    return state;
  }

 private:
  Rig& rig_;
};

Rig::Hand::Hand() = default;

Rig::Rig(const RigDescription& description, const RigPlaces& places, bool has_virtual_time)
    : has_virtual_time_(has_virtual_time), feet_(std::make_unique<Feet>(*this)) {
  if (has_virtual_time) {
    check_virtual(description);
  }
  if (description.is_emulated) {
    emulated_ = emulate(description, places, has_virtual_time);
  }
  for (const Side side : kSides) {
    const HandDescription& described = description.hand(side);
    Hand& made = hand(side);
    made.mover = described.mover;
    if (described.mover != Mover::mouse) {
      made.servo = std::make_unique<HandServo>(servo_options(described));
    }
    if (described.mover == Mover::arm && described.handle) {
      made.handle = std::make_unique<pbdsurg::Handle>(described.handle->port,
                                                      described.handle->range, clock());
    } else if (described.mover == Mover::trace) {
      made.trace = pbdsurg::read_device_trace(described.trace);
      made.device = std::make_unique<TraceHand>(made);
    } else if (described.mover == Mover::mouse) {
      const Eigen::Vector3f& tip = places.tips[static_cast<std::size_t>(side)];
      made.device = pbdsurg::scripted_hand("mouse", {{.tip = tip}}, clock());
    }
  }
  std::vector<PedalsDescription> pedals = description.pedals;
  if (emulated_) {
    pedals.push_back(emulated_->pedals());
  }
  for (const PedalsDescription& described : pedals) {
    pedals_.push_back(
        std::make_unique<pbdsurg::PedalKeyboard>(described.keyboard, described.keys, clock()));
  }
  if (description.has(Mover::arm)) {
    open_arms_of(description, places);
  }
  for (Hand& made : hands_) {
    made.status.mover = made.mover;
    made.status.name = made.device->name();
  }
  replay_anew();
  if (description.has(Mover::trace) && !has_virtual_time) {
    ticking_ = std::thread([this] {
      for (double next = clock().now(); !is_ending_; next += HandServo::kPeriod) {
        clock().wait_until(next);
        tick_traces();
      }
    });
  }
}

void Rig::open_arms_of(const RigDescription& description, const RigPlaces& places) {
  std::vector<ArmOptions> arms;
  for (const Side side : kSides) {
    if (hand(side).mover == Mover::arm) {
      const HandDescription& described = description.hand(side);
      hand(side).arm = static_cast<int>(arms.size());
      arms.push_back({name_of(side), described.arm_name, described.serial_number,
                      mapping_of(described, places, side), hand(side).servo.get()});
    }
  }
  arms_ = open_arms(arms, description.is_emulated, clock());
  for (Hand& made : hands_) {
    if (made.mover == Mover::arm) {
      std::unique_ptr<pbdsurg::Device> device = std::make_unique<MappedArm>(
          arms_->device(made.arm), arms[static_cast<std::size_t>(made.arm)].mapping, clock());
      if (made.handle) {
        device = pbdsurg::with_handle(std::move(device), *made.handle);
      }
      made.device = std::make_unique<ArmHand>(std::move(device), *arms_, made);
    }
  }
}

Rig::~Rig() {
  is_ending_ = true;
  if (ticking_.joinable()) {
    ticking_.join();
  }
}

pbdsurg::Clock& Rig::clock() {
  return emulated_           ? emulated_->clock()
         : has_virtual_time_ ? static_cast<pbdsurg::Clock&>(virtual_clock_)
                             : real_clock_;
}

void Rig::set_mouse(Side side, pbdsurg::Device& mouse) {
  hand(side).mouse = &mouse;
}

pbdsurg::Device& Rig::device(Side side) {
  Hand& asked = hand(side);
  return asked.mover == Mover::mouse && asked.mouse != nullptr ? *asked.mouse : *asked.device;
}

void Rig::rehearse(const std::array<std::vector<pbdsurg::Waypoint>, 2>& scripts) {
  for (const Side side : kSides) {
    const std::vector<pbdsurg::Waypoint>& script = scripts[static_cast<std::size_t>(side)];
    if (emulated_ && hand(side).mover == Mover::arm && !script.empty()) {
      emulated_->rehearse(side, script);
    }
  }
}

void Rig::begin(const std::array<std::vector<pbdsurg::Waypoint>, 2>& scripts) {
  if (emulated_ && begins_ == 0) {
    emulated_->begin();
  }
  rehearse(scripts);
  ++begins_;
  if (has_virtual_time_) {
    replay_anew();
  }
  disengage();
}

void Rig::let_go() noexcept {
  for (const std::unique_ptr<pbdsurg::PedalKeyboard>& keyboard : pedals_) {
    keyboard->let_go();
  }
}

void Rig::disengage() noexcept {
  for (Hand& felt : hands_) {
    if (felt.servo) {
      felt.servo->disengage();
    }
  }
}

void Rig::publish(Side side, const pbdsurg::ContactPacket& packet) {
  Hand& felt = hand(side);
  if (!felt.servo || (emulated_ && emulated_->is_stale(side))) {
    return;
  }
  pbdsurg::ContactPacket& draft = felt.servo->packets.draft();
  draft = packet;
  if (emulated_ && emulated_->is_not_a_number(side)) {
    draft.force.fill(std::numeric_limits<float>::quiet_NaN());
  }
  felt.servo->packets.publish();
}

const HdapiLimits* Rig::limits(Side side) {
  return hand(side).mover == Mover::arm ? &arms_->limits(hand(side).arm) : nullptr;
}

// In the thread that ticks them.
void Rig::replay_anew() {
  begun_ = begins_;
  for (Hand& felt : hands_) {
    if (felt.mover == Mover::trace) {
      felt.replay = pbdsurg::replayed(felt.trace, clock());
      felt.now.draft() = felt.replay->state();
      felt.now.publish();
    }
  }
}

void Rig::tick_traces() {
  if (begun_ != begins_) {
    replay_anew();
  }
  for (Hand& felt : hands_) {
    if (felt.mover == Mover::trace) {
      const pbdsurg::DeviceState state = felt.replay->state();
      felt.now.draft() = state;
      felt.now.publish();
      felt.servo->tick(clock().now(), {state.pose, Eigen::Matrix3f::Identity()}, state.is_connected,
                       false);
    }
  }
}

void Rig::tick() {
  if (emulated_) {
    emulated_->tick();
  } else {
    virtual_clock_.wait_until(HandServo::kPeriod * static_cast<double>(++ticks_));
  }
  tick_traces();
}

double Rig::longest_trace() const {
  double longest = 0;
  for (const Hand& felt : hands_) {
    if (felt.mover == Mover::trace) {
      longest = std::max(longest, felt.trace.samples.back().asked - felt.trace.begin);
    }
  }
  return longest;
}

void Rig::poll() {
  if (arms_ && clock().now() >= next_poll_) {
    arms_->poll();
    next_poll_ = clock().now() + kPollPeriod;
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
