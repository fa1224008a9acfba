// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/encoded_stream.h"

#include <array>
#include <cstdint>

namespace pbdsurg {
namespace {

constexpr std::int8_t kNoDigit = -1;

constexpr std::array<std::int8_t, 256> base64_digits() {
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::int8_t, 256> digits{};
  for (std::int8_t& digit : digits) {
    digit = kNoDigit;
  }
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    digits[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::int8_t>(i);
  }
  return digits;
}

constexpr std::array<std::int8_t, 256> kDigits = base64_digits();

}  // namespace

std::optional<std::string> EncodedStream::take(std::size_t count) {
  if (count > most_left()) {
    return std::nullopt;
  }
  if (!base64_) {
    offset_ += count;
    return std::string(bytes_.substr(offset_ - count, count));
  }
  ready_.reserve(count + 2);
  while (ready_.size() < count) {
    if (!decode_group()) {
      return std::nullopt;
    }
  }
  std::string taken = ready_.substr(0, count);
  ready_.erase(0, count);
  return taken;
}

/// Decodes four characters to one, two or three bytes.
bool EncodedStream::decode_group() {
  std::uint32_t bits = 0;
  int digits = 0;
  int padding = 0;
  while (digits + padding < 4) {
    if (offset_ == bytes_.size()) {
      return false;
    }
    const char c = bytes_[offset_++];
    if (c == ' ' || c == '\n' || c == '\r' || c == '\t') {
      continue;
    }
    const std::int8_t digit = kDigits[static_cast<unsigned char>(c)];
    if (c == '=' && digits >= 2) {
      ++padding;
      bits <<= 6;
    } else if (digit != kNoDigit && padding == 0) {
      ++digits;
      bits = bits << 6 | static_cast<std::uint32_t>(digit);
    } else {
      --offset_;
      return false;
    }
  }
  for (int i = 0; i < digits - 1; ++i) {
    ready_ += static_cast<char>(bits >> (16 - 8 * i) & 0xFF);
  }
  return true;
}

}  // namespace pbdsurg
