// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The devices of both hands and feet, with the servos of those that have motors.

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/device.h"
#include "pbdsurg/haptics/device_trace.h"
#include "pbdsurg/haptics/handle.h"
#include "pbdsurg/haptics/pedal_keyboard.h"

#include "apps/rig/arms.h"
#include "apps/rig/emulated_rig.h"
#include "apps/rig/hand_servo.h"
#include "apps/rig/rig_description.h"
#include "apps/rig/rig_places.h"

namespace rig {

/// What a person wants to know of a hand.
struct HandStatus {
  std::string name;
  Mover mover = Mover::mouse;
  bool is_connected = true;
  HdapiStatus arm{};                  ///< of an arm
  pbdsurg::HandleCondition handle{};  ///< of an arm with a handle
  ServoReport servo{};                ///< of an arm or a trace
};

/// What the simulation's thread tells the window's of a device in a hand.
struct DeviceReport {
  bool is_connected = true;
  HdapiStatus arm{};
  pbdsurg::HandleCondition handle{};
};

/// Real or emulated devices, as one rig with one clock. Arms tick in their scheduler's thread;
/// recorded hands in a thread of this, so that what they would feel is known too; all of them by
/// tick() in virtual time. Hands of a mouse are the window's: see set_mouse().
class Rig {
 public:
  /// @throws pbdsurg::InvalidArgument     if time is virtual, and a device is not
  /// @throws pbdsurg::BackendUnavailable  if an arm does not open
  /// @throws pbdsurg::FileError           naming the handle, keyboard or trace that does not open
  Rig(const RigDescription& description, const RigPlaces& places, bool has_virtual_time);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Of all that runs on this rig.
  [[nodiscard]] pbdsurg::Clock& clock();

  /// What moves a hand that is a mouse's, before anybody asks for its state; it rests without.
  /// @param mouse  outlives the rig
  void set_mouse(Side side, pbdsurg::Device& mouse);

  /// @name The thread that steps the simulation
  /// @{
  /// The scene begins: scripts and traces do, and force is let in anew.
  /// @param scripts  as of rehearse()
  void begin(const std::array<std::vector<pbdsurg::Waypoint>, 2>& scripts);
  /// Emulated arms follow scripts from now on.
  /// @param scripts  [side]; where one is empty, the hand goes on as before
  void rehearse(const std::array<std::vector<pbdsurg::Waypoint>, 2>& scripts);
  [[nodiscard]] pbdsurg::Device& device(Side side);
  /// All pedals under the feet, which belong to no hand: an arm that is lost leaves them.
  [[nodiscard]] pbdsurg::Device& feet() { return *feet_; }
  /// Pedals are up until they are pressed anew.
  void let_go() noexcept;
  /// Null where there is none.
  [[nodiscard]] pbdsurg::Handle* handle(Side side) { return hand(side).handle.get(); }
  /// @}

  /// Whether somebody feels, or would feel, packets of this hand.
  [[nodiscard]] bool has_servo(Side side) const { return hand(side).servo != nullptr; }

  /// Of the thread that knows contacts. Does nothing where there is no servo.
  void publish(Side side, const pbdsurg::ContactPacket& packet);

  /// Force is let in anew, while nothing is touched: after the scene has leapt. Any thread.
  void disengage() noexcept;

  /// @name The window's thread
  /// @{
  /// Once a picture: calibrations go on, once a second.
  void poll();
  [[nodiscard]] const HandStatus& status(Side side);
  /// Whether all keyboards under the feet are there.
  [[nodiscard]] bool are_pedals_connected() const { return are_pedals_connected_; }
  /// What an arm can do by its own account; null where there is none.
  [[nodiscard]] const HdapiLimits* limits(Side side);
  /// @}

  /// @name Virtual time, which has one thread
  /// @{
  void tick();                                 ///< a millisecond passes, and all servos tick
  [[nodiscard]] double longest_trace() const;  ///< s
  [[nodiscard]] const ServoReport& last_tick(Side side) const { return hand(side).servo->report(); }
  /// @}

 private:
  class ArmHand;
  class TraceHand;
  class Feet;
  struct Hand {
    Hand();  // elsewhere, as Clang 14 knows no initialisers of members before the outer class ends
    Mover mover = Mover::mouse;
    int arm = 0;  // which, if it is one
    std::unique_ptr<pbdsurg::Handle> handle;
    std::unique_ptr<HandServo> servo;
    std::unique_ptr<pbdsurg::Device> device;  // of the simulation's thread
    pbdsurg::Device* mouse = nullptr;
    pbdsurg::DeviceTrace trace;
    std::unique_ptr<pbdsurg::Device> replay;     // of the thread that ticks traces
    pbdsurg::Mailbox<pbdsurg::DeviceState> now;  // of the replay, for the simulation's thread
    pbdsurg::Mailbox<DeviceReport> reports;
    HandStatus status;  // the window's
  };

  [[nodiscard]] Hand& hand(Side side) { return hands_[static_cast<std::size_t>(side)]; }
  [[nodiscard]] const Hand& hand(Side side) const { return hands_[static_cast<std::size_t>(side)]; }
  void open_arms_of(const RigDescription& description, const RigPlaces& places);
  void replay_anew();
  void tick_traces();

  bool has_virtual_time_;
  std::unique_ptr<EmulatedRig> emulated_;  // null where no arm is
  pbdsurg::RealClock real_clock_;
  pbdsurg::VirtualClock virtual_clock_;
  std::array<Hand, 2> hands_;
  std::vector<std::unique_ptr<pbdsurg::PedalKeyboard>> pedals_;
  std::atomic<bool> are_pedals_connected_ = true;
  std::unique_ptr<pbdsurg::Device> feet_;
  std::unique_ptr<Arms> arms_;             // after the servos, which their thread ticks
  double next_poll_ = 0;                   // s
  std::int64_t ticks_ = 0;                 // of virtual time, where no arm is emulated
  std::atomic<std::uint32_t> begins_ = 0;  // of traces, so far
  std::uint32_t begun_ = 0;                // of these, what the thread that ticks has followed
  std::atomic<bool> is_ending_ = false;
  std::thread ticking_;  // of traces in real time
};

}  // namespace rig
