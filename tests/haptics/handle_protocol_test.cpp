// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/handle_protocol.h"

#include <string>
#include <vector>

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

constexpr HandleReport kReport{.sequence = 0x001F, .jaw = 0x8A40, .roll = 0xC000, .buttons = 1};

std::string line_of(const HandleReport& report) {
  const auto line = handle_line(report);
  return {line.begin(), line.end()};
}

std::string without_end(std::string line) {
  line.pop_back();
  return line;
}

struct Heard {
  std::vector<HandleReport> reports;
  int refused = 0;
};

Heard hear(const std::string& bytes) {
  HandleLineReader reader;
  Heard heard;
  for (const char byte : bytes) {
    if (!reader.push(byte)) {
      continue;
    }
    if (reader.refusal() == HandleRefusal::none) {
      heard.reports.push_back(reader.report());
    } else {
      ++heard.refused;
    }
  }
  return heard;
}

}  // namespace

// Would catch a field that is moved, a digit in lower case, and another checksum than the published
// one: 0x92AA was computed by Python's binascii.crc_hqx(b"P1 001F 8A40 C000 01", 0xFFFF).
TEST_CASE("handle protocol: a line is as it is published", "[unit]") {
  CHECK(line_of(kReport) == "P1 001F 8A40 C000 01 92AA\n");
}

// Would catch a field that is cut or mixed up with another.
TEST_CASE("handle protocol: each report has a line that gives it again", "[unit]") {
  for (unsigned i = 0; i < 65536; i += 251) {
    const HandleReport report{.sequence = static_cast<std::uint16_t>(i),
                              .jaw = static_cast<std::uint16_t>(65535 - i),
                              .roll = static_cast<std::uint16_t>(7 * i),
                              .buttons = static_cast<std::uint8_t>(i / 3)};
    HandleReport read;
    REQUIRE(parse_handle_line(without_end(line_of(report)), read) == HandleRefusal::none);
    REQUIRE(read == report);
  }
}

// Would catch a parser that takes a digit in lower case, or does not look at some byte, and one
// that goes on with the pieces of a damaged line: every byte is changed to each of the 255 others.
TEST_CASE("handle protocol: a byte that changed costs its line and no other", "[unit]") {
  const HandleReport before{.sequence = 0x001E}, after{.sequence = 0x0020}, last{.sequence = 0x21};
  for (std::size_t at = 0; at < kHandleLineLength; ++at) {
    for (int change = 1; change < 256; ++change) {
      std::string damaged = line_of(kReport);
      damaged[at] = static_cast<char>(damaged[at] ^ change);
      INFO("byte " << at << " is " << int{damaged[at]});
      const Heard heard = hear(line_of(before) + damaged + line_of(after) + line_of(last));
      REQUIRE(heard.reports == std::vector{before, after, last});
      REQUIRE(heard.refused >= 1);
    }
  }
}

// Would catch a reader that needs a whole line first, or whose buffer runs over.
TEST_CASE("handle protocol: lines are found after any garbage", "[unit]") {
  const std::string line = line_of(kReport);
  for (std::size_t cut = 1; cut < line.size(); ++cut) {
    CHECK(hear(line.substr(cut) + line).reports == std::vector{kReport});     // begins within
    CHECK(hear(line.substr(0, cut) + line).reports == std::vector{kReport});  // breaks off
  }
  CHECK(hear(std::string(100000, 'x') + line).reports == std::vector{kReport});
  CHECK(hear(std::string(100, '\n') + line).reports == std::vector{kReport});
  CHECK(hear(std::string(100, 'P') + line.substr(1)).reports == std::vector{kReport});
}

// Would catch a reason that is another's.
TEST_CASE("handle protocol: a refusal has its reason", "[unit]") {
  const std::string line = without_end(line_of(kReport));
  const auto reason = [](const std::string& text) {
    HandleReport untouched = kReport;
    const HandleRefusal refusal = parse_handle_line(text, untouched);
    CHECK(untouched == kReport);
    return refusal;
  };
  CHECK(reason("") == HandleRefusal::length);
  CHECK(reason(line + " ") == HandleRefusal::length);
  CHECK(reason("P2" + line.substr(2)) == HandleRefusal::version);
  CHECK(reason(line.substr(0, 2) + "_" + line.substr(3)) == HandleRefusal::character);
  CHECK(reason(line.substr(0, 6) + "f" + line.substr(7)) == HandleRefusal::character);
  CHECK(reason(line.substr(0, 6) + "E" + line.substr(7)) == HandleRefusal::checksum);
  CHECK(describe(HandleRefusal::checksum) == "its checksum is wrong");
}

}  // namespace pbdsurg
