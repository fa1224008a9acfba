// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/device_trace.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>

#include "pbdsurg/base/write_file.h"

#include "lib/haptics/check_device.h"

namespace pbdsurg {
namespace {

constexpr std::string_view kFirstLine = "# pbdsurg device trace 1";
constexpr std::string_view kName = "# name ";
constexpr std::string_view kBegin = "# begin_s ";
constexpr std::string_view kColumns =
    "# asked_s time_s connected jaw buttons cut coagulation x_m y_m z_m "
    "xx xy xz yx yy yz zx zy zz fx_n fy_n fz_n";

template <class Number>
void append(std::string& text, Number number) {
  char digits[32];
  const auto written = std::to_chars(digits, digits + sizeof(digits), number);
  text.append(digits, written.ptr).push_back(' ');
}

void append_vector(std::string& text, const Eigen::Vector3f& vector) {
  for (const float number : vector) {
    append(text, number);
  }
}

// Reads a trace line by line. Failures name the line.
class TraceReader {
 public:
  explicit TraceReader(const std::filesystem::path& path)
      : path_(path.string()), stream_(path, std::ios::binary) {
    if (!stream_) {
      throw FileError(path_ + ": cannot be opened");
    }
  }

  DeviceTrace read() {
    DeviceTrace trace;
    expect(kFirstLine);
    trace.name = rest_after(kName);
    left_ = rest_after(kBegin);
    trace.begin = number<double>("the begin");
    end_line();
    expect(kColumns);
    while (next_line()) {
      trace.samples.push_back(sample());
      end_line();
      const double before =
          trace.samples.size() > 1 ? trace.samples.rbegin()[1].asked : trace.begin;
      if (trace.samples.back().asked < before) {
        fail("it was asked for at " + std::to_string(trace.samples.back().asked) +
             " s; that must not be before the line before, or the begin, at " +
             std::to_string(before) + " s");
      }
    }
    if (trace.samples.empty()) {
      throw FileError(path_ + ": holds no state; a trace has one at least");
    }
    return trace;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw FileError::at_line(path_, line_number_, reason);
  }

  bool next_line() {
    if (!std::getline(stream_, line_)) {
      if (stream_.bad()) {
        throw FileError(path_ + ": cannot be read to its end");
      }
      return false;
    }
    ++line_number_;
    if (stream_.eof()) {
      fail("the file ends within this line; it was cut short");
    }
    left_ = line_;
    return true;
  }

  void expect(std::string_view line) {
    if (!next_line() || line_ != line) {
      fail("'" + line_.substr(0, 80) + "' stands where '" + std::string(line) + "' must");
    }
  }

  std::string_view rest_after(std::string_view begin) {
    if (!next_line() || left_.substr(0, begin.size()) != begin) {
      fail("'" + line_.substr(0, 80) + "' stands where a line must begin with '" +
           std::string(begin) + "'");
    }
    return left_.substr(begin.size());
  }

  std::string_view column(std::string_view what) {
    if (left_.empty()) {
      fail("the line ends where " + std::string(what) + " must be");
    }
    const std::size_t end = std::min(left_.find(' '), left_.size());
    const std::string_view text = left_.substr(0, end);
    left_.remove_prefix(std::min(end + 1, left_.size()));
    return text;
  }

  // finite, and from least to most
  template <class Number>
  Number number(std::string_view what, Number least = std::numeric_limits<Number>::lowest(),
                Number most = std::numeric_limits<Number>::max()) {
    const std::string_view text = column(what);
    Number value{};
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) {
      fail("'" + std::string(text.substr(0, 80)) + "' stands where " + std::string(what) +
           " must be");
    }
    if (!(value >= least && value <= most)) {
      const bool has_bounds = most < std::numeric_limits<Number>::max();
      fail(std::string(what) + " is " + std::string(text.substr(0, 80)) + "; it must be " +
           (has_bounds ? std::to_string(least) + " to " + std::to_string(most) : "finite"));
    }
    return value;
  }

  bool flag(std::string_view what) { return number<unsigned>(what, 0, 1) == 1; }

  Eigen::Vector3f vector(std::string_view what) {
    Eigen::Vector3f vector;
    for (float& coordinate : vector) {
      coordinate = number<float>(what);
    }
    return vector;
  }

  DeviceSample sample() {
    DeviceSample sample;
    DeviceState& state = sample.state;
    sample.asked = number<double>("the time of asking");
    state.time = number<double>("the time of the state");
    state.is_connected = flag("whether it is connected");
    state.jaw = number<float>("the jaw", 0, 1);
    state.buttons = number<std::uint32_t>("the buttons");
    state.pedals.cut = flag("the pedal of cut");
    state.pedals.coagulation = flag("the pedal of coagulation");
    state.pose.translation() = vector("the tip");
    Eigen::Matrix3f axes;
    for (int axis = 0; axis < 3; ++axis) {
      axes.col(axis) = vector("an axis");
    }
    if (!is_rotation(axes)) {
      fail("its axes must be of unit length, at right angles and right-handed, to 1e-3");
    }
    state.pose.linear() = axes;
    sample.force = vector("the force");
    return sample;
  }

