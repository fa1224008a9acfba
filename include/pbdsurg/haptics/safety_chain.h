// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What stands between a computed force and the motors of a device.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Why a force was not what was computed.
enum class ServoFault : std::uint8_t {
  bad_packet,    ///< refused: not finite, or no packet at all
  bad_pose,      ///< of the device: not finite
  bad_force,     ///< computed: not finite
  device_lost,   ///< the device said that it does not answer, or that it failed
  clock_jump,    ///< time went back, or stood still for more than kLongestTick
  speed,         ///< a dropped handle
  stale_packet,  ///< the simulation has stopped
  peak,          ///< clamped to what motors may do now
  budget,        ///< clamped to less than that: they did too much
  warm_motors,   ///< the device said so
};
inline constexpr std::size_t kServoFaultCount = 10;  ///< of these

/// "bad packet", "speed"
[[nodiscard]] PBDSURG_API const char* name_of(ServoFault fault) noexcept;

/// How often each began: one that lasts counts once.
class PBDSURG_API ServoFaults {
 public:
  /// Tells whether there is one in this tick.
  void set(ServoFault fault, bool is_on) noexcept;
  /// Since the start.
  [[nodiscard]] std::uint32_t count(ServoFault fault) const noexcept;
  /// In the last tick.
  [[nodiscard]] bool is_on(ServoFault fault) const noexcept;

 private:
  std::array<std::uint32_t, kServoFaultCount> counts_{};
  std::uint32_t on_ = 0;
};

/// What a device's motors and its user can bear. Defaults: a Touch.
struct SafetyLimits {
  float peak = 2.6F;         ///< N: 0.8 of the 3.3 N that it can do cold
  float continuous = 0.88F;  ///< N, root mean square over half a minute: the maker's figure
};

/// Of a device that says what its motors can do.
/// @param nominal_peak        N, with cold motors; of it 0.8 is used, and at most 2.6 N
/// @param nominal_continuous  N, for long
/// @throws InvalidArgument  naming the value that is not positive and finite
[[nodiscard]] PBDSURG_API SafetyLimits limits_of_motors(float nominal_peak,
                                                        float nominal_continuous);

/// Lets force in slowly: at the start, and after what stopped it. A hand that is deep in tissue
/// gets none before it has come out, so that nothing kicks.
class PBDSURG_API Engagement {
 public:
  static constexpr float kQuietForce = 0.2F;  ///< N: first, less than this is computed
  static constexpr int kQuietTicks = 20;      ///< for so long; as CHAI3D's 0.2 N
  static constexpr float kRampTime = 1;       ///< s, then, from nothing to all
  /// N s/m, at the middle of the ramp, since a spring that stiffens under load makes energy: a
  /// fifth of what a Touch bears (CHAI3D)
  static constexpr float kDamping = 0.8F;

  /// Begins anew.
  void stop() noexcept;
  /// @param tick  s
  [[nodiscard]] Eigen::Vector3f apply(const Eigen::Vector3f& force, const Eigen::Vector3f& velocity,
                                      float tick) noexcept;
  /// From 0 to 1.
  [[nodiscard]] float gain() const noexcept { return gain_; }

 private:
  int quiet_ticks_ = 0;
  float gain_ = 0;
};

/// Fades force out where packets stop.
///
/// Linearly, from three periods on, and from 60 ms at the latest, to zero at 140 ms: an
/// exponential of 30 ms, as usual, has 0.05 N of 2.6 N left at 150 ms. The steepest slope is 2.6 N
/// in 80 ms, 0.03 N/ms.
class PBDSURG_API StallWatchdog {
 public:
  static constexpr float kEarliestFade = 0.03F;  ///< s, age of the last packet
  static constexpr float kLatestFade = 0.06F;    ///< s: so that packets at 30 Hz are not stale
  static constexpr float kEnd = 0.14F;           ///< s: force is zero from here on
  static constexpr float kReturnTime = 0.1F;     ///< s, back from nothing to all, if not yet there

  /// @param age     s, since the last packet came
  /// @param period  s, between packets, as measured
  /// @param tick    s
  /// @return        from 0 to 1
  [[nodiscard]] float gain(float age, float period, float tick) noexcept;

 private:
  float gain_ = 1;
};

/// Keeps motors cool: as the root mean square of what they did comes near what they can do for
/// long, the clamp comes down to that.
class PBDSURG_API ForceBudget {
 public:
  static constexpr float kTime = 30;  ///< s: motors take that long to warm
  static constexpr float kBegins =
      0.8F;  ///< of the continuous force: the clamp comes down from here

  /// N, the clamp now.
  [[nodiscard]] float clamp(const SafetyLimits& limits) const noexcept;
  /// @param commanded  N
  /// @param tick       s
  void add(float commanded, float tick) noexcept;

 private:
  float mean_square_ = 0;
};

/// What the servo knows in a tick, beside the force.
struct SafetyInput {
  float tick = 1e-3F;                                  ///< s, since the last one
  float packet_age = 0;                                ///< s, since the last packet came
  float packet_period = 0.01F;                         ///< s, between packets, as measured
  Eigen::Vector3f velocity = Eigen::Vector3f::Zero();  ///< m/s, of the tip, filtered
  bool is_ready = true;  ///< the device answers, and nothing upstream failed
  bool is_warm = false;  ///< the device warns of its motors
};

/// In this order: sanity (not finite: nothing, engage again), engagement, stall watchdog, peak
/// clamp, continuous budget, velocity gate (nothing, engage again), slew limit. All that says
/// nothing says it to the slew limit, which is last and brings force there in steps. Pure but for
/// its own state; no lock, no allocation, nothing is thrown. Can be copied: a copy goes on alike.
class PBDSURG_API SafetyChain {
 public:
  static constexpr float kSlew = 200;        ///< N/s, of the commanded force
  static constexpr float kSlewTick = 1e-3F;  ///< s: a later tick may step no further than this one
  static constexpr float kLargestSpeed = 1;  ///< m/s, of the tip: beyond, a handle was dropped

  /// Lets nothing in before it has seen a device that is ready.
  explicit SafetyChain(const SafetyLimits& limits = {}) noexcept : limits_(limits) {}

  /// One tick.
  /// @param computed  N
  /// @return          N, commanded
  [[nodiscard]] Eigen::Vector3f apply(const Eigen::Vector3f& computed,
                                      const SafetyInput& input) noexcept;

  /// What happened so far. The servo adds what it finds.
  [[nodiscard]] ServoFaults& faults() noexcept { return faults_; }
  [[nodiscard]] const ServoFaults& faults() const noexcept { return faults_; }  ///< likewise
  /// From 0, nothing, to 1, all: of the engagement.
  [[nodiscard]] float engaged() const noexcept { return engagement_.gain(); }
  /// N, what the last tick commanded.
  [[nodiscard]] const Eigen::Vector3f& commanded() const noexcept { return commanded_; }

 private:
  SafetyLimits limits_;
  ServoFaults faults_;
  Engagement engagement_;
  StallWatchdog watchdog_;
  ForceBudget budget_;
  Eigen::Vector3f commanded_ = Eigen::Vector3f::Zero();
};

}  // namespace pbdsurg
