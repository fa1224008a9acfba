// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device in a hand, a simulation that lags behind it, and the servo between them, in virtual
/// time: what tests and tables of the haptic loop run.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "pbdsurg/haptics/servo.h"

namespace pbdsurg::testing {

/// A device: a mass with viscous friction, seen through an encoder, in a hand or free.
struct Plant {
  double mass = 0.045;                ///< kg
  double damping = 0.3;               ///< N s/m
  bool has_hand = false;              ///< which pulls to Rig::target by 150 N/m and 3 N s/m
  bool is_guided = false;             ///< along y: a tip alone would slide off what it presses on
  double encoder = 55e-6;             ///< m, its step
  Eigen::Vector3d position{0, 0, 0};  ///< m
  Eigen::Vector3d velocity{0, 0, 0};  ///< m/s
};

/// Fills planes, grasp, drag and force of a packet whose pose is set.
using FakeTissue = std::function<void(ContactPacket& packet, double time)>;

/// One loop: servo at 1 kHz, packets at a period, each late by a delay.
class Rig {
 public:
  static constexpr double kTick = 1e-3;  ///< s
  static constexpr int kSubsteps = 20;   ///< of the plant, a tick
  static constexpr double kHandStiffness = 150, kHandDamping = 3;

  Plant plant;
  FakeTissue tissue;
  ServoState servo;
  int period = 10;                           ///< ticks
  int delay = 0;                             ///< ticks
  bool publishes = true;                     ///< the simulation runs
  Eigen::Vector3d push{0, 0, 0};             ///< N, of whoever pushes a plant without a hand
  Eigen::Vector3d target{0, 0, 0};           ///< m, of the hand
  Eigen::Vector3d target_velocity{0, 0, 0};  ///< m/s, likewise
  std::function<void(ServoInput&)> spoil;    ///< what a fault does to the device
  double time = 0;                           ///< s

  // records, one a tick
  std::vector<Eigen::Vector3f> computed, commanded;
  std::vector<Eigen::Vector3d> positions, velocities;
  double work = 0;         ///< J, of the commanded force on the plant
  double dissipation = 0;  ///< J, in the plant's own friction
  double surplus = 0;      ///< J, the most that work ever exceeded dissipation by

  Rig(const Plant& device, FakeTissue of, const ServoOptions& options = {})
      : plant(device), tissue(std::move(of)), servo(options) {}

  void run(double seconds) {
    for (long n = std::lround(seconds / kTick); n > 0; --n) {
      tick();
    }
  }

  void tick() {
    const Eigen::Vector3d seen = (plant.position / plant.encoder).array().round() * plant.encoder;
    if (ticks_ % period == 0 && publishes) {
      ContactPacket packet;
      packet.sequence = ++sequence_;
      packet.time = time;
      packet.position = packet_vector(seen.cast<float>());
      tissue(packet, time);
      way_.push_back({ticks_ + delay, packet});
    }
    while (!way_.empty() && way_.front().due <= ticks_) {
      packet_ = way_.front().packet;
      way_.pop_front();
    }
    ServoInput input;
    input.time = time;
    input.tip.translation() = seen.cast<float>();
    if (spoil) {
      spoil(input);
    }
    const ServoForce force = servo_tick(servo, packet_, input);
    computed.push_back(force.computed);
    commanded.push_back(force.commanded);
    move(force.commanded.cast<double>());
    positions.push_back(plant.position);
    velocities.push_back(plant.velocity);
    time += kTick;
    ++ticks_;
  }

  /// m/s, the highest between two times.
  [[nodiscard]] double peak_speed(double from, double to) const {
    double peak = 0;
    for (auto i = static_cast<std::size_t>(from / kTick);
         i < std::min(velocities.size(), static_cast<std::size_t>(to / kTick)); ++i) {
      peak = std::max(peak, velocities[i].norm());
    }
    return peak;
  }

 private:
  struct Parcel {
    long due;
    ContactPacket packet;
  };

  void move(const Eigen::Vector3d& force) {
    const double step = kTick / kSubsteps;
    for (int i = 0; i < kSubsteps; ++i) {
      Eigen::Vector3d sum = force + push - plant.damping * plant.velocity;
      if (plant.has_hand) {
        sum += kHandStiffness * (target - plant.position) +
               kHandDamping * (target_velocity - plant.velocity);
      }
      if (plant.is_guided) {
        sum.x() = sum.z() = 0;
      }
      const Eigen::Vector3d before = plant.velocity;
      plant.velocity += step / plant.mass * sum;
      const Eigen::Vector3d way = step * plant.velocity;
      plant.position += way;
      work += force.dot(way);
      dissipation += plant.damping * before.dot(way);
      surplus = std::max(surplus, work - dissipation);
    }
  }

