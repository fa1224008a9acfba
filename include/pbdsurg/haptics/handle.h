// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An instrument's handle at a serial port: jaw, wheel and buttons, which haptic arms lack.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/handle_protocol.h"

namespace pbdsurg {

class HotplugDevice;

/// What a handle's sensor reads at both ends of its way. Either end may be the larger.
struct JawRange {
  std::uint16_t closed = 0;    ///< HandleReport::jaw with the handle pressed together
  std::uint16_t open = 65535;  ///< HandleReport::jaw with the handle let go

  /// Whether the ends are the same.
  friend bool operator==(const JawRange&, const JawRange&) = default;
};

/// The least distance of the ends: 1/32 of the sensor, as a wire that is off reads noise.
inline constexpr int kLeastJawSpan = 2048;

/// How far jaws are open. The outer 3 % at both ends count as closed and open, since fingers do not
/// reach the very ends of a calibration each time.
/// @param reading  HandleReport::jaw
/// @return  0 closed to 1 open
[[nodiscard]] PBDSURG_API float jaw_of(const JawRange& range, std::uint16_t reading) noexcept;

/// Learns the range of a handle from a hand that lets go of it, then closes and opens it.
class PBDSURG_API JawCalibration {
 public:
  /// @param reading  HandleReport::jaw; the first one with the handle let go
  void add(std::uint16_t reading) noexcept;

  /// The range seen until now: of its ends, the one further from the first reading is closed.
  /// @throws InvalidArgument  if the ends are less than kLeastJawSpan apart
  [[nodiscard]] JawRange range() const;

 private:
  std::optional<std::uint16_t> first_;
  std::uint16_t least_ = 0, most_ = 0;
};

/// How a handle is doing.
enum class HandleCondition : std::uint8_t {
  waiting,  ///< no line yet: boards that restart when a port is opened take two seconds
  live,     ///< lines come, or came a moment ago
  lost,     ///< no line for Handle::kHold: to be told to the person, while the jaws open
};

/// A handle at one time.
struct HandleState {
  double time = 0;            ///< s, of the poll that got the newest line
  float jaw = 1;              ///< 0 closed to 1 open
  float roll = 0;             ///< rad, of the wheel, about +z of the instrument; [0, 2 pi)
  std::uint32_t buttons = 0;  ///< bit i: button i is down
  HandleCondition condition = HandleCondition::waiting;  ///< whether the rest can be trusted
};

/// What came over the wire since the handle was made.
struct HandleCounts {
  std::int64_t lines = 0;    ///< that count
  std::int64_t refused = 0;  ///< damaged ones, and those that were sent before one that counts
  std::int64_t missed = 0;   ///< by gaps in the sequence, while the handle was live
};

/// Reads a handle, by polls that never wait. Times are those of polls, no finer than they follow
/// one another: a serial port has no others, and lines come 10 ms apart, about as steps do.
///
/// A handle that falls silent keeps its state for kHold. Then it is lost: its buttons are up, and
/// its jaws open at kJawSpeed, so that tissue slides off and does not snap. When lines come again,
/// the jaws go to where the handle is at the same speed, and then follow it at once.
///
/// After its cable was pulled and plugged in again, the handle comes back by itself: while polls go
/// on, its port is opened anew once a second, in a thread of its own.
///
/// Needs Linux, or another system with POSIX terminals.
class PBDSURG_API Handle {
 public:
  /// s. Twenty-five lines: five times as long as a loaded machine was seen to be late (51 ms), and
  /// at the edge of what a person notices.
  static constexpr double kHold = 0.25;
  /// 1/s. From closed to open in half a second, as a hand would.
  static constexpr double kJawSpeed = 2;

  /// Opens a serial port, with 115,200 baud and for itself alone.
  /// @param port   best a name that stays the same: /dev/serial/by-id/...
  /// @param clock  outlives the handle
  /// @throws FileError        if it cannot be opened or is no serial port; the text says what to do
  /// @throws InvalidArgument  if the ends of the range are less than kLeastJawSpan apart
  Handle(const std::filesystem::path& port, const JawRange& range, const Clock& clock);

  Handle(const Handle&) = delete;             ///< decorators keep references
  Handle& operator=(const Handle&) = delete;  ///< likewise
  ~Handle();                                  ///< waits for a port that is being opened

  /// Takes what came. Cost: one system call where nothing came; no allocation, no lock.
  /// @return  valid until the next poll
  const HandleState& poll() noexcept;

  /// As of the last poll.
  [[nodiscard]] const HandleCounts& counts() const noexcept { return counts_; }

  /// The newest line, for a calibration; nothing before the first.
  [[nodiscard]] std::optional<HandleReport> report() const noexcept;

  /// After a calibration.
  /// @throws InvalidArgument  if the ends are less than kLeastJawSpan apart
  void set_range(const JawRange& range);

 private:
  void take_lines(double now) noexcept;
  void take_report(double now) noexcept;
  void move_jaw(double now) noexcept;

  std::unique_ptr<HotplugDevice> port_;
  JawRange range_;
  const Clock& clock_;
  HandleLineReader reader_;
  HandleState state_;
  HandleReport report_;
  HandleCounts counts_;
  double polled_;               // s
  bool is_catching_up_ = true;  // the jaw is not yet where the handle is
};

}  // namespace pbdsurg
