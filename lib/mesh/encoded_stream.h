// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Bytes that a file stores as they are or in base64.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace pbdsurg {

/// Hands out decoded bytes on demand. Base64 may be padded anywhere: writers encode a header and
/// its data apart or together.
class EncodedStream {
 public:
  EncodedStream(std::string_view bytes, std::size_t begin, bool base64)
      : bytes_(bytes), offset_(begin), base64_(base64) {}

  /// The next bytes; none if the data end before or are not base64.
  std::optional<std::string> take(std::size_t count);

  /// How many bytes can be left at most.
  [[nodiscard]] std::size_t most_left() const { return ready_.size() + (bytes_.size() - offset_); }
  [[nodiscard]] std::size_t offset() const { return offset_; }

 private:
  bool decode_group();

  std::string_view bytes_;
  std::size_t offset_;
  bool base64_;
  std::string ready_;  // decoded and not yet taken: fewer than three bytes
};

}  // namespace pbdsurg
