// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A handle without hardware: the microcontroller's own sketch, at a serial port that is none.

#include <memory>
#include <string>

#include "pbdsurg/base/clock.h"

namespace rig {

/// Runs apps/rig/handle/handle.ino on pins of its own and a pseudo-terminal. Several run side by
/// side. Needs Linux.
class HandleEmulator {
 public:
  /// @param clock  drives the sketch's millis(); outlives the emulator
  /// @throws pbdsurg::FileError  if the system has no pseudo-terminal left
  explicit HandleEmulator(const pbdsurg::Clock& clock);
  ~HandleEmulator();

  /// Where a Handle finds it: "/dev/pts/4".
  [[nodiscard]] const std::string& port() const;

  /// @name What fingers do
  /// @{
  void set_jaw(float jaw);    ///< 0 closed to 1 open; the sensor reads 900 of 1023 to 100
  void set_roll(float roll);  ///< rad, to the right; any number of turns
  void set_button(int button, bool is_down);  ///< 0 or 1
  /// @}

  /// Runs the sketch's loop() once: a line, if it is time for one and there is room for it.
  void run();

  /// The same, with the line lost on its way.
  void lose_line();

  /// As if the button on the board were pressed: the sequence begins anew.
  void restart();

  /// As if the cable were pulled.
  void unplug();

 private:
  class Board;
  std::unique_ptr<Board> board_;
};

}  // namespace rig
