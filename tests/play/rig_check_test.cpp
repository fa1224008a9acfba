// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/rig_check.h"

#include <algorithm>

#include "apps/hdapi/hdapi_device.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/temporary_folder.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::ContainsSubstring;
using Result = RigCheckLine::Result;

struct Person {
  std::vector<std::string> told;
  std::optional<bool> answer = true;

  [[nodiscard]] RigCheckHelp help() {
    return {[this](const std::string& text) { told.push_back(text); },
            [this](const std::string&) { return answer; }, [] { return "a loudspeaker"; },
            [] { return std::pair(12.5, std::string("a card")); }};
  }
};

std::vector<RigCheckLine> check(const std::string& devices, Person& person) {
  return check_rig({devices, true}, person.help());
}

Result result_of(const std::vector<RigCheckLine>& lines, const std::string& what) {
  const auto found = std::ranges::find(lines, what, &RigCheckLine::what);
  REQUIRE(found != lines.end());
  return found->result;
}

std::string rig_with(const pbdsurg::testing::TemporaryFolder& folder, const std::string& faults) {
  return folder
      .put("rig.json", R"({"emulated": true, "left": {"device": "arm", "name": "A"},
                           "right": {"device": "arm", "name": "B"}, "faults": [)" +
                           faults + "]}")
      .string();
}

}  // namespace

// Would catch a line that cannot pass, or emulated hands that do not do what a line asks.
TEST_CASE("rig check: emulated hands pass every line", "[unit]") {
  Person person;
  const std::vector<RigCheckLine> lines = check("emulator", person);
  for (const RigCheckLine& line : lines) {
    CAPTURE(line.what, line.detail);
    CHECK(line.result == Result::ok);
  }
  CHECK(lines.size() == 14);
  CHECK(person.told.size() == 10);  // a task a line that needs hands or feet
  const std::string sheet = sheet_of(lines, "emulator");
  CHECK_THAT(sheet, ContainsSubstring("14 ok, 0 failed, 0 not checked"));
  CHECK_THAT(sheet, ContainsSubstring("checked by ____"));
}

// Would catch an expectation that holds for one kind of rig alone.
TEST_CASE("rig check: other rigs pass, too", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  Person person;
  for (const char* const left :
       {R"("holds": "handle")", R"("motion_scale": 4)", R"("force_scale": 1)"}) {
    CAPTURE(left);
    const std::string rig =
        folder
            .put("rig.json", R"({"emulated": true, "left": {"device": "arm", "name": "A", )" +
                                 std::string(left) + R"(}, "right": {"device": "mouse"}})")
            .string();
    for (const RigCheckLine& line : check(rig, person)) {
      CAPTURE(line.what, line.detail);
      CHECK((line.result == Result::ok || line.what == "right hand: device"));
    }
  }
}

// Would catch a check that ends where a device is missing.
TEST_CASE("rig check: what does not open fails, and the rest goes on", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  Person person;
  const std::string rig = folder
                              .put("rig.json", R"({"emulated": true,
      "left": {"device": "arm", "name": "A"},
      "pedals": [{"keyboard": "/nowhere/pedals", "cut": 30, "coagulation": 48}]})")
                              .string();
  const std::vector<RigCheckLine> lines = check(rig, person);
  CHECK(result_of(lines, "pedals: keyboard") == Result::failed);
  CHECK(result_of(lines, "left hand: force") == Result::ok);
  CHECK(result_of(lines, "pedal: cut (yellow)") == Result::ok);  // the emulated one
}

// Would catch a line that cannot fail.
TEST_CASE("rig check: what is broken fails its line, and no other hand's", "[unit]") {
  const pbdsurg::testing::TemporaryFolder folder;
  Person person;
  const auto check_fault = [&](const std::string& fault, const std::string& what) {
    CAPTURE(fault);
    const std::vector<RigCheckLine> lines =
        check(rig_with(folder, R"({"fault": ")" + fault + R"(", "hand": "left", "begin_s": 0.05})"),
              person);
    CHECK(result_of(lines, "left hand: " + what) == Result::failed);
    CHECK(result_of(lines, "right hand: " + what) == Result::ok);
  };
  check_fault("unplugged", "moves its instrument alone");
  check_fault("unplugged", "force");
  check_fault("warm motors", "force");
  check_fault("stale packets", "force");
  check_fault("unplugged", "jaws");
}

// Would catch a guess in place of a person's word.
TEST_CASE("rig check: what nobody judged is not ok", "[unit]") {
  Person person;
  person.answer = std::nullopt;
  CHECK(result_of(check("emulator", person), "sound") == Result::not_checked);
  person.answer = false;
  CHECK(result_of(check("emulator", person), "sound") == Result::failed);
  const std::vector<RigCheckLine> lines = check("mouse", person);
  CHECK(result_of(lines, "left hand: device") == Result::not_checked);
  CHECK(result_of(lines, "pedals") == Result::not_checked);
}

TEST_CASE("rig check: real arms know no virtual time", "[unit]") {
  Person person;
  pbdsurg::testing::check_refused([&] { return check("openhaptics", person); }, "real time");
}

}  // namespace cholecystectomy
