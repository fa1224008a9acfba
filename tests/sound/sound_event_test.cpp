// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/sound_event.h"

#include <set>
#include <string>

#include "tests/support/catch.h"

namespace cholecystectomy {

// Catches an enumerator without a name, and a count that was not raised with a new one.
TEST_CASE("sound event: every tone and chime has a name of its own", "[unit]") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kToneCount; ++i) {
    names.insert(name_of(static_cast<Tone>(i)));
  }
  for (std::size_t i = 0; i < kChimeCount; ++i) {
    names.insert(name_of(static_cast<Chime>(i)));
  }
  CHECK(names.size() == kToneCount + kChimeCount);
  for (const std::string& name : names) {
    CHECK(name.find("unknown") == std::string::npos);
  }
  CHECK(std::string(name_of(static_cast<Tone>(kToneCount))) == "unknown tone");
  CHECK(std::string(name_of(static_cast<Chime>(kChimeCount))) == "unknown chime");
}

}  // namespace cholecystectomy