  long ticks_ = 0;
  std::uint64_t sequence_ = 0;
  std::deque<Parcel> way_;
  ContactPacket packet_;
};

/// N/ms, of a record, largest and that which one tick in a thousand exceeds.
struct Steps {
  double largest = 0, p999 = 0;
};
inline Steps steps_of(const std::vector<Eigen::Vector3f>& forces) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < forces.size(); ++i) {
    steps.push_back(static_cast<double>((forces[i] - forces[i - 1]).norm()));
  }
  std::sort(steps.begin(), steps.end());
  return {steps.back(), steps[static_cast<std::size_t>(0.999 * static_cast<double>(steps.size()))]};
}

/// Tissue below y = 0 that does not give: a plane as stiff as the servo lets it be.
inline FakeTissue hard_wall() {
  return [](ContactPacket& packet, double) {
    packet.plane_count = 1;
    packet.planes[0] = {.normal = {0, 1, 0}, .stiffness = 1000};
    packet.force = packet_vector(plane_force(packet, pose_of(packet)));
  };
}

/// Tissue below y = 0 that gives as a spring does, N/m, and is thought to be as stiff as
/// `expected`.
inline FakeTissue soft_wall(float stiffness, float expected) {
  return [=](ContactPacket& packet, double) {
    const float height = packet.position[1];
    packet.plane_count = 1;
    packet.planes[0] = {.normal = {0, 1, 0}, .offset = std::min(0.0F, height)};
    packet.force = {0, stiffness * std::max(0.0F, -height), 0};
    fit_to_force(packet, expected);
  };
}

inline constexpr double kEngaged = 1.3;  ///< s: by then a tool in the air is let in
inline constexpr double kAbove = 1e-3;   ///< m over the tissue: where tools begin

/// A plant, and how late packets are.
struct Case {
  Plant plant;
  int delay = 0;  ///< ms
};

/// Those of the research: 30 to 60 g, 0.1 to 1 N s/m, 0 to 20 ms, with and without a hand.
/// @param least_damping  N s/m, of those that are taken
inline std::vector<Case> plant_grid(double least_damping) {
  std::vector<Case> cases;
  for (const double mass : {0.03, 0.045, 0.06}) {
    for (const double damping : {0.1, 0.3, 1.0}) {
      for (const int delay : {0, 10, 20}) {
        for (const bool has_hand : {false, true}) {
          if (damping >= least_damping) {
            cases.push_back({{.mass = mass,
                              .damping = damping,
                              .has_hand = has_hand,
                              .position = {0, kAbove, 0}},
                             delay});
          }
        }
      }
    }
  }
  return cases;
}

/// From the air into the tissue: with 0.5 N, or by a hand that wants to be 6 mm deep.
inline Rig pushed(const Case& one, const FakeTissue& tissue, const ServoOptions& options = {},
                  int period = 10, double seconds = 12) {
  Rig rig(one.plant, tissue, options);
  rig.delay = one.delay;
  rig.period = period;
  rig.target = {0, kAbove, 0};
  rig.run(kEngaged);
  if (one.plant.has_hand) {
    rig.target = {0, -6e-3, 0};
  } else {
    rig.push = {0, -0.5, 0};
  }
  rig.run(seconds);
  return rig;
}

/// Of 12 s: whether the plant is at rest in the end, or comes to rest.
inline bool settles(const Rig& rig) {
  const double late = rig.peak_speed(kEngaged + 10, kEngaged + 12);
  return late < 3e-3 || late < 0.7 * rig.peak_speed(kEngaged + 4, kEngaged + 6);
}

/// N/m, as felt after the motion has ended.
inline double felt_stiffness(const Rig& rig) {
  constexpr std::size_t kLast = 1000;
  double force = 0, depth = 0;
  for (std::size_t i = rig.commanded.size() - kLast; i < rig.commanded.size(); ++i) {
    force += static_cast<double>(rig.commanded[i].y());
    depth -= rig.positions[i].y();
  }
  return force / depth;
}

