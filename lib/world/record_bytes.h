// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Records as bytes, little-endian, and back. What a record holds, visit_members() says once for
/// both: see file_records.h.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/ids.h"

namespace pbdsurg {

/// The last enumerator of a type that files hold.
template <class Enum>
inline constexpr Enum kLast = Enum::without_a_last_enumerator;

template <class Value>
concept Number = std::integral<Value> || std::floating_point<Value>;

/// Bytes that a value takes at least: guards counts that no file could hold.
template <class Value>
struct LeastBytes {
  static constexpr std::size_t kCount = Number<Value> || std::is_enum_v<Value> ? sizeof(Value) : 1;
};
template <class Value, std::size_t kSize>
struct LeastBytes<std::array<Value, kSize>> {
  static constexpr std::size_t kCount = kSize * LeastBytes<Value>::kCount;
};
template <class Scalar, int kRows, int kColumns>
struct LeastBytes<Eigen::Matrix<Scalar, kRows, kColumns>> {
  static constexpr std::size_t kCount = kRows * kColumns * sizeof(Scalar);
};

/// Appends records to bytes.
class RecordWriter {
 public:
  template <class... Values>
  void operator()(const Values&... values) {
    (write(values), ...);
  }

  [[nodiscard]] const std::string& bytes() const noexcept { return bytes_; }

  /// Writes over a number that was written before.
  void write_at(std::size_t offset, std::uint64_t number) {
    RecordWriter other;
    other(number);
    bytes_.replace(offset, other.bytes_.size(), other.bytes_);
  }

 private:
  template <Number Value>
  void write(Value value) {
    auto raw = std::bit_cast<std::array<char, sizeof(Value)>>(value);
    if constexpr (std::endian::native == std::endian::big) {
      std::ranges::reverse(raw);
    }
    bytes_.append(raw.data(), raw.size());
  }
  template <class Enum>
  requires std::is_enum_v<Enum>
  void write(Enum value) { write(static_cast<std::underlying_type_t<Enum>>(value)); }
  void write(const std::string& text) {
    write(std::uint64_t{text.size()});
    bytes_ += text;
  }
  template <class Thing>
  void write(Id<Thing> id) {
    write(id.value);
  }
  template <class Value, std::size_t kSize>
  void write(const std::array<Value, kSize>& values) {
    std::ranges::for_each(values, [&](const Value& value) { write(value); });
  }
  template <class Scalar, int kRows, int kColumns>
  void write(const Eigen::Matrix<Scalar, kRows, kColumns>& matrix) {
    std::for_each(matrix.data(), matrix.data() + matrix.size(), [&](Scalar x) { write(x); });
  }
  void write(const Eigen::Isometry3f& pose) { write(pose.matrix()); }
  template <class Value>
  void write(const std::vector<Value>& values) {
    write(std::uint64_t{values.size()});
    std::ranges::for_each(values, [&](const Value& value) { write(value); });
  }
  template <class Value>
  void write(const std::optional<Value>& value) {
    write(value.has_value());
    if (value) {
      write(*value);
    }
  }
  template <class Record>
  requires std::is_class_v<Record>
  void write(const Record& record) { visit_members(record, *this); }

  std::string bytes_;
};

/// Walks over bytes of a file. Every failure names the file, the byte and the rule.
class RecordReader {
 public:
  /// @param path   of the file that the bytes are
  /// @param begin  first byte to read
  /// @param end    the byte behind the last
  RecordReader(const std::string& path, std::string_view file, std::size_t begin, std::size_t end)
      : path_(&path), file_(file), offset_(begin), item_(begin), end_(end) {}

  template <class... Values>
  void operator()(Values&... values) {
    (read(values), ...);
  }

  /// The next value.
  template <class Value>
  [[nodiscard]] Value next() {
    Value value{};
    read(value);
    return value;
  }

  [[nodiscard]] std::size_t offset() const noexcept { return offset_; }
  [[nodiscard]] std::size_t left() const noexcept { return end_ - offset_; }

  /// A reader of the next bytes, which are then read.
  [[nodiscard]] RecordReader part(std::uint64_t size) {
    const std::size_t begin = offset_;
    take(size);
    return {*path_, file_, begin, offset_};
  }

  void expect_end() {
    item_ = offset_;
    if (left() > 0) {
      fail(std::to_string(left()) + " bytes follow that nothing would read");
    }
  }

  /// Reports a failure at the item read last.
  [[noreturn]] void fail(const std::string& reason) const {
    throw FileError::at_byte(*path_, static_cast<long long>(item_), reason);
  }

 private:
  const char* take(std::uint64_t count) {
    item_ = offset_;
    if (count > left()) {
      fail("needs " + std::to_string(count) + " bytes; " + std::to_string(left()) + " are left");
    }
    offset_ += static_cast<std::size_t>(count);
    return file_.data() + item_;
  }
  template <class Value>
  std::size_t count_of() {
    const auto count = next<std::uint64_t>();
    if (count > left() / LeastBytes<Value>::kCount) {
      fail("has a count of " + std::to_string(count) + "; " + std::to_string(left()) +
           " bytes cannot hold so many");
    }
    return static_cast<std::size_t>(count);
  }

  template <Number Value>
  void read(Value& value) {
    std::array<char, sizeof(Value)> raw;
    std::copy_n(take(raw.size()), raw.size(), raw.begin());
    if constexpr (std::endian::native == std::endian::big) {
      std::ranges::reverse(raw);
    }
    value = std::bit_cast<Value>(raw);
  }
  void read(bool& value) {
    const auto byte = next<std::uint8_t>();
    if (byte > 1) {
      fail("a yes or no is " + std::to_string(byte) + "; it must be 0 or 1");
    }
    value = byte != 0;
  }
  template <class Enum>
  requires std::is_enum_v<Enum>
  void read(Enum& value) {
    using Raw = std::underlying_type_t<Enum>;
    static_assert(std::is_unsigned_v<Raw>);
    const Raw raw = next<Raw>();
    if (raw > static_cast<Raw>(kLast<Enum>)) {
      fail("a choice is " + std::to_string(raw) + "; it must be in [0, " +
           std::to_string(static_cast<Raw>(kLast<Enum>)) + "]");
    }
    value = static_cast<Enum>(raw);
  }
  void read(std::string& text) {
    const std::size_t size = count_of<char>();
    text.assign(take(size), size);
  }
  template <class Thing>
  void read(Id<Thing>& id) {
    read(id.value);
  }
  template <class Value, std::size_t kSize>
  void read(std::array<Value, kSize>& values) {
    std::ranges::for_each(values, [&](Value& value) { read(value); });
  }
  template <class Scalar, int kRows, int kColumns>
  void read(Eigen::Matrix<Scalar, kRows, kColumns>& matrix) {
    std::for_each(matrix.data(), matrix.data() + matrix.size(), [&](Scalar& x) { read(x); });
  }
  void read(Eigen::Isometry3f& pose) { read(pose.matrix()); }
  // Grows with what is there, for a record may take far more memory than bytes.
  template <class Value>
  void read(std::vector<Value>& values) {
    const std::size_t count = count_of<Value>();
    values.clear();
    for (std::size_t i = 0; i < count; ++i) {
      values.push_back(next<Value>());
    }
  }
  template <class Value>
  void read(std::optional<Value>& value) {
    value.reset();
    if (next<bool>()) {
      value = next<Value>();
    }
  }
  template <class Record>
  requires std::is_class_v<Record>
  void read(Record& record) { visit_members(record, *this); }

  const std::string* path_;
  std::string_view file_;
  std::size_t offset_, item_, end_;
};

}  // namespace pbdsurg
