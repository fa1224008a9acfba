// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/length_unit.h"

#include "pbdsurg/core/error.h"

namespace pbdsurg {

const char* name_of(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::automatic:
      return "auto";
    case LengthUnit::millimetre:
      return "mm";
    case LengthUnit::centimetre:
      return "cm";
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
    case LengthUnit::metre:
      return 1;
    case LengthUnit::automatic:
      break;
  }
  throw InvalidArgument("'auto' is no unit of length: it must be mm, cm or m");
}

LengthUnitGuess guess_length_unit(double longest_side) {
  constexpr double kShortest = 0.02;  // m
  constexpr double kLongest = 0.6;    // m
  // 1.1: where a side is as far from 0.6 m as from 2 cm, by ratio
  const LengthUnit unit = longest_side < 1.1  ? LengthUnit::metre
                          : longest_side < 20 ? LengthUnit::centimetre
                                              : LengthUnit::millimetre;
  int fitting = 0;
  for (const LengthUnit candidate :
       {LengthUnit::millimetre, LengthUnit::centimetre, LengthUnit::metre}) {
    const double side = longest_side * metres_per(candidate);
    fitting += side >= kShortest && side <= kLongest ? 1 : 0;
  }
  return {unit, fitting != 1};
}

}  // namespace pbdsurg
