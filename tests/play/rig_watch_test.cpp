// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/rig_watch.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::ContainsSubstring;
using rig::DeviceFault;
using rig::HandStatus;
using rig::Side;

HandStatus calibrated_arm() {
  HandStatus status;
  status.name = "Touch";
  status.mover = rig::Mover::arm;
  status.arm.calibration = rig::HdapiCalibration::done;
  status.servo.engaged = 1;
  return status;
}

}  // namespace

// Would catch news that is told again with each picture, of the other hand, or not at all.
TEST_CASE("rig watch: what happens is told once", "[unit]") {
  RigWatch watch(kEnglish);
  HandStatus status = calibrated_arm();
  CHECK(watch.update(Side::left, status).empty());
  const auto check = [&](const char* words) {
    const std::vector<std::string> news = watch.update(Side::left, status);
    REQUIRE(news.size() == 1);
    CHECK_THAT(news[0], ContainsSubstring(words));
    CHECK_THAT(news[0], ContainsSubstring("left"));
    CHECK(watch.update(Side::left, status).empty());
    CHECK(watch.update(Side::right, calibrated_arm()).empty());
  };
  status.servo.time = 5;
  status.arm.faults.add(DeviceFault::warm_motors);
  check("warm");
  for (int picture = 0; picture < 120; ++picture) {  // as long as they are warm, in each tick
    status.servo.time += 1.0 / 60;
    status.arm.faults.add(DeviceFault::warm_motors, 16);
    CHECK(watch.update(Side::left, status).empty());
  }
  status.servo.time += 5;
  status.arm.faults.add(DeviceFault::warm_motors);
  check("warm");
  status.arm.faults.add(DeviceFault::stuck_calibration);
  check("does not calibrate");
  status.arm.calibration = rig::HdapiCalibration::needs_inkwell;
  check("inkwell");
  status.handle = pbdsurg::HandleCondition::lost;
  check("jaws open");
  status.handle = pbdsurg::HandleCondition::live;
  check("is back");
  status.is_connected = false;
  check("silent");
  status.arm.is_lost = true;
  check("without force");
}

// Would catch a recorded hand that ends unnoticed, or one that ends before it begins.
TEST_CASE("rig watch: a recorded hand comes to its end", "[unit]") {
  RigWatch watch(kEnglish);
  HandStatus status;
  status.mover = rig::Mover::trace;
  status.servo.tick_count = 5;
  CHECK(watch.update(Side::right, status).empty());
  status.is_connected = false;
  REQUIRE(watch.update(Side::right, status).size() == 1);
}

// Would catch a panel that says force is on where there is none.
TEST_CASE("rig watch: a line for the panel", "[unit]") {
  const RigWatch watch(kEnglish);
  HandStatus status = calibrated_arm();
  status.servo.force.commanded = {0, 0.6F, 0.8F};
  status.servo.force.computed = {0, 0, 2};
  const auto line = [&] { return watch.line(Side::right, status); };
  CHECK(line() == "right, Touch: 1.00 N of 2.00 N, force on");
  status.servo.engaged = 0.5F;
  CHECK_THAT(line(), ContainsSubstring("let in"));
  status.arm.calibration = rig::HdapiCalibration::under_way;
  CHECK_THAT(line(), ContainsSubstring("not calibrated"));
  status.is_connected = false;
  CHECK_THAT(line(), ContainsSubstring("not connected"));
  status.mover = rig::Mover::mouse;
  CHECK(line().empty());
}

}  // namespace cholecystectomy
