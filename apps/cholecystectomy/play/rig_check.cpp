// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/rig_check.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/version.h"
#include "pbdsurg/haptics/servo.h"

#include "apps/cholecystectomy/interruption.h"
#include "apps/cholecystectomy/play/places.h"
#include "apps/rig/rig.h"

namespace cholecystectomy {
namespace {

using Eigen::Vector3f;
using rig::kSides;
using rig::Mover;
using rig::Side;
using Result = RigCheckLine::Result;

constexpr double kPatience = 20;      // s, for a person to do what a line asks
constexpr double kPeriod = 0.01;      // s, of packets
constexpr float kMove = 0.03F;        // m, that a hand shall move
constexpr float kStill = 0.01F;       // m, that the other may meanwhile
constexpr float kPress = 0.3F;        // N, that shall be felt
constexpr double kMostPicture = 100;  // ms
constexpr float kTremor = 2e-3F;      // m, of a hand that holds still
constexpr int kStillPasses = 30;

std::size_t index_of(Side side) {
  return static_cast<std::size_t>(side);
}

class Check {
 public:
  Check(const RigCheckOptions& options, const RigCheckHelp& help)
      : help_(help),
        description_(rig::read_rig(options.devices)),
        has_virtual_time_(options.has_virtual_time) {
    open();
  }

  std::vector<RigCheckLine> run() {
    for (const Side side : kSides) {
      check_device(side);
    }
    for (const Side side : kSides) {
      if (is_arm(side)) {
        check_calibration(side);
      }
    }
    for (const Side side : kSides) {
      if (is_arm(side)) {
        check_side(side);
        check_force(side);
        check_jaw(side);
      }
    }
    check_pedals();
    check_sound();
    check_pictures();
    return std::move(lines_);
  }

 private:
  [[nodiscard]] pbdsurg::Clock& clock() { return rig_->clock(); }

  // Opens what there is: what does not open is a line, and the rest goes on without.
  void open() {
    pbdsurg::RealClock probe_clock;
    const auto try_part = [&](const std::string& what, auto&& make) {
      try {
        make();
        return true;
      } catch (const pbdsurg::InvalidArgument&) {
        throw;  // of the options, not of a device
      } catch (const pbdsurg::Error& error) {
        note(what, false, error.what());
        return false;
      }
    };
    const auto try_rig = [&](const std::string& what, const rig::RigDescription& description) {
      return try_part(what, [&] {
        rig_.reset();
        rig_ = std::make_unique<rig::Rig>(description, places_, has_virtual_time_);
      });
    };
    std::erase_if(description_.pedals, [&](const rig::PedalsDescription& pedals) {
      return !try_part("pedals: keyboard", [&] {
        static_cast<void>(pbdsurg::PedalKeyboard(pedals.keyboard, pedals.keys, probe_clock));
      });
    });
    for (const Side side : kSides) {
      rig::HandDescription& hand = description_.hands[index_of(side)];
      if (hand.handle && !try_part(text("%s hand: handle", rig::name_of(side)), [&] {
            static_cast<void>(pbdsurg::Handle(hand.handle->port, hand.handle->range, probe_clock));
          })) {
        hand.handle.reset();
      }
    }
    if (is_arm(Side::left) && is_arm(Side::right)) {  // one by one, so that one has a name
      for (const Side side : kSides) {
        rig::RigDescription alone = description_;
        alone.pedals.clear();
        alone.faults.clear();
        rig::HandDescription& other = alone.hands[1 - index_of(side)];
        other = rig::HandDescription();
        alone.hands[index_of(side)].handle.reset();
        if (!try_rig(text("%s hand: device", rig::name_of(side)), alone)) {
          description_.hands[index_of(side)] = rig::HandDescription();
        }
      }
    }
    if (!try_rig("devices", description_)) {
      rig_.reset();
      description_ = rig::RigDescription();
      rig_ = std::make_unique<rig::Rig>(description_, places_, has_virtual_time_);
    }
    rig_->begin({});
  }

  [[nodiscard]] bool is_arm(Side side) const { return description_.hand(side).mover == Mover::arm; }

  void note(const std::string& what, Result result, const std::string& detail) {
    lines_.push_back({what, result, detail});
  }
  void note(const std::string& what, bool is_fine, const std::string& detail) {
    note(what, is_fine ? Result::ok : Result::failed, detail);
  }

