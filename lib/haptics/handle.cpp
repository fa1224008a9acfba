// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/handle.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <numbers>
#include <string>

#include <sys/ioctl.h>
#include <termios.h>

#include "lib/haptics/hotplug_device.h"
#include "lib/haptics/open_device.h"

namespace pbdsurg {
namespace {

constexpr float kEndMargin = 0.03F;          // of a range, at each end
constexpr std::size_t kMostBytes = 1 << 14;  // of a poll: four times what the kernel keeps

constexpr OpenAdvice kAdvice{
    "join the group that owns it (sudo usermod -aG dialout $USER) and log in again",
    "plug the handle in and look for it with ls /dev/serial/by-id"};

void check(const JawRange& range) {
  if (std::abs(range.open - range.closed) < kLeastJawSpan) {
    throw InvalidArgument("the jaw's sensor reads " + std::to_string(range.closed) +
                          " closed and " + std::to_string(range.open) +
                          " open; the two must be at least " + std::to_string(kLeastJawSpan) +
                          " apart: look at the sensor and its wires");
  }
}

FileDescriptor open_port(const std::filesystem::path& path) {
  FileDescriptor port = open_device(path, kAdvice);
  termios settings{};
  if (tcgetattr(port.number(), &settings) != 0) {
    throw FileError(path.string() + ": is no serial port");
  }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | HUPCL | CRTSCTS);
  settings.c_cc[VMIN] = 1;  // with 0, no byte would look like the end
  settings.c_cc[VTIME] = 0;
  cfsetspeed(&settings, B115200);
  // two readers would take bytes from each other
  if (ioctl(port.number(), TIOCEXCL) != 0 || tcsetattr(port.number(), TCSANOW, &settings) != 0) {
    throw FileError(open_refusal(path, errno, kAdvice));
  }
  return port;
}

}  // namespace

float jaw_of(const JawRange& range, std::uint16_t reading) noexcept {
  const float way =
      static_cast<float>(reading - range.closed) / static_cast<float>(range.open - range.closed);
  return std::clamp((way - kEndMargin) / (1 - 2 * kEndMargin), 0.0F, 1.0F);
}

void JawCalibration::add(std::uint16_t reading) noexcept {
  least_ = first_ ? std::min(least_, reading) : reading;
  most_ = first_ ? std::max(most_, reading) : reading;
  first_ = first_.value_or(reading);
}

JawRange JawCalibration::range() const {
  const int first = first_.value_or(least_);
  const bool closes_upwards = most_ - first > first - least_;
  const JawRange range =
      closes_upwards ? JawRange{.closed = most_, .open = least_} : JawRange{least_, most_};
  check(range);
  return range;
}

Handle::Handle(const std::filesystem::path& port, const JawRange& range, const Clock& clock)
    : range_(range), clock_(clock), polled_(clock.now()) {
  check(range);
  port_ = std::make_unique<HotplugDevice>(port, open_port);
}

Handle::~Handle() = default;

const HandleState& Handle::poll() noexcept {
  const double now = clock_.now();
  port_->look(now);
  take_lines(now);
  if (counts_.lines > 0) {
    const bool is_lost = now - state_.time > kHold;
    state_.condition = is_lost ? HandleCondition::lost : HandleCondition::live;
    state_.buttons = is_lost ? 0 : report_.buttons;
    move_jaw(now);
  } else {
    state_.condition = port_->is_there() ? HandleCondition::waiting : HandleCondition::lost;
  }
  polled_ = now;
  return state_;
}

std::optional<HandleReport> Handle::report() const noexcept {
  return counts_.lines > 0 ? std::optional(report_) : std::nullopt;
}

void Handle::set_range(const JawRange& range) {
  check(range);
  range_ = range;
  is_catching_up_ = true;
}

void Handle::take_lines(double now) noexcept {
  std::array<char, 1024> bytes;
  for (std::size_t taken = 0; taken < kMostBytes;) {
    const long count = port_->read(bytes.data(), bytes.size());
    if (count <= 0) {
      return;
    }
    for (long i = 0; i < count; ++i) {
      if (!reader_.push(bytes[static_cast<std::size_t>(i)])) {
        continue;
      }
      if (reader_.refusal() == HandleRefusal::none) {
        take_report(now);
      } else {
        ++counts_.refused;
      }
    }
    taken += static_cast<std::size_t>(count);
  }
}

void Handle::take_report(double now) noexcept {
  // one that was lost may have started anew, from 0
  if (counts_.lines > 0 && now - state_.time <= kHold) {
    const auto gap = static_cast<std::uint16_t>(reader_.report().sequence - report_.sequence - 1);
    if (gap >= 0x8000) {  // not newer
      ++counts_.refused;
      return;
    }
    counts_.missed += gap;
  }
  ++counts_.lines;
  report_ = reader_.report();
  state_.time = now;
  state_.roll = static_cast<float>(report_.roll) * (2 * std::numbers::pi_v<float> / 65536);
  state_.condition = HandleCondition::live;
}

void Handle::move_jaw(double now) noexcept {
  const bool is_lost = state_.condition == HandleCondition::lost;
  is_catching_up_ = is_catching_up_ || is_lost;
  const float target = is_lost ? 1 : jaw_of(range_, report_.jaw);
  if (is_catching_up_) {
    const double begin = is_lost ? std::max(polled_, state_.time + kHold) : polled_;
    const auto step = static_cast<float>(kJawSpeed * std::max(now - begin, 0.0));
    state_.jaw += std::clamp(target - state_.jaw, -step, step);
    is_catching_up_ = is_lost || state_.jaw != target;
  } else {
    state_.jaw = target;
  }
}

}  // namespace pbdsurg
