// SPDX-License-Identifier: Apache-2.0
#include "tests/regression/record.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/write_file.h"

#include "tests/support/digest.h"

namespace pbdsurg::testing {
namespace {

std::string text_of(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016" PRIx64, hash);
  return text;
}

constexpr const char* kLibrary = "math library";

}  // namespace

void Record::insert(Hashes& hashes, int checkpoint, const std::string& what,
                    std::uint64_t hash) const {
  char number[16];
  std::snprintf(number, sizeof(number), "%03d", checkpoint);
  const std::string name = program_ + "/" + number + "/" + what;
  if (!hashes.emplace(name, hash).second) {
    throw std::logic_error(name + " is recorded twice");
  }
}

std::uint64_t math_library_digest() {
  Digest digest;
  for (int i = 1; i < 20'000; ++i) {
    const double x = i * 1.37e-3;
    for (const double value : {std::exp(-x), std::cbrt(x), std::pow(x, 1.0 / 9), std::atan(x),
                               std::tan(x), std::sin(x), std::cos(x), std::hypot(x, 1.1)}) {
      digest.mix(value);
    }
  }
  return digest.value();
}

HashFile read_hashes(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) {
    throw FileError(path + ": cannot be opened");
  }
  HashFile file;
  std::string line, last;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const std::size_t space = line.rfind(' ');
    std::uint64_t hash = 0;
    if (space == std::string::npos || line.size() != space + 17 ||
        std::sscanf(line.c_str() + space, "%" SCNx64, &hash) != 1) {
      throw FileError::at_line(path, number, "expected a name and 16 digits");
    }
    const std::string name = line.substr(0, space);
    if (name == kLibrary) {
      file.library = hash;
      continue;
    }
    if (name <= last) {
      throw FileError::at_line(path, number, "names must ascend");
    }
    file.hashes.emplace_hint(file.hashes.end(), name, hash);
    last = name;
  }
  return file;
}

void write_hashes(const std::string& path, const std::string& title, const HashFile& file) {
  std::ostringstream text;
  text << "# " << title << "\n";
  if (file.library != 0) {
    text << kLibrary << " " << text_of(file.library) << "\n";
  }
  for (const auto& [name, hash] : file.hashes) {
    text << name << " " << text_of(hash) << "\n";
  }
  write_file(path, text.str());
}

std::string first_difference(const std::string& program, const Hashes& actual, const Hashes& file) {
  std::set<std::string> names;
  for (const auto& [name, hash] : actual) {
    names.insert(name);
  }
  const std::string prefix = program + "/";
  for (auto line = file.lower_bound(prefix); line != file.end() && line->first.starts_with(prefix);
       ++line) {
    names.insert(line->first);
  }
  std::string first;
  int count = 0;
  for (const std::string& name : names) {
    const auto is = actual.find(name), should = file.find(name);
    if (is != actual.end() && should != file.end() && is->second == should->second) {
      continue;
    }
    if (count++ == 0) {
      first = name + (is == actual.end() ? " is missing" : " is " + text_of(is->second)) +
              (should == file.end() ? ", which the file does not have"
                                    : ", in the file " + text_of(should->second));
    }
  }
  return count == 0
             ? ""
             : first + "; " + std::to_string(count) + " differ of " + std::to_string(names.size());
}

}  // namespace pbdsurg::testing
