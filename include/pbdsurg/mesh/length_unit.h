// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Units of length of mesh files, which do not name theirs.

#include <cstdint>

namespace pbdsurg {

enum class LengthUnit : std::uint8_t {
  automatic,  ///< guessed from the longest side: see guess_length_unit()
  millimetre,
  centimetre,
  metre
};

/// "mm", "cm", "m" or "auto".
[[nodiscard]] const char* name_of(LengthUnit unit);

/// Metres in one unit.
/// @throws InvalidArgument  for `automatic`, which is not a unit
[[nodiscard]] double metres_per(LengthUnit unit);

struct LengthUnitGuess {
  LengthUnit unit = LengthUnit::metre;
  bool ambiguous = false;  ///< another unit fits as well, or none does
};

/// Guesses the unit of an organ from the longest side of its bounding box: the one that makes the
/// side 0.02 m to 0.6 m long. Both centimetres and millimetres do so from 20 to 60; millimetres,
/// the more frequent unit, are taken then. Where none does, the nearest wins: metres up to
/// sqrt(0.6 * 2) = 1.1, centimetres up to 2, millimetres above 600.
///
/// @param longest_side  in the unknown unit, not negative
[[nodiscard]] LengthUnitGuess guess_length_unit(double longest_side);

}  // namespace pbdsurg
