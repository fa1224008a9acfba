// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/device.h"

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a generator that coagulates while a foot is on both pedals.
TEST_CASE("device: a pedal counts alone, both together are none", "[unit]") {
  CHECK(activation_of({}) == Activation::none);
  CHECK(activation_of({.cut = true}) == Activation::cut);
  CHECK(activation_of({.coagulation = true}) == Activation::coagulation);
  CHECK(activation_of({true, true}) == Activation::none);
}

}  // namespace pbdsurg
