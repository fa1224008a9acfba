// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A pipe with the records of a keyboard.

#include <cstddef>
#include <filesystem>

#include <fcntl.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

namespace pbdsurg::testing {

class PedalPipe {
 public:
  PedalPipe() {
    REQUIRE(mkfifo(path.c_str(), 0600) == 0);
    plug_in();
  }
  ~PedalPipe() { unplug(); }
  PedalPipe(const PedalPipe&) = delete;
  PedalPipe& operator=(const PedalPipe&) = delete;

  /// What the kernel sends for a key: 1 pressed, 0 let go, 2 held.
  void key(int code, int value) {
    record(EV_MSC, MSC_SCAN, 0x70000 + code);
    record(EV_KEY, code, value);
    record(EV_SYN, SYN_REPORT, 0);
  }

  void record(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<__u16>(type);
    event.code = static_cast<__u16>(code);
    event.value = value;
    bytes(&event, sizeof(event));
  }

  void bytes(const void* begin, std::size_t size) {
    REQUIRE(write(writer_, begin, size) == static_cast<ssize_t>(size));
  }

  void plug_in() {
    writer_ = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    REQUIRE(writer_ >= 0);
  }

  void unplug() {
    if (writer_ >= 0) {
      close(writer_);
      writer_ = -1;
    }
  }

 private:
  TemporaryFolder folder_;
  int writer_ = -1;

 public:
  const std::filesystem::path path = folder_ / "keyboard";
};

}  // namespace pbdsurg::testing
