// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/xml_reader.h"

#include <algorithm>
#include <charconv>

namespace pbdsurg {
namespace {

bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '.' || c == ':' || (c & 0x80) != 0;
}

}  // namespace

const std::string* XmlTag::find(std::string_view attribute) const {
  for (const auto& [key, value] : attributes) {
    if (key == attribute) {
      return &value;
    }
  }
  return nullptr;
}

XmlTag XmlReader::next() {
  const std::string_view bytes = source_.bytes;
  XmlTag tag;
  while (true) {
    offset_ = std::min(bytes.find('<', offset_), bytes.size());
    tag.offset = offset_;
    if (offset_ == bytes.size()) {
      return tag;
    }
    const std::string_view rest = bytes.substr(offset_);
    if (rest.starts_with("<!--")) {
      skip_past("-->", "a comment");
    } else if (rest.starts_with("<![CDATA[")) {
      skip_past("]]>", "CDATA");
    } else if (rest.starts_with("<?")) {
      skip_past("?>", "a processing instruction");
    } else if (rest.starts_with("<!")) {
      skip_past(">", "a declaration");
    } else {
      break;
    }
  }
  ++offset_;
  tag.kind = XmlTag::Kind::open;
  if (offset_ < bytes.size() && bytes[offset_] == '/') {
    tag.kind = XmlTag::Kind::close;
    ++offset_;
  }
  tag.name = read_name("a tag");
  while (true) {
    skip_space();
    if (offset_ == bytes.size()) {
      fail("the file ends within a tag");
    }
    if (bytes[offset_] == '>') {
      ++offset_;
      return tag;
    }
    if (bytes[offset_] == '/') {
      tag.kind = XmlTag::Kind::empty;
      ++offset_;
      continue;
    }
    const std::string_view key = read_name("an attribute");
    skip_space();
    if (offset_ == bytes.size() || bytes[offset_] != '=') {
      fail("'=' should follow the name of an attribute");
    }
    ++offset_;
    skip_space();
    const char quote = offset_ < bytes.size() ? bytes[offset_] : '\0';
    if (quote != '"' && quote != '\'') {
      fail("the value of an attribute must be in quotes");
    }
    const std::size_t end = bytes.find(quote, offset_ + 1);
    if (end == bytes.npos) {
      fail("the value of an attribute has no end");
    }
    tag.attributes.emplace_back(key, decode(bytes.substr(offset_ + 1, end - offset_ - 1)));
    offset_ = end + 1;
  }
}

std::size_t XmlReader::text_end() const {
  return std::min(source_.bytes.find('<', offset_), source_.bytes.size());
}

void XmlReader::skip_past(std::string_view mark, std::string_view what) {
  const std::size_t found = source_.bytes.find(mark, offset_);
  if (found == std::string::npos) {
    fail(std::string(what) + " has no end");
  }
  offset_ = found + mark.size();
}

void XmlReader::skip_space() {
  while (offset_ < source_.bytes.size() && is_space(source_.bytes[offset_])) {
    ++offset_;
  }
}

std::string_view XmlReader::read_name(std::string_view what) {
  const std::size_t begin = offset_;
  while (offset_ < source_.bytes.size() && is_name(source_.bytes[offset_])) {
    ++offset_;
  }
  if (offset_ == begin) {
    fail("the name of " + std::string(what) + " should be here");
  }
  return std::string_view(source_.bytes).substr(begin, offset_ - begin);
}

std::string XmlReader::decode(std::string_view text) const {
  constexpr std::pair<std::string_view, char> kEntities[] = {
      {"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}};
  std::string result;
  while (!text.empty()) {
    const std::size_t plain = std::min(text.find('&'), text.size());
    result += text.substr(0, plain);
    text.remove_prefix(plain);
    if (text.empty()) {
      break;
    }
    std::size_t used = 0;
    for (const auto& [entity, character] : kEntities) {
      if (text.starts_with(entity)) {
        result += character;
        used = entity.size();
      }
    }
    if (text.starts_with("&#")) {
      const bool hexadecimal = text.starts_with("&#x");
      const char* const begin = text.data() + (hexadecimal ? 3 : 2);
      unsigned code = 0;
      const auto [end, error] =
          std::from_chars(begin, text.data() + text.size(), code, hexadecimal ? 16 : 10);
      if (error == std::errc() && end != text.data() + text.size() && *end == ';') {
        // names and numbers of meshes are ASCII; anything else only has to stay apart
        result += code < 128 ? static_cast<char>(code) : '?';
        used = static_cast<std::size_t>(end + 1 - text.data());
      }
    }
    if (used == 0) {
      fail("'&' begins an unknown entity");
    }
    text.remove_prefix(used);
  }
  return result;
}

void XmlReader::fail(const std::string& reason) const {
  source_.fail_at_line(offset_, reason);
}

}  // namespace pbdsurg
