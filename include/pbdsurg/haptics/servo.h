// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Force for a hand, a thousand times a second, of what a slower simulation last said.

#include <Eigen/Geometry>
#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/contact_packet.h"
#include "pbdsurg/haptics/safety_chain.h"

namespace pbdsurg {

/// How packets become force.
enum class ServoMode : std::uint8_t {
  model,  ///< the packet's planes and springs at the pose of the tick, packets cross-faded
  paper,  ///< the paper's: normals times depths at the packet's pose, held until the next packet
};

/// What of a rig stays as it is.
struct ServoOptions {
  ServoMode mode = ServoMode::model;  ///< how packets become force
  /// Up to kFirmStiffness instead of kStiffness: for devices with friction of 0.3 N s/m or more.
  bool is_firm = false;
  float motion_scale = 1;  ///< m of the tip a metre of the handle at a lever of 1, positive
  float force_scale = 1;   ///< N at the handle a newton at the tip at a lever of 1, not negative
  float device_stiffness = 400;  ///< N/m that the device can render; CHAI3D's figure for a Touch
  SafetyLimits limits{};         ///< of its motors
};

/// N/m, felt at the handle: the stiffest that settles on every plant of tests/haptics with 30 to 60
/// g and 0.1 N s/m or more, without a hand: there a wall is stable up to 2 b / T = 200 N/m.
inline constexpr float kStiffness = 180;
/// N/m, likewise, with 0.3 N s/m or more; but 30 g and 0.3 N s/m, without a hand, on a wall that
/// does not give, tremble at 3.6 mm/s, by less than a step of the encoder.
inline constexpr float kFirmStiffness = 300;
/// N/m, while packets come more than kSlowPeriod apart.
inline constexpr float kSlowStiffness = 80;
inline constexpr float kSlowPeriod = 0.02F;  ///< s
/// N/m, felt: what a packet has less, the model of the next milliseconds has nevertheless, with the
/// packet's force at the packet's pose. Between packets a model that is too stiff resists motion,
/// one that is too soft drives it: with packets of 80 N/m from tissue of 100 N/m, at 10 and 20 ms
/// of delay, plants of 0.3 N s/m oscillate at 0.4 m/s. With 150 N/m all tissue up to that settles,
/// thought to be as soft as it may; with 140 not.
inline constexpr float kLeastStiffness = 150;

/// A device in one tick.
struct ServoInput {
  double time = 0;                                        ///< s, of the servo's clock
  Eigen::Isometry3f tip = Eigen::Isometry3f::Identity();  ///< of the tool, in the scene, m
  Eigen::Matrix3f lever = Eigen::Matrix3f::Identity();    ///< see lever_about_port()
  bool is_ready = true;                                   ///< the device answers and has no error
  bool is_warm = false;                                   ///< the device warns of its motors
  bool has_leapt = false;  ///< the scene has, so that force is to be let in anew
};

/// Force in one tick, N, in the handle's axes, which are the scene's.
struct ServoForce {
  Eigen::Vector3f computed =
      Eigen::Vector3f::Zero();  ///< what the packets say, up to kLargestForce
  Eigen::Vector3f commanded = Eigen::Vector3f::Zero();  ///< what the motors get: for the device
};

/// How the tip of a straight, stiff tool moves with its handle, where it pivots in a port, and
/// slides through it: d tip = L d handle, and so F handle = L^T F tip. Along the shaft both move
/// alike; across it, the tip moves the other way, by what of the tool is inside over what is
/// outside.
/// @param port, handle, tip  m, on a line
/// @throws InvalidArgument  if one is not finite, or the handle is less than 1 cm from the port
[[nodiscard]] PBDSURG_API Eigen::Matrix3f lever_about_port(const Eigen::Vector3f& port,
                                                           const Eigen::Vector3f& handle,
                                                           const Eigen::Vector3f& tip);

/// What a servo remembers from tick to tick. Can be copied: a copy goes on alike.
class PBDSURG_API ServoState {
 public:
  /// @throws InvalidArgument  naming the option that is out of range
  explicit ServoState(const ServoOptions& options = {});

  /// Faults, and how far force has been let in.
  [[nodiscard]] const SafetyChain& chain() const noexcept { return chain_; }
  /// s, between packets, by their times: a mean of the last few.
  [[nodiscard]] float packet_period() const noexcept { return packet_period_; }
  /// m/s, of the tip: differences through one pole at 25 Hz, which encoders of 0.055 mm need.
  [[nodiscard]] const Eigen::Vector3f& velocity() const noexcept { return velocity_; }

