// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Foot switches that are USB keyboards, whichever window has the focus.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/device.h"

namespace pbdsurg {

class HotplugDevice;

/// Which keys the switches press, by codes of <linux/input-event-codes.h>: KEY_A is 30. 0 is none,
/// where another keyboard has that pedal.
struct PedalKeys {
  std::uint16_t cut = 0;          ///< yellow
  std::uint16_t coagulation = 0;  ///< blue
};

/// Why pedals changed.
enum class PedalCause : std::uint8_t {
  foot,          ///< pressed or let go
  stall,         ///< polls stayed away for longer than PedalKeyboard::kStall
  overflow,      ///< the kernel lost events
  let_go,        ///< PedalKeyboard::let_go()
  disconnected,  ///< the keyboard is gone
};

/// A change of pedals.
struct PedalEvent {
  double time = 0;                      ///< s, of the poll that found it
  Pedals pedals;                        ///< from now on
  PedalCause cause = PedalCause::foot;  ///< why
};

/// Reads one keyboard through evdev, by polls that never wait. While it is open, its keys go to no
/// window.
///
/// A change counts at once, and then not again for kDebounce. Pedals are up when the keyboard is
/// gone, polls have stayed away or events were lost, and stay so until a foot lifts and presses
/// anew: nobody can know what it did meanwhile. For the same reason a foot that was down first
/// counts for nothing. A keyboard sends nothing while a key is held, so that one which hangs with a
/// key down is not noticed.
///
/// Times are those of polls, though the kernel has finer ones. A pedal acts from the poll that
/// finds it on: a time before that would tell of current that did not flow. A poll never comes
/// before the change that it finds, so contacts are at rest kDebounce after it, too. And what a
/// session does depends on its clock alone.
///
/// After its cable was pulled and plugged in again, the keyboard comes back by itself: while polls
/// go on, it is opened anew once a second, in a thread of its own.
///
/// Needs Linux.
class PBDSURG_API PedalKeyboard {
 public:
  /// s. Contacts bounce for up to 10 ms; a foot cannot tap in less than 50 ms.
  static constexpr double kDebounce = 0.02;
  /// s. About as long as a person takes to react.
  static constexpr double kStall = 0.25;

  /// Opens a keyboard and takes it for itself.
  /// @param path   best a name that stays the same: /dev/input/by-id/...-event-kbd; a pipe, too,
  ///               that has records of type input_event
  /// @param clock  outlives this
  /// @throws FileError        if it cannot be opened, or another program has it; the text says what
  ///                          to do
  /// @throws InvalidArgument  if the keys are no keys, none, or the same
  PedalKeyboard(const std::filesystem::path& path, const PedalKeys& keys, const Clock& clock);

  PedalKeyboard(const PedalKeyboard&) = delete;             ///< decorators keep references
  PedalKeyboard& operator=(const PedalKeyboard&) = delete;  ///< likewise
  ~PedalKeyboard();  ///< waits for a keyboard that is being opened

  /// Takes what came. Cost: one system call where nothing came; no allocation, no lock.
  /// @return  whether pedals changed: event() is new
  bool poll() noexcept;

  /// Pedals up until pressed anew, as when the operation is interrupted.
  /// @return  whether pedals changed: event() is new
  bool let_go() noexcept;

  /// The newest change; before any, all pedals are up.
  [[nodiscard]] const PedalEvent& event() const noexcept { return event_; }

  /// Whether the keyboard is there, as of the last poll.
  [[nodiscard]] bool is_connected() const noexcept;

 private:
  struct Switch {
    std::uint16_t key = 0;
    bool is_pressed = false;  // as the keyboard says
    bool is_down = false;     // as it counts
    double changed = -1;      // s, when is_down did

    void settle(double now) noexcept;
  };

  // of a record, struct input_event
  struct Key {
    std::uint16_t type, code;
    std::int32_t value;
  };

  void read(double now) noexcept;
  void take(const Key& key, double now) noexcept;
  void lift(PedalCause cause, double now) noexcept;
  bool note(double now) noexcept;

  std::unique_ptr<HotplugDevice> keyboard_;
  Switch cut_, coagulation_;
  const Clock& clock_;
  double polled_;  // s
  PedalEvent event_;
  PedalCause cause_ = PedalCause::foot;  // of a change that this poll finds
  std::array<std::byte, 1536> bytes_{};  // records; a pipe may break one
  std::size_t byte_count_ = 0;
};

}  // namespace pbdsurg
