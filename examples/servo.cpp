// SPDX-License-Identifier: Apache-2.0
// A device of your own feels liver: its servo at 1 kHz, the simulation at 100 Hz.
#include "pbdsurg/haptics/servo.h"

#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/haptics/device.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/world/world.h"

namespace {

using pbdsurg::ContactPacket;

// Yours reads encoders and writes motors. This one is a hand that goes 5 mm deep and comes back.
class MyArm final : public pbdsurg::Device {
 public:
  explicit MyArm(const pbdsurg::Clock& clock) : clock_(clock) {}
  [[nodiscard]] std::string name() const override { return "my arm"; }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override {
    const double time = clock_.now();
    const double phase =
        time < 1.5 ? 0 : time - 1.5;  // s: force is let in while nothing is touched
    pbdsurg::DeviceState state{.time = time};
    state.pose.translation().y() = static_cast<float>(4e-3 + 5.5e-3 * (std::cos(phase) - 1));
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override { force_ = force; }
  [[nodiscard]] const Eigen::Vector3f& force() const { return force_; }

 private:
  const pbdsurg::Clock& clock_;
  Eigen::Vector3f force_ = Eigen::Vector3f::Zero();
};

}  // namespace

int main() try {
  pbdsurg::TetrahedralizeOptions options;
  options.spacing = 4e-3;  // m
  const pbdsurg::ImplicitShape box =
      pbdsurg::rounded_box_shape({0, -0.015, 0}, {0.03, 0.015, 0.03}, 2e-3);  // its top at y = 0
  pbdsurg::World world;
  const pbdsurg::BodyId liver = world.add_body("liver", pbdsurg::tetrahedralize(box, options).mesh,
                                               pbdsurg::tissues::liver());
  world.fix(liver, [](const Eigen::Vector3d& x) { return x.y() < -0.028; });

  constexpr float kRadius = 4e-3F;  // m, of the tool's tip
  const Eigen::Vector3f center(0, kRadius, 0);
  const pbdsurg::ToolId tool = world.add_tool({{center, center, kRadius}});
  const std::vector<pbdsurg::Index> bodies{world.body_in_tissue(liver)};
  const std::vector<pbdsurg::ToolPoint> points{{center, kRadius}};
  pbdsurg::ContactProbe probe(world.solver(), bodies, points);

  pbdsurg::VirtualClock clock;  // RealClock, and a thread for each half of the loop, on a rig
  MyArm arm(clock);
  pbdsurg::Mailbox<ContactPacket> mailbox;  // from the simulation's thread to the servo's
  pbdsurg::ServoState servo({.limits = pbdsurg::limits_of_motors(3.3F, 0.88F)});
  for (int tick = 0; tick < 8000; ++tick) {
    const pbdsurg::DeviceState hand = arm.state();
    if (tick % 10 == 0) {  // the simulation
      world.move(tool, hand.pose);
      if (const pbdsurg::Frame frame = world.step(0.01); !frame.ok()) {
        throw pbdsurg::Error(frame.why());
      }
      mailbox.draft() = pbdsurg::make_contact_packet(
          probe, world.solver(), tool, pbdsurg::GraspState::open, tick + 1ULL, hand.time);
      mailbox.publish();
    }
    mailbox.take();  // the servo
    const pbdsurg::ServoForce force =
        pbdsurg::servo_tick(servo, mailbox.value(),
                            {.time = hand.time, .tip = hand.pose, .is_ready = hand.is_connected});
    arm.set_force(force.commanded);
    if (tick % 1000 == 0) {
      std::printf("%d s, height %4.1f mm: %.3f N, in the simulation %.3f N\n", tick / 1000,
                  1e3F * hand.pose.translation().y(), arm.force().y(), world.force(tool).y());
    }
    clock.advance(1e-3);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "servo: %s\n", error.what());
  return 2;
}
