// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Binary numbers of a file, bounds-checked, in either byte order.

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "lib/mesh/scalar_type.h"
#include "lib/mesh/source.h"

namespace pbdsurg {

/// Walks over the bytes of a Source. Every failure names path and byte.
class ByteReader {
 public:
  ByteReader(const Source& source, std::size_t begin, std::endian order)
      : source_(&source), offset_(begin), item_(begin), order_(order) {}

  [[nodiscard]] std::size_t offset() const { return offset_; }
  [[nodiscard]] std::size_t left() const { return source_->bytes.size() - offset_; }
  [[nodiscard]] std::endian order() const { return order_; }
  void set_order(std::endian order) { order_ = order; }

  /// The next number. @param what  names it in the error when the file ends here
  template <class Number>
  Number number(std::string_view what) {
    return load<Number>(take(sizeof(Number), what), order_);
  }

  /// Same, for a type known at run time only.
  template <class Number>
  Number number(ScalarType type, std::string_view what) {
    return load_as<Number>(type, take(size_of(type), what), order_);
  }

  /// Three finite coordinates.
  Eigen::Vector3d point(ScalarType type = ScalarType::float64) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = number<double>(type, "a coordinate");
      if (!std::isfinite(p[axis])) {
        fail("a coordinate is " + std::string(p[axis] == p[axis] ? "infinite" : "not a number") +
             "; it must be finite");
      }
    }
    return p;
  }

  /// The next `count` bytes.
  const char* take(std::size_t count, std::string_view what) {
    item_ = offset_;
    if (count > left()) {
      fail("the file ends within " + std::string(what));
    }
    offset_ += count;
    return source_->bytes.data() + item_;
  }

  /// Accepts a number of elements if the rest of the file can hold them.
  std::size_t checked_count(std::int64_t value, std::string_view what, std::size_t least_bytes) {
    const std::string problem = count_problem(value, what, least_bytes, left());
    if (!problem.empty()) {
      fail(problem);
    }
    return static_cast<std::size_t>(value);
  }

  /// Reports a failure at the item read last.
  [[noreturn]] void fail(const std::string& reason) const { source_->fail_at_byte(item_, reason); }

 private:
  const Source* source_;
  std::size_t offset_;
  std::size_t item_;  // where the item read last begins
  std::endian order_;
};

}  // namespace pbdsurg