 private:
  friend ServoForce servo_tick(ServoState& state, const ContactPacket& packet,
                               const ServoInput& input) noexcept;

  float measure_tick(double time) noexcept;
  void receive(const ContactPacket& packet) noexcept;
  void learn_stiffness(const ContactPacket& packet) noexcept;
  void begin_fade(const ServoInput& input) noexcept;
  [[nodiscard]] float grasp_rate() const noexcept;
  [[nodiscard]] Eigen::Vector3f evaluate(const ServoInput& input, float tick) noexcept;

  [[nodiscard]] Eigen::Vector3f felt_at(const ServoInput& input,
                                        const Eigen::Vector3f& at_tip) const noexcept;

  ServoOptions options_;
  SafetyChain chain_;
  double time_ = 0;
  bool has_time_ = false;
  Eigen::Isometry3f tip_ = Eigen::Isometry3f::Identity();  // the last that was finite
  bool has_tip_ = false;
  Eigen::Vector3f velocity_ = Eigen::Vector3f::Zero();

  ContactPacket old_, new_;  // cross-faded, with stiffness bounded
  ContactPacket next_;       // waits until the fade is over, as it came
  bool has_next_ = false;
  float weight_ = 1;                                  // of new_
  float grasp_gain_ = 0;                              // of the springs of both
  Eigen::Vector3f at_tip_ = Eigen::Vector3f::Zero();  // N, of the last tick, of mode model
  Eigen::Vector3f held_ = Eigen::Vector3f::Zero();    // N, at the tip: the paper's

  std::uint64_t sequence_ = 0;  // of the packet that came last
  double packet_time_ = 0;
  float packet_period_ = 0.01F, packet_age_ = 0;

  Eigen::Vector3f secant_position_ = Eigen::Vector3f::Zero();  // m, where the next secant begins
  Eigen::Vector3f secant_force_ = Eigen::Vector3f::Zero();     // N, there
  float secant_ = 0;                                           // N/m, the last
  float learned_ = 0;                                          // N/m, of the tissue
  GraspState learned_grasp_ = GraspState::open;                // of which it is
};

/// One tick of a servo. Depends on its arguments alone: the same calls give the same bits.
///
/// In mode `model`, forces of the planes and of the grasp of the last two packets are evaluated at
/// the tip's pose, and the old packet fades into the new one over one measured period, slower where
/// the two differ much, so that force changes by no more than kFadeSlew where motion leaves room
/// for that. A packet that comes meanwhile waits. Springs of jaws come and go over kGraspTime,
/// those that tear over kTearTime. Models are at least as stiff as kLeastStiffness, and as what the
/// packets' own forces have shown of the tissue since it was touched, or held. Felt stiffness,
/// force_scale * motion_scale * L^T K L, has no eigenvalue above that of the options and of the
/// device: where a packet is stiffer, but for springs that jaws have just let go, all of it is felt
/// softer, force included, since a force that is held for a period behind a softer model would be a
/// delayed spring, which makes energy (Colgate and Schenkel, "Passivity of a class of sampled-data
/// systems", J. Robotic Systems 14(1), 1997).
///
/// Then the safety chain.
///
/// Cost: about 1 us; no lock, no allocation. Nothing is thrown: what cannot be used is counted.
/// @param packet  the newest; a sequence of zero is none, one that was seen before is not new
[[nodiscard]] PBDSURG_API ServoForce servo_tick(ServoState& state, const ContactPacket& packet,
                                                const ServoInput& input) noexcept;

inline constexpr float kFadeSlew = 80;  ///< N/s
/// N, at the handle, of any packet: beyond what devices can do, so that the fade from a packet that
/// is wrong by a metre ends in time
inline constexpr float kLargestForce = 5;
inline constexpr float kGraspTime = 0.06F;   ///< s, closing and opening
inline constexpr float kTearTime = 0.03F;    ///< s: what is felt of a tear is that it is sudden
inline constexpr float kLargestDrag = 2;     ///< N s/m: half of CHAI3D's figure for a Touch
inline constexpr float kLongestTick = 0.1F;  ///< s: beyond, the clock has jumped

}  // namespace pbdsurg
