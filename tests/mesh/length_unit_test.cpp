// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/length_unit.h"

#include "pbdsurg/core/error.h"

#include "support/catch.h"

namespace pbdsurg {

TEST_CASE("length unit: an organ's longest side tells its unit", "[unit]") {
  const auto guess = [](double side) { return guess_length_unit(side); };

  CHECK(guess(0.09).unit == LengthUnit::metre);
  CHECK(guess(9).unit == LengthUnit::centimetre);
  CHECK(guess(90).unit == LengthUnit::millimetre);
  CHECK(guess(30).unit == LengthUnit::millimetre);  // 30 cm would do as well
  CHECK(guess(0.7).unit == LengthUnit::metre);      // 0.7 m is nearer to an organ than 7 mm
  CHECK(guess(1.8).unit == LengthUnit::centimetre);
  CHECK(guess(5000).unit == LengthUnit::millimetre);
  CHECK(guess(0).unit == LengthUnit::metre);
  for (const double side : {0.02, 0.6, 2.0, 19.9, 60.1, 600.0}) {
    INFO(side);
    CHECK_FALSE(guess(side).ambiguous);
  }
  for (const double side : {0.0, 0.019, 0.61, 1.99, 20.0, 60.0, 601.0}) {
    INFO(side);
    CHECK(guess(side).ambiguous);
  }
  CHECK_THROWS_AS(metres_per(LengthUnit::automatic), InvalidArgument);
}

}  // namespace pbdsurg
