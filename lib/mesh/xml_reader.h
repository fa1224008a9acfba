// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tags of an XML file, one after the other: as much of XML as VTK files use.

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lib/mesh/source.h"

namespace pbdsurg {

struct XmlTag {
  enum class Kind { open, close, empty, end_of_file };

  Kind kind = Kind::end_of_file;
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string>> attributes;
  std::size_t offset = 0;  ///< where the tag begins

  /// Value of an attribute, nullptr without it.
  [[nodiscard]] const std::string* find(std::string_view attribute) const;
};

/// Steps over comments, processing instructions, declarations and CDATA; decodes the five named
/// and the numbered entities in attributes.
class XmlReader {
 public:
  explicit XmlReader(const Source& source) : source_(source) {}

  /// The next tag. @throws FileError  if the markup is broken
  XmlTag next();

  /// Where the text behind the tag read last begins, and where it ends: at the next '<'.
  [[nodiscard]] std::size_t text_begin() const { return offset_; }
  [[nodiscard]] std::size_t text_end() const;

 private:
  void skip_past(std::string_view mark, std::string_view what);
  void skip_space();
  std::string_view read_name(std::string_view what);
  std::string decode(std::string_view text) const;
  [[noreturn]] void fail(const std::string& reason) const;

  const Source& source_;
  std::size_t offset_ = 0;
};

}  // namespace pbdsurg