  template <class... Values>
  static std::string text(const char* format, Values... values) {
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
  }

  // Lets a hundredth of a second pass, with a packet for each hand.
  void pass() {
    for (const Side side : kSides) {
      states_[index_of(side)] = rig_->device(side).state();
      publish_wall(side);
    }
    pedals_ = rig_->feet().state().pedals;
    if (is_interrupted()) {
      throw pbdsurg::Error("interrupted");  // force goes to zero on the way out
    }
    if (has_virtual_time_) {
      for (int tick = 0; tick < 10; ++tick) {
        rig_->tick();
      }
    } else {
      clock().wait_until(clock().now() + kPeriod);
    }
    rig_->poll();
  }

  // Passes time until something is so, or patience is over.
  template <class Condition>
  bool await(Condition condition, double seconds = kPatience) {
    for (const double end = clock().now() + seconds; clock().now() < end;) {
      pass();
      if (condition()) {
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] Vector3f tip(Side side) const { return states_[index_of(side)].pose.translation(); }

  // Felt stiffness over the scene's.
  [[nodiscard]] float scale_of(Side side) const {
    const rig::HandDescription& hand = description_.hand(side);
    return hand.force_scale * hand.motion_scale;
  }

  // Where a force on the tip that points up is felt to point: unit.
  [[nodiscard]] Vector3f felt_up(Side side) const {
    const Vector3f up = places_.axes.col(1);
    if (description_.hand(side).held == pbdsurg::HeldPart::tip) {
      return up;
    }
    const Vector3f& port = places_.ports[index_of(side)];
    const Vector3f way = port - tip(side);
    const float outside = pbdsurg::InstrumentMappingOptions().shaft_length - way.norm();
    const Vector3f handle =
        port + std::max(outside, pbdsurg::InstrumentMapping::kLeastDistance) * way.normalized();
    return (pbdsurg::lever_about_port(port, handle, tip(side)).transpose() * up).normalized();
  }

  void publish_wall(Side side) {
    const Vector3f up = places_.axes.col(1);
    pbdsurg::ContactPacket packet;
    packet.sequence = ++sequence_;
    packet.time = clock().now();
    pbdsurg::set_pose(packet, states_[index_of(side)].pose);
    const float depth = walls_[index_of(side)] ? *walls_[index_of(side)] - up.dot(tip(side)) : -1;
    // springs of the hand, whatever the scale of its forces
    const float stiffness = pbdsurg::kLeastStiffness / std::max(scale_of(side), 1e-3F);
    packet.planes[0] = {.normal = pbdsurg::packet_vector(up),
                        .offset = up.dot(tip(side)) + depth,
                        .stiffness = stiffness};
    packet.plane_count = 1;
    packet.force = pbdsurg::packet_vector(stiffness * std::max(depth, 0.0F) * up);
    rig_->publish(side, packet);
  }

  // Emulated hands go to places beside their first, so many seconds each.
  void rehearse(Side side, const std::vector<Vector3f>& ways, double seconds, float jaw = 1,
                const pbdsurg::Pedals& pedals = {}) {
    std::vector<pbdsurg::Waypoint> waypoints;
    for (const Vector3f& way : ways) {
      waypoints.push_back({.time = seconds * static_cast<double>(waypoints.size()),
                           .tip = places_.tips[index_of(side)] + places_.axes * way,
                           .jaw = jaw,
                           .pedals = pedals});
    }
    std::array<std::vector<pbdsurg::Waypoint>, 2> scripts;
    scripts[index_of(side)] = std::move(waypoints);
    rig_->rehearse(scripts);
  }

  void check_device(Side side) {
    const std::string what = text("%s hand: device", rig::name_of(side));
    const Mover mover = description_.hand(side).mover;
    if (mover == Mover::mouse) {
      note(what, Result::not_checked, "mouse: needs the window");
      return;
    }
    const bool is_there = await([&] { return states_[index_of(side)].is_connected; }, 3);
    std::string detail = rig_->device(side).name();
    if (const rig::HdapiLimits* const limits = rig_->limits(side)) {
      detail += text(", serial %s, %.1f N, %.2f N for long", limits->serial_number.c_str(),
                     static_cast<double>(limits->max_force),
                     static_cast<double>(limits->max_continuous_force));
    }
    note(what, is_there, detail);
  }

  void check_calibration(Side side) {
    const auto is_done = [&] {
      return rig_->status(side).arm.calibration == rig::HdapiCalibration::done;
    };
    const std::string what = text("%s hand: calibration", rig::name_of(side));
    if (!await(is_done, 3)) {
      help_.tell(text("Park the %s stylus in its inkwell, and take it out.", rig::name_of(side)));
    }
    const bool is_fine = await(is_done);
    note(what, is_fine, is_fine ? "done" : "not calibrated: there will be no force");
  }

  // Whether devices are in the hands that they are named for.
  void check_side(Side side) {
    pass();
    const std::array<Vector3f, 2> before{tip(Side::left), tip(Side::right)};
    help_.tell(
        text("Move the %s instrument up and down by 5 cm; leave the other.", rig::name_of(side)));
    rehearse(side, {{0, 0, 0}, {0, 1.5F * kMove, 0}, {0, 0, 0}}, 0.5);
    std::array<float, 2> moved{};
    const bool has_moved = await([&] {
      for (const Side each : kSides) {
        moved[index_of(each)] =
            std::max(moved[index_of(each)], (tip(each) - before[index_of(each)]).norm());
      }
      return moved[index_of(side)] > kMove;
    });
    const float other = moved[1 - index_of(side)];
    note(text("%s hand: moves its instrument alone", rig::name_of(side)),
         has_moved && other < kStill,
         text("%.0f mm, the other %.0f mm", 1e3 * static_cast<double>(moved[index_of(side)]),
              1e3 * static_cast<double>(other)));
  }

  void check_force(Side side) {
    const std::string what = text("%s hand: force", rig::name_of(side));
    walls_[index_of(side)].reset();
    help_.tell(
        text("Hold the %s instrument still in the air: force is let in.", rig::name_of(side)));
    Vector3f still = tip(side);
    int still_passes = 0;
    const auto is_engaged = [&] {
      still_passes = (tip(side) - still).norm() < kTremor ? still_passes + 1 : 0;
      still = still_passes > 0 ? still : tip(side);
      return still_passes > kStillPasses && rig_->status(side).servo.engaged >= 1;
    };
    if (!await(is_engaged)) {
      note(what, false, "was not let in");
      return;
    }
    const float scale = description_.hand(side).motion_scale;
    walls_[index_of(side)] = places_.axes.col(1).dot(tip(side)) - scale * 0.01F;
    help_.tell(
        text("Press the tip of the %s instrument down on a soft wall 1 cm below, and lift "
             "it again.",
             rig::name_of(side)));
    rehearse(side, {{0, 0, 0}, {0, -0.02F * scale, 0}, {0, -0.02F * scale, 0}, {0, 0, 0}}, 0.5);
    float most = 0, worst_step = 0, sideways = 0;
    Vector3f last = rig_->status(side).servo.force.commanded;
    const auto watch = [&] {
      const Vector3f force = rig_->status(side).servo.force.commanded, up = felt_up(side);
      most = std::max(most, up.dot(force));
      sideways = std::max(sideways, (force - up.dot(force) * up).norm());
      worst_step = std::max(worst_step, (force - last).norm());
      last = force;
      return force.norm();
    };
    const bool is_felt = await([&] { return watch() > kPress; });
    const bool is_gone = is_felt && await([&] { return watch() < 0.01F; });
    walls_[index_of(side)].reset();
    note(what, is_felt && is_gone && sideways < 0.5F * most,
         text("up to %.2f N against the press, %.2f N aside, changes of %.2f N in 10 ms%s",
              static_cast<double>(most), static_cast<double>(sideways),
              static_cast<double>(worst_step),
              is_gone   ? ""
              : is_felt ? ", did not go to zero"
                        : ", was not felt"));
  }

  void check_jaw(Side side) {
    const std::string what = text("%s hand: jaws", rig::name_of(side));
    pbdsurg::Handle* const handle = rig_->handle(side);
    help_.tell(text(handle != nullptr ? "Close the %s handle, and open it."
                                      : "Press the first button of the %s stylus, and let it go.",
                    rig::name_of(side)));
    rehearse(side, {{0, 0, 0}}, 1, 0);
    pbdsurg::JawCalibration calibration;
    const auto learn = [&] {
      if (handle != nullptr && handle->report()) {
        calibration.add(handle->report()->jaw);
      }
    };
    const bool closes = await([&] {
      learn();
      return states_[index_of(side)].jaw <= 0;
    });
    rehearse(side, {{0, 0, 0}}, 1, 1);
    const bool opens = closes && await([&] {
                         learn();
                         return states_[index_of(side)].jaw >= 1;
                       });
    std::string detail = closes ? opens ? "close and open" : "do not open" : "do not close";
    if (handle != nullptr) {
      try {
        const pbdsurg::JawRange range = calibration.range();
        detail += text("; \"closed\": %d, \"open\": %d", range.closed, range.open);
      } catch (const pbdsurg::Error&) {
        detail += "; the sensor hardly moved";
      }
    }
    note(what, opens, detail);
  }

  void check_pedals() {
    if (description_.pedals.empty() && !description_.is_emulated) {
      note("pedals", Result::not_checked, "none in the rig's file");
      return;
    }
    const Side script = is_arm(Side::right) ? Side::right : Side::left;
    const auto check = [&](const char* name, const pbdsurg::Pedals& wanted) {
      help_.tell(text("Press the %s pedal, and let it go.", name));
      rehearse(script, {{0, 0, 0}}, 1, 1, wanted);
      const bool is_down = await([&] { return pedals_ == wanted; });
      rehearse(script, {{0, 0, 0}}, 1);
      const bool is_up = is_down && await([&] { return pedals_ == pbdsurg::Pedals{}; });
      note(text("pedal: %s", name), is_up,
           is_up     ? "down and up"
           : is_down ? "does not come up"
                     : "not heard");
    };
    check("cut (yellow)", {.cut = true});
    check("coagulation (blue)", {.coagulation = true});
  }

  void check_sound() {
    const std::string device = help_.sound();
    const std::optional<bool> is_heard = help_.ask("Did you hear two tones and a chime?");
    note("sound",
         !is_heard   ? Result::not_checked
         : *is_heard ? Result::ok
                     : Result::failed,
         device);
  }

  void check_pictures() {
    const auto drawn = help_.draw();
    if (!drawn) {
      note("pictures", Result::not_checked, "nothing draws here");
    } else {
      note("pictures", drawn->first < kMostPicture,
           text("%.1f ms by %s", drawn->first, drawn->second.c_str()));
    }
  }

  const RigCheckHelp& help_;
  rig::RigDescription description_;
  bool has_virtual_time_;
  rig::RigPlaces places_ = hand_places();
  std::unique_ptr<rig::Rig> rig_;
  std::array<pbdsurg::DeviceState, 2> states_;
  pbdsurg::Pedals pedals_;
  std::array<std::optional<float>, 2> walls_;  // m, along up
  std::uint64_t sequence_ = 0;
  std::vector<RigCheckLine> lines_;
};

}  // namespace

std::vector<RigCheckLine> check_rig(const RigCheckOptions& options, const RigCheckHelp& help) {
  return Check(options, help).run();
}

std::string sheet_of(const std::vector<RigCheckLine>& lines, const std::string& devices) {
  std::array<char, 400> text{};
  const std::time_t now = std::time(nullptr);
  std::array<char, 32> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%d %H:%M", std::localtime(&now));
  std::string sheet = std::string("\nRig check of ") + date.data() + ", pbdsurg " +
                      pbdsurg::build_id() + "\ndevices: " + devices + "\n\n";
  std::array<int, 3> counts{};
  constexpr std::array kResults{"ok", "FAILED", "not checked"};
  for (const RigCheckLine& line : lines) {
    const std::size_t result = static_cast<std::size_t>(line.result);
    ++counts[result];
    std::snprintf(text.data(), text.size(), "  %-12s %-36s %s\n", kResults[result],
                  line.what.c_str(), line.detail.c_str());
    sheet += text.data();
  }
  std::snprintf(text.data(), text.size(),
                "\n%d ok, %d failed, %d not checked\n\nchecked by ______________________   date "
                "______________\n",
                counts[0], counts[1], counts[2]);
  return sheet + text.data();
}

}  // namespace cholecystectomy
