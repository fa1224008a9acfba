// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/length_unit.h"

#include <algorithm>
#include <limits>

#include "pbdsurg/base/error.h"

#include "lib/base/describe.h"

namespace pbdsurg {
namespace {

bool fits(LengthUnit unit, std::span<const MeasuredLength> sides) {
  return std::all_of(sides.begin(), sides.end(), [unit](const MeasuredLength& side) {
    return side.expected.contains(side.longest_side * metres_per(unit));
  });
}

/// The largest factor between a side and the nearest end of its range.
double misfit(LengthUnit unit, std::span<const MeasuredLength> sides) {
  double worst = 1;
  for (const MeasuredLength& side : sides) {
    const double length = side.longest_side * metres_per(unit);
    const double factor = std::max(side.expected.shortest / length, length / side.expected.longest);
    worst = std::max(worst, factor);
  }
  return worst;
}

}  // namespace

const char* name_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::automatic:
      return "auto";
    case LengthUnit::millimetre:
      return "mm";
    case LengthUnit::centimetre:
      return "cm";
    case LengthUnit::decimetre:
      return "dm";
    case LengthUnit::metre:
      return "m";
  }
  return "";
}

double metres_per(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::millimetre:
      return 1e-3;
    case LengthUnit::centimetre:
      return 1e-2;
    case LengthUnit::decimetre:
      return 1e-1;
    case LengthUnit::metre:
      return 1;
    case LengthUnit::automatic:
      break;
  }
  throw InvalidArgument("'auto' is no unit of length: it must be mm, cm, dm or m");
}

bool LengthRange::contains(double length) const {
  // a side that is given as 60 cm must not miss 0.6 m by a rounding
  constexpr double kSlack = 1 + 8 * std::numeric_limits<double>::epsilon();
  return length * kSlack >= shortest && length <= longest * kSlack;
}

LengthUnitGuess guess_length_unit(std::span<const MeasuredLength> sides) {
  LengthUnitGuess guess{LengthUnit::metre, {}};
  const bool are_metres_plausible = fits(LengthUnit::metre, sides);
  for (const LengthUnit unit :
       {LengthUnit::millimetre, LengthUnit::metre, LengthUnit::centimetre, LengthUnit::decimetre}) {
    const bool is_overruled = unit == LengthUnit::decimetre && are_metres_plausible;
    if (!is_overruled && fits(unit, sides)) {
      guess.plausible.push_back(unit);
    }
  }
  if (!guess.plausible.empty()) {
    guess.unit = guess.plausible.front();
    return guess;
  }
  double least = misfit(guess.unit, sides);
  for (const LengthUnit unit : {LengthUnit::millimetre, LengthUnit::centimetre}) {
    const double candidate = misfit(unit, sides);
    if (candidate < least) {
      guess.unit = unit;
      least = candidate;
    }
  }
  return guess;
}

LengthUnitGuess guess_length_unit(double longest_side, LengthRange expected) {
  const MeasuredLength side{longest_side, expected};
  return guess_length_unit(std::span(&side, 1));
}

std::string describe_length(double metres) {
  return metres < 1 ? describe(metres / metres_per(LengthUnit::millimetre)) + " mm"
                    : describe(metres) + " m";
}

std::string describe_readings(double length, std::span<const LengthUnit> units) {
  std::string text;
  for (const LengthUnit unit : units) {
    text += (text.empty() ? "" : ", ") + describe_length(length * metres_per(unit)) + " if in " +
            name_of(unit);
  }
  return text;
}

}  // namespace pbdsurg
