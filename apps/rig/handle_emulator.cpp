// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/handle_emulator.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <system_error>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/file_descriptor.h"

namespace rig {
namespace {

[[noreturn]] void fail() {
  throw pbdsurg::FileError("/dev/ptmx: there is no pseudo-terminal for a handle: " +
                           std::generic_category().message(errno));
}

// What a sketch finds on every Arduino, as far as ours asks for it.
class Arduino {
 public:
  explicit Arduino(const pbdsurg::Clock& clock) : clock_(clock) {}

  std::array<int, 32> pins{};  // readings, as the sketch gets them

 protected:
  // NOLINTBEGIN(readability-identifier-naming)
  static constexpr std::uint8_t A0 = 14, A1 = 15, INPUT_PULLUP = 2;
  static constexpr int LOW = 0, HIGH = 1;

  struct {
    pbdsurg::FileDescriptor port;
    bool loses_lines = false;

    void begin(long) {}
    [[nodiscard]] int availableForWrite() const {
      int waiting = 0;
      const bool is_there = port.is_open() && ioctl(port.number(), TIOCOUTQ, &waiting) == 0;
      return is_there ? 4095 - waiting : 0;
    }
    void write(const char* bytes, std::size_t size) const {
      if (!loses_lines) {
        // there was room; what fails now is lost on its way, as from a real port
        [[maybe_unused]] const ssize_t written = ::write(port.number(), bytes, size);
      }
    }
  } Serial;

  [[nodiscard]] std::uint32_t millis() const {
    return static_cast<std::uint32_t>(std::llround(1000 * clock_.now()));
  }
  [[nodiscard]] int analogRead(std::uint8_t pin) const { return pins[pin]; }
  [[nodiscard]] int digitalRead(std::uint8_t pin) const { return pins[pin]; }
  void pinMode(std::uint8_t pin, std::uint8_t mode) {
    pins[pin] = mode == INPUT_PULLUP ? HIGH : LOW;
  }
  // NOLINTEND(readability-identifier-naming)

 private:
  const pbdsurg::Clock& clock_;
};

// The sketch's globals are this class's members: one board, one sketch.
class Sketch : public Arduino {
 public:
  using Arduino::Arduino;
#include "apps/rig/handle/handle.ino"
};

}  // namespace

class HandleEmulator::Board : public Sketch {
 public:
  explicit Board(const pbdsurg::Clock& clock) : Sketch(clock) {
    Serial.port = pbdsurg::FileDescriptor(posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK));
    const int number = Serial.port.number();
    std::array<char, 64> name{};
    termios settings{};
    if (number < 0 || grantpt(number) != 0 || unlockpt(number) != 0 ||
        ptsname_r(number, name.data(), name.size()) != 0 || tcgetattr(number, &settings) != 0) {
      fail();
    }
    cfmakeraw(&settings);  // or what comes before a Handle opens it would be echoed
    if (tcsetattr(number, TCSANOW, &settings) != 0) {
      fail();
    }
    port = name.data();
    setup();
  }

  void lose_line() {
    Serial.loses_lines = true;
    loop();
    Serial.loses_lines = false;
  }
  void restart() { sequence = 0; }
  void unplug() { Serial.port.close(); }

  std::string port;
};

HandleEmulator::HandleEmulator(const pbdsurg::Clock& clock)
    : board_(std::make_unique<Board>(clock)) {
  set_jaw(1);
}

HandleEmulator::~HandleEmulator() = default;

const std::string& HandleEmulator::port() const {
  return board_->port;
}

void HandleEmulator::set_jaw(float jaw) {
  board_->pins[board_->kJawPin] = static_cast<int>(std::lround(900 - 800 * jaw));
}

void HandleEmulator::set_roll(float roll) {
  const float turns = roll / (2 * std::numbers::pi_v<float>);
  board_->pins[board_->kRollPin] = static_cast<int>(1024 * (turns - std::floor(turns))) % 1024;
}

void HandleEmulator::set_button(int button, bool is_down) {
  board_->pins[board_->kButtonPins[button]] = is_down ? 0 : 1;
}

void HandleEmulator::run() {
  board_->loop();
}

void HandleEmulator::lose_line() {
  board_->lose_line();
}

void HandleEmulator::restart() {
  board_->restart();
}

void HandleEmulator::unplug() {
  board_->unplug();
}

}  // namespace rig
