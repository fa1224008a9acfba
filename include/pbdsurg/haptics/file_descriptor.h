// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An open file, serial port, pipe or input device of a POSIX system.

#include <utility>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Owns a file descriptor and closes it. Moved from, it is closed.
class PBDSURG_API FileDescriptor {
 public:
  FileDescriptor() = default;  ///< a closed one
  /// @param number  open, and closed by this from now on; negative for a closed one
  explicit FileDescriptor(int number) noexcept : number_(number) {}
  /// The other is closed from now on.
  FileDescriptor(FileDescriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  /// What this had is closed first.
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
      close();
      number_ = std::exchange(other.number_, -1);
    }
    return *this;
  }
  ~FileDescriptor() { close(); }

  /// Whether there is one.
  [[nodiscard]] bool is_open() const noexcept { return number_ >= 0; }

  /// For system calls; negative if it is closed.
  [[nodiscard]] int number() const noexcept { return number_; }

  /// Does nothing to one that is closed.
  void close() noexcept;

 private:
  int number_ = -1;
};

}  // namespace pbdsurg