/// A hand on a way.
/// @param way  m, of seconds since the call
template <class Way>
void guide(Rig& rig, double seconds, Way way) {
  const double begin = rig.time;
  for (long n = std::lround(seconds / Rig::kTick); n > 0; --n) {
    const Eigen::Vector3d before = rig.target;
    rig.target = way(rig.time - begin);
    rig.target_velocity = (rig.target - before) / Rig::kTick;
    rig.tick();
  }
  rig.target_velocity.setZero();
}

/// A device in a hand above the tissue, with force let in.
inline Rig in_the_air(FakeTissue tissue, const ServoOptions& options = {}) {
  Rig rig({.has_hand = true, .position = {0, kAbove, 0}}, std::move(tissue), options);
  rig.delay = 10;
  rig.target = rig.plant.position;
  rig.run(kEngaged);
  return rig;
}

/// With a point on the plane.
inline ContactPlane plane_at(const Eigen::Vector3f& normal, const Eigen::Vector3f& on,
                             float stiffness) {
  return {.normal = packet_vector(normal), .offset = normal.dot(on), .stiffness = stiffness};
}

/// Only the nearest facet, as a coarse contact stage gives it: of a ball of 10 mm below y = 0.
inline FakeTissue faceted_ball(float stiffness) {
  return [=](ContactPacket& packet, double) {
    constexpr float kRadius = 0.01F, kFacet = 0.3F;  // m, rad
    const Eigen::Vector3f center(0, -kRadius, 0);
    const Eigen::Vector3f from = vector_of(packet.position) - center;
    const auto facet = [](float angle) { return std::round(angle / kFacet) * kFacet; };
    const float tilt = facet(std::atan2(from.x(), from.y()));
    const float turn = facet(std::atan2(from.z(), from.y()));
    const Eigen::Vector3f normal = Eigen::Vector3f(std::tan(tilt), 1, std::tan(turn)).normalized();
    packet.plane_count = 1;
    packet.planes[0] = plane_at(normal, center + kRadius * normal, stiffness);
    packet.force = packet_vector(plane_force(packet, pose_of(packet)));
  };
}

/// A hand slides over those facets, 2 mm deep at their top.
inline Rig over_facets(float stiffness, const ServoOptions& options = {}) {
  Rig rig = in_the_air(faceted_ball(stiffness), options);
  guide(rig, 10, [](double time) {
    return Eigen::Vector3d(8e-3 * std::sin(6 * time), -0.012, 8e-3 * std::sin(4.1 * time));
  });
  return rig;
}

/// Flat tissue under four points of a tool.
inline FakeTissue four_points() {
  return [](ContactPacket& packet, double) {
    packet.plane_count = 4;
    for (std::uint32_t i = 0; i < 4; ++i) {
      packet.planes[i] = {.point = {i % 2 == 0 ? 2e-3F : -2e-3F, 0, i < 2 ? 2e-3F : -2e-3F},
                          .normal = {0, 1, 0},
                          .stiffness = 180};
    }
    packet.force = packet_vector(plane_force(packet, pose_of(packet)));
  };
}

/// A sheet at y = 0 that a tool pushes 5 mm ahead of it, at 0.2 m/s, before it is through.
inline Rig through_sheet() {
  Rig rig = in_the_air([is_through = false](ContactPacket& packet, double) mutable {
    is_through = is_through || packet.position[1] < -5e-3F;
    packet.plane_count = is_through ? 0 : 1;
    packet.planes[0] = {.normal = {0, 1, 0}, .stiffness = 150};
    packet.force = packet_vector(plane_force(packet, pose_of(packet)));
  });
  guide(rig, 0.1, [](double time) { return Eigen::Vector3d(0, kAbove - 0.2 * time, 0); });
  rig.run(1);
  return rig;
}

/// A jaw closes, pulls by 12 mm, and loses what it holds in one of the ways.
inline Rig grasp_lost(GraspState how) {
  Rig rig = in_the_air([=](ContactPacket& packet, double time) {
    packet.grasp.state = time < kEngaged ? GraspState::open : GraspState::held;
    packet.grasp.state = time < kEngaged + 1 ? packet.grasp.state : how;
    packet.grasp.stiffness = 150;
    packet.force = packet_vector(grasp_force(packet.grasp, pose_of(packet)));
  });
  guide(rig, 0.5, [](double time) { return Eigen::Vector3d(0, kAbove + 0.022 * time, 0); });
  rig.run(0.62);  // 0.12 s beyond the loss, of which packets are late by 10 to 20 ms
  return rig;
}

}  // namespace pbdsurg::testing
