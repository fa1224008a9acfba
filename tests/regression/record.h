// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hashes that programs leave behind, and the files that say what they should be.

#include <cstdint>
#include <map>
#include <string>
#include <utility>

namespace pbdsurg::testing {

/// Hashes by name, "program/checkpoint/what": of one program, ascending is the order of time.
using Hashes = std::map<std::string, std::uint64_t>;

/// What one run of a program leaves behind.
class Record {
 public:
  explicit Record(std::string program) : program_(std::move(program)) {}

  /// A hash that follows from IEEE arithmetic.
  /// @param checkpoint  in [0, 999]
  /// @throws std::logic_error  if there is one of that name
  void add(int checkpoint, const std::string& what, std::uint64_t hash) {
    insert(arithmetic_, checkpoint, what, hash);
  }

  /// One that follows from the last bits of exp(), atan() and such, too, in which C libraries
  /// differ.
  void add_of_library(int checkpoint, const std::string& what, std::uint64_t hash) {
    insert(library_, checkpoint, what, hash);
  }

  [[nodiscard]] const std::string& program() const { return program_; }
  [[nodiscard]] const Hashes& arithmetic() const { return arithmetic_; }
  [[nodiscard]] const Hashes& library() const { return library_; }

 private:
  void insert(Hashes& hashes, int checkpoint, const std::string& what, std::uint64_t hash) const;

  std::string program_;
  Hashes arithmetic_, library_;
};

/// A file of hashes.
struct HashFile {
  std::uint64_t library = 0;  ///< math_library_digest() of who wrote it, if hashes follow from that
  Hashes hashes;
};

/// Of the last bits of the functions that heat calls.
[[nodiscard]] std::uint64_t math_library_digest();

/// @throws FileError  naming the line that is not of the format or not in its place
[[nodiscard]] HashFile read_hashes(const std::string& path);

/// @param title  a comment, for the first line
void write_hashes(const std::string& path, const std::string& title, const HashFile& file);

/// What a program left behind against what a file has of it.
/// @return  the first that differs, in words, and how many do; empty if none does
[[nodiscard]] std::string first_difference(const std::string& program, const Hashes& actual,
                                           const Hashes& file);

}  // namespace pbdsurg::testing
