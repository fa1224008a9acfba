// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/length_unit.h"

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Units = std::vector<LengthUnit>;
constexpr LengthUnit kMm = LengthUnit::millimetre;
constexpr LengthUnit kCm = LengthUnit::centimetre;
constexpr LengthUnit kDm = LengthUnit::decimetre;
constexpr LengthUnit kM = LengthUnit::metre;

void check_guess(double side, LengthUnit unit, const Units& plausible) {
  INFO(side);
  const LengthUnitGuess guess = guess_length_unit(side);
  CHECK(guess.unit == unit);
  CHECK(guess.plausible == plausible);
  CHECK(guess.ambiguous() == (plausible.size() != 1));
}

}  // namespace

// Would catch a real artery of 12 mm, or a gallbladder in centimetres, that is taken for sure.
TEST_CASE("length unit: a guess is sure where one unit alone is plausible", "[unit]") {
  check_guess(0.09, kM, {kM});
  check_guess(0.005, kM, {kM});
  check_guess(0.49, kM, {kM});
  check_guess(0.6, kM, {kM, kCm});
  check_guess(1.9, kCm, {kCm, kDm});
  check_guess(0.81, kCm, {kCm, kDm});  // a gallbladder of 81 mm in dm is 8.1 mm in cm
  check_guess(12, kMm, {kMm, kCm});
  check_guess(9, kMm, {kMm, kCm});
  check_guess(60, kMm, {kMm, kCm});
  check_guess(61, kMm, {kMm});
  check_guess(600, kMm, {kMm});
}

TEST_CASE("length unit: where none is plausible, the nearest is named", "[unit]") {
  check_guess(0, kM, {});
  check_guess(0.0049, kM, {});
  check_guess(601, kMm, {});
  check_guess(190'000, kMm, {});
}

// Would catch an organ in decimetres that is stretched to metres or shrunk to centimetres.
TEST_CASE("length unit: what the organ is decides", "[unit]") {
  const LengthRange liver{0.08, 0.4};
  CHECK(guess_length_unit(12, {0.008, 0.075}).plausible == Units{kMm});
  CHECK(guess_length_unit(12, liver).plausible == Units{kCm});
  CHECK(guess_length_unit(1.9, liver).plausible == Units{kDm});
  CHECK(guess_length_unit(0.19, liver).plausible == Units{kM});
  CHECK(guess_length_unit(4.5, liver).ambiguous());
  CHECK(guess_length_unit(4.5, liver).unit == kCm);
}

// Would catch two vessels of one scan that are read in two units.
TEST_CASE("length unit: files of one run share one unit", "[unit]") {
  const std::vector<MeasuredLength> vessels{{12, kAnyOrgan}, {80, kAnyOrgan}};
  CHECK(guess_length_unit(vessels).plausible == Units{kMm});
  const std::vector<MeasuredLength> known{{12, {0.008, 0.075}}, {30, kAnyOrgan}};
  CHECK(guess_length_unit(known).plausible == Units{kMm});
  const std::vector<MeasuredLength> apart{{0.1, kAnyOrgan}, {100, kAnyOrgan}};
  CHECK(guess_length_unit(apart).plausible.empty());
}

TEST_CASE("length unit: units have names, sizes and readings", "[unit]") {
  CHECK(std::string(name_of(kDm)) == "dm");
  CHECK(metres_per(kDm) == 0.1);
  CHECK_THROWS_AS(metres_per(LengthUnit::automatic), InvalidArgument);
  CHECK(describe_length(0.012) == "12 mm");
  CHECK(describe_length(190) == "190 m");
  CHECK(describe_readings(12, Units{kMm, kCm}) == "12 mm if in mm, 120 mm if in cm");
}

}  // namespace pbdsurg