  void end_line() {
    if (!left_.empty()) {
      fail("'" + std::string(left_.substr(0, 80)) + "' stands where the line must end");
    }
  }

  std::string path_;
  std::ifstream stream_;
  std::string line_;
  std::string_view left_;  // of line_, without the columns that were read
  long line_number_ = 0;
};

class RecordedDevice final : public Device {
 public:
  RecordedDevice(std::unique_ptr<Device> device, DeviceTrace& trace, const Clock& clock)
      : device_(std::move(device)), trace_(trace), clock_(clock) {}

  [[nodiscard]] std::string name() const override { return device_->name(); }
  [[nodiscard]] DeviceState state() noexcept override {
    const DeviceState state = device_->state();
    if (trace_.samples.size() < trace_.samples.capacity()) {
      trace_.samples.push_back({clock_.now(), state, Eigen::Vector3f::Zero()});
    } else {
      ++trace_.lost;
    }
    return state;
  }
  void set_force(const Eigen::Vector3f& force) noexcept override {
    if (!trace_.samples.empty() && trace_.lost == 0) {
      trace_.samples.back().force = force;
    }
    device_->set_force(force);
  }

 private:
  std::unique_ptr<Device> device_;
  DeviceTrace& trace_;
  const Clock& clock_;
};

class ReplayedDevice final : public Device {
 public:
  ReplayedDevice(DeviceTrace trace, const Clock& clock)
      : trace_(std::move(trace)), clock_(clock), shift_(clock.now() - trace_.begin) {}

  [[nodiscard]] std::string name() const override { return trace_.name; }
  [[nodiscard]] DeviceState state() noexcept override {
    const double time = clock_.now() - shift_;
    while (come_ < trace_.samples.size() && trace_.samples[come_].asked <= time) {
      ++come_;
    }
    const std::size_t newest = come_ > 0 ? come_ - 1 : 0;
    DeviceState state = trace_.samples[newest].state;
    state.time += shift_;
    if (come_ == 0 || time > trace_.samples.back().asked) {
      state.is_connected = false;
      state.pedals = {};
    }
    return state;
  }

 private:
  DeviceTrace trace_;
  const Clock& clock_;
  double shift_;          // s, from the trace's time to the clock's
  std::size_t come_ = 0;  // samples whose time has come; clocks never go back
};

}  // namespace

DeviceTrace read_device_trace(const std::filesystem::path& path) {
  return TraceReader(path).read();
}

void write_device_trace(const std::filesystem::path& path, const DeviceTrace& trace) {
  if (trace.name.find('\n') != std::string::npos) {
    throw InvalidArgument("the name of a trace has a line break; it must be one line");
  }
  write_file(path, [&](std::ostream& out) {
    std::string line;
    append(line, trace.begin);
    line.back() = '\n';
    out << kFirstLine << '\n' << kName << trace.name << '\n' << kBegin << line << kColumns << '\n';
    for (const DeviceSample& sample : trace.samples) {
      const DeviceState& state = sample.state;
      line.clear();
      append(line, sample.asked);
      append(line, state.time);
      append(line, static_cast<int>(state.is_connected));
      append(line, state.jaw);
      append(line, state.buttons);
      append(line, static_cast<int>(state.pedals.cut));
      append(line, static_cast<int>(state.pedals.coagulation));
      append_vector(line, state.pose.translation());
      for (int axis = 0; axis < 3; ++axis) {
        append_vector(line, state.pose.linear().col(axis));
      }
      append_vector(line, sample.force);
      line.back() = '\n';
      out << line;
    }
  });
}

std::unique_ptr<Device> recorded(std::unique_ptr<Device> device, DeviceTrace& trace,
                                 std::size_t capacity, const Clock& clock) {
  check_device(device.get());
  if (capacity == 0) {
    throw InvalidArgument("a trace has room for 0 samples; it must have room for one");
  }
  trace = {.name = device->name(), .begin = clock.now(), .samples = {}, .lost = 0};
  trace.samples.reserve(capacity);
  return std::make_unique<RecordedDevice>(std::move(device), trace, clock);
}

std::unique_ptr<Device> replayed(DeviceTrace trace, const Clock& clock) {
  if (trace.samples.empty()) {
    throw InvalidArgument("the trace of " + trace.name + " holds no sample; it must hold one");
  }
  double before = trace.begin;
  for (std::size_t i = 0; i < trace.samples.size(); ++i) {
    const double asked = trace.samples[i].asked;
    if (!std::isfinite(asked) || !(asked >= before)) {
      throw InvalidArgument("sample " + std::to_string(i) + " of the trace of " + trace.name +
                            " was asked for at " + std::to_string(asked) +
                            " s; that must be finite and not before the one before");
    }
    before = asked;
  }
  return std::make_unique<ReplayedDevice>(std::move(trace), clock);
}

}  // namespace pbdsurg
