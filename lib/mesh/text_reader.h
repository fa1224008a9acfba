// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tokens of a text file: words and numbers between white space, independent of the locale. Lines
/// end at "\n", at "\r\n" or, on old Macs, at "\r".

#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "lib/mesh/source.h"

namespace pbdsurg {

/// Walks over the tokens of a Source, or of a part of it. Every failure names path and line.
class TextReader {
 public:
  /// @param comment  starts a comment that runs to the end of its line; 0 for none
  explicit TextReader(const Source& source, char comment = '\0')
      : TextReader(source, source.text_begin, source.bytes.size(), comment) {}

  TextReader(const Source& source, std::size_t begin, std::size_t end, char comment)
      : source_(&source), offset_(begin), end_(end), token_(begin), comment_(comment) {}

  [[nodiscard]] std::size_t offset() const { return offset_; }
  void seek(std::size_t offset) { token_ = offset_ = offset; }

  /// Whether no token is left.
  bool at_end() {
    skip_space();
    return offset_ == end_;
  }

  /// Whether no token is left on this line; stays before its end.
  bool at_line_end() {
    while (offset_ < end_ && is_space(here()) && !is_line_end(here())) {
      ++offset_;
    }
    return offset_ == end_ || is_line_end(here()) || (comment_ != '\0' && here() == comment_);
  }

  /// Begins a row at the next token: until end_row(), a token on another line is refused.
  void begin_row() {
    skip_space();
    in_row_ = true;
  }

  /// Ends a row, which must have no token left.
  /// @param what, id  name the row in the error
  void end_row(std::string_view what, std::int64_t id) {
    in_row_ = false;
    if (!at_line_end()) {
      const std::string extra = printable(word(""));
      fail("'" + extra + "' stands where the line of " + std::string(what) + " " +
           std::to_string(id) + " should end");
    }
  }

  /// The next token. @param what  names it in the error when the file, or the row, ends here
  std::string_view word(std::string_view what) {
    if (in_row_ && at_line_end() && offset_ != end_) {
      token_ = offset_;
      fail("the line ends where " + std::string(what) + " should be");
    }
    skip_space();
    token_ = offset_;
    if (offset_ == end_) {
      fail("the file ends where " + std::string(what) + " should be");
    }
    while (offset_ < end_ && !is_space(here())) {
      ++offset_;
    }
    return std::string_view(source_->bytes).substr(token_, offset_ - token_);
  }

  /// The next token, which stays the next one; empty at the end.
  std::string_view peek() {
    if (at_end()) {
      return {};
    }
    const std::size_t begin = offset_;
    const std::string_view text = word("");
    offset_ = begin;
    return text;
  }

  /// What is left of this line, without its end; goes to the start of the next line.
  std::string_view rest_of_line() {
    token_ = offset_;
    const std::string_view left = std::string_view(source_->bytes).substr(0, end_);
    const std::size_t end = std::min(left.find_first_of("\r\n", offset_), end_);
    offset_ = std::min(end + (left.substr(end, 2) == "\r\n" ? 2 : 1), end_);
    return left.substr(token_, end - token_);
  }

  /// The next token as a number; floating point results may be infinite or not a number if the
  /// file says so.
  template <class Number>
  Number number(std::string_view what) {
    const std::string_view text = word(what);
    const char* const end = text.data() + text.size();
    const char* const begin = text.data() + (text.front() == '+' ? 1 : 0);
    Number value{};
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc() && stop == end) {
      return value;
    }
    if constexpr (std::is_floating_point_v<Number>) {
      // too small for a double is zero; too large is an error
      if (error == std::errc::result_out_of_range && stop == end &&
          (text.find("e-") != text.npos || text.find("E-") != text.npos)) {
        return 0;
      }
    }
    fail("'" + printable(text) + "' stands where " + std::string(what) + " should be");
  }

  /// Three finite coordinates.
  Eigen::Vector3d point() {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = number<double>("a coordinate");
      if (!std::isfinite(p[axis])) {
        fail("a coordinate is " + std::string(p[axis] == p[axis] ? "infinite" : "not a number") +
             "; it must be finite");
      }
    }
    return p;
  }

  /// A number of elements that the rest of the file can hold.
  /// @param least_tokens  tokens per element; each takes two bytes at least
  std::size_t count(std::string_view what, std::size_t least_tokens) {
    return checked_count(number<std::int64_t>("the number of " + std::string(what)), what,
                         least_tokens);
  }

  /// Same, for a number that was read before.
  std::size_t checked_count(std::int64_t value, std::string_view what, std::size_t least_tokens) {
    // the last token needs no separator
    const std::string problem = count_problem(value, what, 2 * least_tokens, end_ - offset_ + 1);
    if (!problem.empty()) {
      fail(problem);
    }
    return static_cast<std::size_t>(value);
  }

  /// Reports a failure at the token read last.
  [[noreturn]] void fail(const std::string& reason) const { source_->fail_at_line(token_, reason); }

  /// A token fit for an error message: short, without control characters.
  static std::string printable(std::string_view text) {
    std::string result(text.substr(0, 40));
    for (char& c : result) {
      c = c < ' ' || c > '~' ? '?' : c;
    }
    return text.size() > 40 ? result + "..." : result;
  }

 private:
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  [[nodiscard]] char here() const { return source_->bytes[offset_]; }

  void skip_space() {
    while (offset_ < end_) {
      if (is_space(here())) {
        ++offset_;
      } else if (comment_ != '\0' && here() == comment_) {
        while (offset_ < end_ && !is_line_end(here())) {
          ++offset_;
        }
      } else {
        return;
      }
    }
  }

  const Source* source_;
  std::size_t offset_;
  std::size_t end_;
  std::size_t token_;  // where the token read last begins
  char comment_;
  bool in_row_ = false;
};

}  // namespace pbdsurg
