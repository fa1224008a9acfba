// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device file whose cable may be pulled and plugged in again.

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <thread>

#include "pbdsurg/haptics/file_descriptor.h"

namespace pbdsurg {

/// Opens a device file again, after the device was gone, whenever it is there.
///
/// To open and to close one may take long: Linux waits for a USB serial port to take its settings,
/// for up to 5 s each where it does not answer (cdc-acm.c), and for all processors before it lets
/// go of a keyboard (evdev.c). So a thread does both, which sleeps while the device is there. All
/// functions are of one other thread, and none but constructor and destructor waits.
class HotplugDevice {
 public:
  /// Throws what it cannot open.
  using Open = FileDescriptor (*)(const std::filesystem::path& path);

  /// s, between two attempts to open it.
  static constexpr double kRetry = 1;

  /// Opens it, in the thread that calls. Throws what `open` throws.
  HotplugDevice(std::filesystem::path path, Open open);
  HotplugDevice(const HotplugDevice&) = delete;
  HotplugDevice& operator=(const HotplugDevice&) = delete;

  /// Waits for an attempt that is under way.
  ~HotplugDevice();

  /// Whether it was there when it was read or looked for last.
  [[nodiscard]] bool is_there() const noexcept { return state_ == State::there; }

  /// If it is gone: takes it if it was opened, or asks for an attempt, once in kRetry.
  /// @param now  s, never less than before
  void look(double now) noexcept;

  /// @return  bytes; negative if there is nothing now; 0 if it is gone
  [[nodiscard]] long read(void* bytes, std::size_t size) noexcept;

 private:
  enum class State : int {
    there,   // file_ can be read
    gone,    // file_ is what is left of it
    sought,  // file_ is the thread's
    tried,   // file_ is open if the thread found it
    ended,   // the thread shall end
  };

  void seek() noexcept;  // the thread

  std::filesystem::path path_;
  Open open_;
  FileDescriptor file_;
  double next_attempt_ = -std::numeric_limits<double>::infinity();  // s, at the earliest
  std::atomic<State> state_{State::there};
  std::thread thread_;  // last: it uses the others
};

}  // namespace pbdsurg
