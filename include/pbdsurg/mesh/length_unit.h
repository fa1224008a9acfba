// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Units of length of mesh files, most of which do not name theirs.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// What the coordinates of a file are in.
enum class LengthUnit : std::uint8_t {
  automatic,  ///< guessed from the longest side: see guess_length_unit()
  millimetre,
  centimetre,
  decimetre,
  metre
};

/// All units, without `automatic`.
inline constexpr std::array<LengthUnit, 4> kLengthUnits{
    LengthUnit::millimetre, LengthUnit::centimetre, LengthUnit::decimetre, LengthUnit::metre};

/// "mm", "cm", "dm", "m" or "auto".
[[nodiscard]] PBDSURG_API const char* name_of(LengthUnit unit);

/// Metres in one unit.
/// @throws InvalidArgument  for `automatic`, which is not a unit
[[nodiscard]] PBDSURG_API double metres_per(LengthUnit unit);

/// Lengths that something may have, ends included.
struct PBDSURG_API LengthRange {
  double shortest;  ///< m
  double longest;   ///< m

  /// Whether a length, m, lies within, but for rounding.
  [[nodiscard]] bool contains(double length) const;
};

/// The longest sides of what is operated on: from a short vessel to a trunk.
inline constexpr LengthRange kAnyOrgan{0.005, 0.6};

/// The size of one file, whose unit is not known, and the sizes that it may have.
struct MeasuredLength {
  double longest_side;               ///< of the bounding box, in the unknown unit; not negative
  LengthRange expected = kAnyOrgan;  ///< see plausible_length() for the organs of the anatomy
};

/// Which units the coordinates of files may be in.
struct LengthUnitGuess {
  LengthUnit unit;                    ///< the best guess, never `automatic`
  std::vector<LengthUnit> plausible;  ///< all that put every side into its range, the best first

  /// Whether the guess is none to rely on: several units would do, or none.
  [[nodiscard]] bool ambiguous() const { return plausible.size() != 1; }
};

/// Guesses the unit that several files share: one that puts every longest side into its range.
/// Where several do, millimetres are preferred, then metres: they are the most frequent.
/// Decimetres, the least frequent, are not considered where metres fit: every file of less than
/// 0.6 m would be in doubt. Where no unit fits at all, the one of millimetres, centimetres and
/// metres that misses the ranges by the least factor.
[[nodiscard]] PBDSURG_API LengthUnitGuess guess_length_unit(std::span<const MeasuredLength> sides);

/// The same for one file.
[[nodiscard]] PBDSURG_API LengthUnitGuess guess_length_unit(double longest_side,
                                                            LengthRange expected = kAnyOrgan);

/// A length for people, in millimetres or from 1 m on in metres: "12 mm", "190 m".
[[nodiscard]] PBDSURG_API std::string describe_length(double metres);

/// What a length would be in each of some units: "12 mm if in mm, 120 mm if in cm".
[[nodiscard]] PBDSURG_API std::string describe_readings(double length,
                                                        std::span<const LengthUnit> units);

}  // namespace pbdsurg
