// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/handle_protocol.h"

#include <algorithm>

namespace pbdsurg {
namespace {

constexpr std::string_view kVersion = "P1";

// a field's first byte and digits
struct Field {
  std::size_t begin, digits;
};
constexpr Field kSequence{3, 4}, kJaw{8, 4}, kRoll{13, 4}, kButtons{18, 2}, kChecksum{21, 4};
constexpr std::array kFields{kSequence, kJaw, kRoll, kButtons, kChecksum};

// CRC-16/CCITT-FALSE: 29B1 for "123456789"
std::uint16_t checksum(std::string_view bytes) noexcept {
  unsigned value = 0xFFFF;
  for (const char byte : bytes) {
    value ^= static_cast<unsigned>(static_cast<unsigned char>(byte)) << 8U;
    for (int bit = 0; bit < 8; ++bit) {
      value = (value << 1U) ^ ((value & 0x8000U) != 0 ? 0x1021U : 0U);
    }
  }
  return static_cast<std::uint16_t>(value);
}

// 16 for what is no digit
unsigned digit_value(char digit) noexcept {
  if (digit >= '0' && digit <= '9') {
    return static_cast<unsigned>(digit - '0');
  }
  return digit >= 'A' && digit <= 'F' ? static_cast<unsigned>(digit - 'A') + 10 : 16;
}

unsigned value_of(std::string_view line, const Field& field) noexcept {
  unsigned value = 0;
  for (const char digit : line.substr(field.begin, field.digits)) {
    value = 16 * value + digit_value(digit);
  }
  return value;
}

void put(std::array<char, kHandleLineLength>& line, const Field& field, unsigned value) noexcept {
  for (std::size_t digit = field.digits; digit-- > 0; value /= 16) {
    line[field.begin + digit] = "0123456789ABCDEF"[value % 16];
  }
}

// digits where a field is, spaces elsewhere
bool has_form(std::string_view line) noexcept {
  std::size_t at = kVersion.size();
  for (const Field& field : kFields) {
    const std::string_view digits = line.substr(field.begin, field.digits);
    if (line[at] != ' ' || !std::all_of(digits.begin(), digits.end(),
                                        [](char digit) { return digit_value(digit) < 16; })) {
      return false;
    }
    at = field.begin + field.digits;
  }
  return true;
}

}  // namespace

std::string_view describe(HandleRefusal refusal) noexcept {
  switch (refusal) {
    case HandleRefusal::none:
      return "it is as it should be";
    case HandleRefusal::length:
      return "it has not 25 bytes and a line feed";
    case HandleRefusal::version:
      return "it does not start with P1";
    case HandleRefusal::character:
      return "a space, or a digit in capitals, is missing from its place";
    case HandleRefusal::checksum:
      return "its checksum is wrong";
  }
  return {};
}

std::array<char, kHandleLineLength> handle_line(const HandleReport& report) noexcept {
  std::array<char, kHandleLineLength> line{};
  line.fill(' ');
  std::copy(kVersion.begin(), kVersion.end(), line.begin());
  put(line, kSequence, report.sequence);
  put(line, kJaw, report.jaw);
  put(line, kRoll, report.roll);
  put(line, kButtons, report.buttons);
  put(line, kChecksum, checksum({line.data(), kChecksum.begin - 1}));
  line.back() = '\n';
  return line;
}

HandleRefusal parse_handle_line(std::string_view line, HandleReport& report) noexcept {
  if (line.size() != kHandleLineLength - 1) {
    return HandleRefusal::length;
  }
  if (line.substr(0, kVersion.size()) != kVersion) {
    return HandleRefusal::version;
  }
  if (!has_form(line)) {
    return HandleRefusal::character;
  }
  if (value_of(line, kChecksum) != checksum(line.substr(0, kChecksum.begin - 1))) {
    return HandleRefusal::checksum;
  }
  report.sequence = static_cast<std::uint16_t>(value_of(line, kSequence));
  report.jaw = static_cast<std::uint16_t>(value_of(line, kJaw));
  report.roll = static_cast<std::uint16_t>(value_of(line, kRoll));
  report.buttons = static_cast<std::uint8_t>(value_of(line, kButtons));
  return HandleRefusal::none;
}

bool HandleLineReader::push(char byte) noexcept {
  if (byte == '\n') {
    refusal_ = parse_handle_line({line_.data(), length_}, report_);
    length_ = 0;
    return true;
  }
  const bool is_cut_short = byte == kVersion[0] && length_ > 0;
  if (is_cut_short) {
    refusal_ = HandleRefusal::length;
    length_ = 0;
  }
  if (length_ < line_.size()) {
    line_[length_++] = byte;
  }
  return is_cut_short;
}

}  // namespace pbdsurg
