// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The devices of both hands, with the servos of those that have motors.

#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
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
#include "pbdsurg/haptics/instrument_mapping.h"
#include "pbdsurg/haptics/pedal_keyboard.h"

#include "apps/rig/arms.h"
#include "apps/rig/emulated_rig.h"
#include "apps/rig/hand_servo.h"
#include "apps/rig/rig_description.h"

namespace rig {

/// Where instruments stand in the scene.
struct RigPlaces {
  std::array<Eigen::Vector3f, 2> ports;  ///< m, [side]
  std::array<Eigen::Vector3f, 2> tips;   ///< m, [side]: where hands begin, the arm's origin
  Eigen::Matrix3f axes;                  ///< of the scene: columns right, up and to the user
};

/// How an arm in the description stands to the scene.
[[nodiscard]] pbdsurg::InstrumentMapping mapping_of(const HandDescription& hand,
                                                    const RigPlaces& places, Side side);

/// What a person wants to know of a hand.
struct HandStatus {
  std::string name;
  Mover mover = Mover::mouse;
  bool is_connected = true;
  HdapiStatus arm{};                  ///< of an arm
  pbdsurg::HandleCondition handle{};  ///< of an arm with a handle
  ServoReport servo{};                ///< of an arm or a trace
};

/// Real or emulated devices, as one rig. Arms tick in their scheduler's thread; recorded hands in a
/// thread of this, so that what they would feel is known too, or in virtual time by tick().
class Rig {
 public:
  /// @param mice     [side], for hands that are no device's, and their pedals; outlive the rig
  /// @param emulated  outlives the rig; null where no arm is emulated
  /// @param clock     the emulated rig's, if there is one; outlives the rig
  /// @param is_recorded  whether what hands do is kept for write_traces(): the first half hour
  /// @throws pbdsurg::BackendUnavailable  if an arm does not open
  /// @throws pbdsurg::FileError           naming the handle, keyboard or trace that does not open
  Rig(const RigDescription& description, const RigPlaces& places,
      const std::array<pbdsurg::Device*, 2>& mice, EmulatedRig* emulated, pbdsurg::Clock& clock,
      bool has_virtual_time, bool is_recorded = false);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Of the thread that steps the simulation.
  [[nodiscard]] pbdsurg::Device& device(Side side);

  /// Whether somebody feels, or would feel, packets of this hand.
  [[nodiscard]] bool has_servo(Side side) const { return hand(side).servo != nullptr; }

  /// Of the thread that knows contacts. Does nothing where there is no servo.
  void publish(Side side, const pbdsurg::ContactPacket& packet);

  /// Emulated arms follow a script from now on; others do not. Any one thread.
  void rehearse(Side side, std::vector<pbdsurg::Waypoint> waypoints);

  /// Virtual time goes on by a tick of all servos.
  void tick();

  /// What hands did until now, as device traces FOLDER/left.trace and right.trace, after the thread
  /// that asked for states has ended.
  /// @throws pbdsurg::FileError  if one cannot be written
  void write_traces(const std::filesystem::path& folder) const;

  /// Of the window's thread, once a picture: calibrations go on, once a second.
  void poll();
  /// Likewise.
  [[nodiscard]] const HandStatus& status(Side side);

  /// What an arm can do by its own account; null where there is none.
  [[nodiscard]] const HdapiLimits* limits(Side side) const;
  /// Of the thread that asks for states; null where there is none.
  [[nodiscard]] pbdsurg::Handle* handle(Side side) { return hand(side).handle.get(); }

  /// In virtual time, which has one thread: what the last tick did.
  [[nodiscard]] const ServoReport& last_tick(Side side) const { return hand(side).servo->report(); }

 private:
  class ArmHand;
  // What the simulation's thread tells the window's.
  struct DeviceReport {
    bool is_connected = true;
    HdapiStatus arm;
    pbdsurg::HandleCondition handle{};
  };
  struct Hand {
    Mover mover = Mover::mouse;
    int arm = 0;  // which, if it is one
    std::unique_ptr<pbdsurg::Handle> handle;
    std::unique_ptr<HandServo> servo;
    pbdsurg::DeviceTrace trace;               // of what the following did, if that is kept
    std::unique_ptr<pbdsurg::Device> device;  // of the simulation's thread
    std::unique_ptr<pbdsurg::Device> ticked;  // a trace once more, for its servo
    pbdsurg::Mailbox<DeviceReport> reports;
    HandStatus status;  // the window's
  };

  [[nodiscard]] Hand& hand(Side side) { return hands_[static_cast<std::size_t>(side)]; }
  [[nodiscard]] const Hand& hand(Side side) const { return hands_[static_cast<std::size_t>(side)]; }
  void tick_traces() noexcept;

  EmulatedRig* emulated_;
  pbdsurg::Clock& clock_;
  std::array<Hand, 2> hands_;
  std::vector<std::unique_ptr<pbdsurg::PedalKeyboard>> pedals_;
  std::unique_ptr<Arms> arms_;  // after the servos, which their thread ticks
  double next_poll_ = 0;        // s
  std::int64_t ticks_ = 0;      // of virtual time, where no arm is emulated
  double begin_;                // s, of these
  std::atomic<bool> is_ending_ = false;
  std::thread ticking_;  // of traces in real time
};

}  // namespace rig
