// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/rig_description.h"

#include <string>

#include "pbdsurg/haptics/device_trace.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/temporary_folder.h"

namespace rig {
namespace {

using pbdsurg::testing::ContainsSubstring;
using pbdsurg::testing::TemporaryFolder;

std::string trace_in(const TemporaryFolder& folder) {
  pbdsurg::DeviceTrace trace;
  trace.name = "hand";
  trace.samples.resize(1);
  const std::filesystem::path path = folder / "hand.trace";
  pbdsurg::write_device_trace(path, trace);
  return path.string();
}

void check_file_refused(const std::string& json, const std::string& what) {
  const TemporaryFolder folder;
  const std::string path = folder.put("rig.json", json).string();
  CHECK_THROWS_AS(read_rig(path), pbdsurg::FileError);
  CHECK_THROWS_WITH(read_rig(path), ContainsSubstring(what));
}

}  // namespace

// Would catch hands that are exchanged, or a word that is of one hand only.
TEST_CASE("rig description: words", "[unit]") {
  CHECK(!read_rig("mouse").has(Mover::arm));
  const RigDescription arms = read_rig("openhaptics");
  CHECK(arms.hand(Side::left).arm_name == "Left Device");
  CHECK(arms.hand(Side::right).arm_name == "Right Device");
  CHECK(!arms.is_emulated);
  CHECK(read_rig("emulator").is_emulated);
  const RigDescription one = read_rig("openhaptics,mouse");
  CHECK(one.hand(Side::left).mover == Mover::arm);
  CHECK(one.hand(Side::left).arm_name.empty());  // the default device
  CHECK(one.hand(Side::right).mover == Mover::mouse);

  const TemporaryFolder folder;
  const std::string trace = trace_in(folder);
  CHECK(read_rig(trace).hand(Side::right).trace == trace);
  CHECK(read_rig(trace).hand(Side::left).mover == Mover::mouse);
  CHECK(read_rig(trace + ",emulator").hand(Side::left).mover == Mover::trace);
}

// Would catch a key that is read into another place.
TEST_CASE("rig description: a file", "[unit]") {
  const TemporaryFolder folder;
  static_cast<void>(trace_in(folder));
  const RigDescription rig = read_rig(folder
                                          .put("rig.json", R"({
    "emulated": true,
    "left": {"device": "arm", "name": "A", "serial_number": "7", "holds": "handle",
             "motion_scale": 2, "force_scale": 0.5, "firm": true, "servo": "paper",
             "handle": {"port": "/dev/ttyACM3", "closed": 100, "open": 60000}},
    "right": {"device": "hand.trace"},
    "pedals": [{"keyboard": "/dev/input/by-id/pedals", "cut": 30, "coagulation": 48}],
    "faults": [{"fault": "unplugged", "hand": "left", "begin_s": 4, "duration_s": 1}]})")
                                          .string());
  const HandDescription& left = rig.hand(Side::left);
  CHECK(left.arm_name == "A");
  CHECK(left.serial_number == "7");
  CHECK(left.held == pbdsurg::HeldPart::handle);
  CHECK(left.motion_scale == 2);
  CHECK(left.force_scale == 0.5F);
  CHECK(left.is_firm);
  CHECK(left.servo == pbdsurg::ServoMode::paper);
  REQUIRE(left.handle);
  CHECK(left.handle->port == "/dev/ttyACM3");
  CHECK(left.handle->range == pbdsurg::JawRange{100, 60000});
  CHECK(rig.hand(Side::right).trace == folder / "hand.trace");  // beside the rig's file
  REQUIRE(rig.pedals.size() == 1);
  CHECK(rig.pedals[0].keys.coagulation == 48);
  REQUIRE(rig.faults.size() == 1);
  CHECK(rig.faults[0].fault == "unplugged");
  CHECK(rig.faults[0].begin == 4);
}

TEST_CASE("rig description: what is refused", "[unit]") {
  pbdsurg::testing::check_refused([] { return read_rig("mouse,mouse,mouse"); }, "two hands");
  pbdsurg::testing::check_refused([] { return read_rig("openhaptics,emulator"); }, "not both");
  pbdsurg::testing::check_refused([] { return read_rig("mouse,nonsense"); }, "nonsense");
  CHECK_THROWS_WITH(read_rig("no_such_file"), ContainsSubstring("no_such_file"));
  check_file_refused("no json", "JSON");
  check_file_refused("[]", "JSON object");
  check_file_refused(R"({"middle": {}})", "middle");
  check_file_refused(R"({"left": {"device": "arm", "motion_scale": 0}})", "motion_scale");
  check_file_refused(R"({"left": {"device": "arm", "force_scale": "much"}})", "much");
  check_file_refused(R"({"left": {"device": "arm", "firm": 1}})", "true or false");
  check_file_refused(R"({"left": {"device": "arm", "holds": "stylus"}})", "\"tip\"");
  check_file_refused(R"({"left": {"device": "arm", "handle": {"closed": 1}}})", "port");
  check_file_refused(R"({"left": {"device": "mouse", "name": "A"}})", "name");
  check_file_refused(R"({"left": {"device": "away.trace"}})", "away.trace");
  check_file_refused(R"({"pedals": {}})", "a list");
  check_file_refused(R"({"pedals": [{"keyboard": "k", "cut": 1.5}]})", "whole number");
  check_file_refused(R"({"faults": [{"fault": "unplugged"}]})", "only emulated arms");
}

}  // namespace rig
