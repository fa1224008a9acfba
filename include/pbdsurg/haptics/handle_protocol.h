// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The lines that an instrument's handle sends over USB serial, version 1.
///
///     P1 001F 8A40 C000 01 92AA\n
///
/// | bytes  | holds       | meaning                                                          |
/// |--------|-------------|------------------------------------------------------------------|
/// | 0, 1   | `P1`        | start and version; no other byte of a line is a `P`              |
/// | 3-6    | sequence    | one more in each line, 0000 after FFFF                           |
/// | 8-11   | jaw         | the sensor as it reads, 0 to FFFF; a JawRange gives it a meaning |
/// | 13-16  | roll        | of the wheel, in 1/65536 of a turn, to the right; wraps          |
/// | 18, 19 | buttons     | bit i: button i is down                                          |
/// | 21-24  | checksum    | CRC-16/CCITT-FALSE of bytes 0 to 19                              |
/// | 25     | line feed   |                                                                  |
///
/// Numbers are hexadecimal, in capitals, and one space stands between fields: a report has one line
/// alone, so that a byte that changed on its way is seen in any field. The checksum (polynomial
/// x^16 + x^12 + x^5 + 1, start FFFF, no reflection, no final inversion) finds all changes of up to
/// three bits and all within 16 neighbouring bits. 100 lines a second are 2.6 kB/s, a quarter of
/// what 115,200 baud carry.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// What a handle says in one line.
struct HandleReport {
  std::uint16_t sequence = 0;  ///< one more in each line; wraps
  std::uint16_t jaw = 0;       ///< as the sensor reads
  std::uint16_t roll = 0;      ///< 1/65536 turn
  std::uint8_t buttons = 0;    ///< bit i: button i is down

  /// Whether both say the same.
  friend bool operator==(const HandleReport&, const HandleReport&) = default;
};

/// Why a line counts for nothing.
enum class HandleRefusal : std::uint8_t {
  none,       ///< it counts
  length,     ///< it is shorter or longer than a line is
  version,    ///< it does not start with P1
  character,  ///< a space, or a digit in capitals, is missing from its place
  checksum,   ///< its checksum is another
};

/// For a person: "its checksum is wrong".
[[nodiscard]] PBDSURG_API std::string_view describe(HandleRefusal refusal) noexcept;

/// Bytes of a line, with its line feed.
inline constexpr std::size_t kHandleLineLength = 26;

/// The line of a report, with its line feed.
[[nodiscard]] PBDSURG_API std::array<char, kHandleLineLength> handle_line(
    const HandleReport& report) noexcept;

/// Reads one line.
/// @param line    without its line feed
/// @param report  written only if the line counts
[[nodiscard]] PBDSURG_API HandleRefusal parse_handle_line(std::string_view line,
                                                          HandleReport& report) noexcept;

/// Finds lines in a stream of bytes that may start, break off and be damaged anywhere. A line
/// begins with every `P`, wherever it comes: damage costs the lines that it touches and none after
/// them. Allocates nothing.
class PBDSURG_API HandleLineReader {
 public:
  /// Takes a byte.
  /// @return  whether a line ended with it, or was cut short by a new one: see refusal()
  bool push(char byte) noexcept;

  /// Of the line that ended last.
  [[nodiscard]] HandleRefusal refusal() const noexcept { return refusal_; }

  /// Of the newest line that counts.
  [[nodiscard]] const HandleReport& report() const noexcept { return report_; }

 private:
  std::array<char, kHandleLineLength> line_{};
  std::size_t length_ = 0;  // stays at that of line_ while a line is too long
  HandleReport report_;
  HandleRefusal refusal_ = HandleRefusal::none;
};

}  // namespace pbdsurg
