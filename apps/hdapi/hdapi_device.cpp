// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/hdapi_device.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <optional>
#include <utility>

#include <HD/hd.h>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/safety_chain.h"

#include "apps/hdapi/force_gate.h"
#include "apps/hdapi/hdapi_pose.h"

namespace rig {
namespace {

using pbdsurg::BackendUnavailable;
using pbdsurg::InvalidArgument;

constexpr double kPeriod = 1e-3;       // s, of USB devices
constexpr double kLate = 1.5;          // periods between ticks, that count as late
constexpr double kDropped = 1.9;       // periods between ticks, that count as a tick too few
constexpr double kClockJump = 0.1;     // s between ticks
constexpr double kStalled = 0.25;      // s without a tick, after which nobody is there
constexpr double kMostStopTime = 0.1;  // s, for forces to go to zero; a slew of 2.6 N takes 0.013
constexpr int kMostUpdates = 5;        // of a calibration, before it is stuck
constexpr int kMostErrors = 64;  // that are taken at once: a broken stack must not hang a tick

/// A force that the vendor's driver reports can be wrong by units; then that of a Touch.
constexpr float kLeastForce = 0.5f, kGreatestForce = 40, kTouchForce = 3.3f;  // N
constexpr float kTouchContinuousForce = 0.88f;                                // N

/// Calls a function with each error that waits.
template <class Function>
void take_errors(Function&& function) {
  for (int count = 0; count < kMostErrors; ++count) {
    const HDErrorInfo info = hdGetError();
    if (!HD_DEVICE_ERROR(info)) {
      return;
    }
    function(info);
  }
}

void drop_errors() {
  take_errors([](const HDErrorInfo&) {});
}

/// The newest error that waits, if there is one; none is left.
std::optional<HDerror> newest_error() {
  std::optional<HDerror> newest;
  take_errors([&](const HDErrorInfo& info) { newest = newest.value_or(info.errorCode); });
  return newest;
}

DeviceFault fault_of(HDerror error) {
  switch (error) {
    case HD_WARM_MOTORS:
      return DeviceFault::warm_motors;
    case HD_EXCEEDED_MAX_FORCE:
      return DeviceFault::exceeded_force;
    case HD_EXCEEDED_MAX_FORCE_IMPULSE:
      return DeviceFault::exceeded_impulse;
    case HD_EXCEEDED_MAX_VELOCITY:
      return DeviceFault::exceeded_velocity;
    case HD_FORCE_ERROR:
      return DeviceFault::force_error;
    case HD_DEVICE_FAULT:
      return DeviceFault::device_failure;
    case HD_COMM_ERROR:
    case HD_COMM_CONFIG_ERROR:
      return DeviceFault::lost_communication;
    case HD_TIMER_ERROR:
    case HD_INVALID_LICENSE:
      return DeviceFault::scheduler_failure;
    case HD_BAD_HANDLE:
      return DeviceFault::wrong_handle;
    default:
      return DeviceFault::bad_call;
  }
}

/// A frame of a device, which ends with this object if it began.
class Frame {
 public:
  /// Errors of the beginning wait for whoever takes them.
  explicit Frame(HHD handle) : handle_(handle) { hdBeginFrame(handle); }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  ~Frame() {
    if (is_open_) {
      hdEndFrame(handle_);
    }
  }

  /// It did not begin: its calls would be about another device.
  void abandon() { is_open_ = false; }

 private:
  HHD handle_;
  bool is_open_ = true;
};

/// A device that is open.
class OpenDevice {
 public:
  /// @throws BackendUnavailable  if HDAPI cannot open it
  explicit OpenDevice(const HdapiDeviceOptions& options) {
    handle_ = hdInitDevice(options.name.empty() ? HD_DEFAULT_DEVICE : options.name.c_str());
    if (const std::optional<HDerror> error = newest_error()) {
      const std::string device = options.name.empty() ? "the default haptic device"
                                                      : "haptic device '" + options.name + "'";
      throw BackendUnavailable(device + " (" + options.label +
                               ") does not open: " + hdGetErrorString(*error) +
                               "; it must be plugged in and have this name in the vendor's setup");
    }
  }
  OpenDevice(OpenDevice&& other) noexcept
      : handle_(std::exchange(other.handle_, HD_INVALID_HANDLE)) {}
  OpenDevice& operator=(OpenDevice&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~OpenDevice() {
    if (handle_ != HD_INVALID_HANDLE) {
      hdDisableDevice(handle_);
      drop_errors();
    }
  }

  [[nodiscard]] HHD handle() const { return handle_; }

 private:
  HHD handle_ = HD_INVALID_HANDLE;
};

float believable(float value, float typical) {
  return value >= kLeastForce && value <= kGreatestForce ? value : typical;
}

/// Of the current device. What a model does not tell stays as it was.
HdapiLimits read_limits() {
  HDdouble max_force = 0;
  HDdouble max_continuous_force = 0;
  std::array<HDdouble, 6> workspace{};
  hdGetDoublev(HD_NOMINAL_MAX_FORCE, &max_force);
  hdGetDoublev(HD_NOMINAL_MAX_CONTINUOUS_FORCE, &max_continuous_force);
  hdGetDoublev(HD_USABLE_WORKSPACE_DIMENSIONS, workspace.data());
  const auto text = [](HDenum name) {
    const HDstring value = hdGetString(name);
    return std::string(value != nullptr ? value : "");
  };
  HdapiLimits limits;
  limits.max_force = believable(static_cast<float>(max_force), kTouchForce);
  limits.max_continuous_force =
      std::min(believable(static_cast<float>(max_continuous_force), kTouchContinuousForce),
               limits.max_force);
  const Eigen::Map<const Eigen::Matrix<double, 3, 2>> corners(workspace.data());
  limits.workspace.extend((kMetresOfMillimetre * corners.col(0)).cast<float>());
  limits.workspace.extend((kMetresOfMillimetre * corners.col(1)).cast<float>());
  limits.model = text(HD_DEVICE_MODEL_TYPE);
  limits.serial_number = text(HD_DEVICE_SERIAL_NUMBER);
  limits.driver = text(HD_DEVICE_DRIVER_VERSION);
  drop_errors();
  return limits;
}

/// The way to calibrate the current device that asks the least of a person.
HDenum calibration_style() {
  HDint styles = 0;
  hdGetIntegerv(HD_CALIBRATION_STYLE, &styles);
  if ((styles & HD_CALIBRATION_AUTO) != 0) {
    return HD_CALIBRATION_AUTO;
  }
  return (styles & HD_CALIBRATION_INKWELL) != 0 ? HD_CALIBRATION_INKWELL
                                                : HD_CALIBRATION_ENCODER_RESET;
}

/// Bit i: button i is down.
std::uint32_t read_buttons() {
  HDint buttons = 0;
  hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
  std::uint32_t down = 0;
  std::uint32_t bit = 1;
  for (const HDint button :
       {HD_DEVICE_BUTTON_1, HD_DEVICE_BUTTON_2, HD_DEVICE_BUTTON_3, HD_DEVICE_BUTTON_4}) {
    down |= (buttons & button) != 0 ? bit : 0;
    bit <<= 1;
  }
  return down;
}

Eigen::Vector3f read_vector(HDenum parameter, double scale) {
  Eigen::Vector3d values = Eigen::Vector3d::Zero();
  hdGetDoublev(parameter, values.data());
  return (scale * values).cast<float>();
}

bool is_in_inkwell() {
  HDboolean is_parked = 0;
  hdGetBooleanv(HD_CURRENT_INKWELL_SWITCH, &is_parked);
  return is_parked != 0;
}

/// 0 cold to 1 warm
float warmest_motor() {
  std::array<HDdouble, 6> temperatures{};  // of three motors, or six
  hdGetDoublev(HD_MOTOR_TEMPERATURE, temperatures.data());
  return static_cast<float>(*std::max_element(temperatures.begin(), temperatures.end()));
}

/// What not all models tell. Asked in each tick, it would be an error in each.
struct Extras {
  bool has_inkwell = false;
  bool has_gimbal = false;
  bool has_temperature = false;
};

/// Of the current device.
Extras find_extras() {
  Extras extras;
  is_in_inkwell();
  extras.has_inkwell = !newest_error();
  read_vector(HD_CURRENT_GIMBAL_ANGLES, 1);
  extras.has_gimbal = !newest_error();
  warmest_motor();
  extras.has_temperature = !newest_error();
  return extras;
}

/// The session of the process, while this object lives.
class OnlySession {
 public:
  OnlySession() {
    if (lives.exchange(true)) {
      throw BackendUnavailable(
          "there is a haptic session already; it must end first, as a process has one scheduler");
    }
  }
  OnlySession(const OnlySession&) = delete;
  OnlySession& operator=(const OnlySession&) = delete;
  ~OnlySession() { lives = false; }

 private:
  static inline std::atomic<bool> lives{false};
};

/// What the servo's thread tells the others.
struct Published {
  pbdsurg::DeviceState state;
  HdapiStatus status;
};

}  // namespace

/// All is the scheduler's thread's while the scheduler runs, but for the reader's side of the
/// mailbox and what is constant.
struct HdapiDevice::Servo {
  Servo(HdapiDeviceOptions options_of_device, OpenDevice device)
      : options(std::move(options_of_device)), open(std::move(device)) {}

  void begin();
  void tick(double time, std::optional<DeviceFault> of_clock, std::uint64_t dropped,
            bool is_stopping);
  void look();
  void note(DeviceFault fault, std::uint64_t count = 1);
  void take_faults();
  [[nodiscard]] bool take_faults_of_call();
  void note_error(const HDErrorInfo& info);

  HdapiDeviceOptions options;
  OpenDevice open;
  HdapiLimits limits{};
  Extras extras{};
  ForceGate gate{0, static_cast<float>(kPeriod)};  // closed until begin()

  pbdsurg::DeviceState state{};
  HdapiStatus status{};
  int update_count = 0;       // of the calibration, in a row
  bool has_fault = false;     // of those that stop the force, which no callback was told of yet
  bool is_warm = false;       // likewise
  bool is_abandoned = false;  // lost, and its motors have been told zero
  const std::vector<std::unique_ptr<HdapiDevice>>* session_devices = nullptr;  // this among them
  pbdsurg::Mailbox<Published> mailbox;

 private:
  void read();
  [[nodiscard]] Eigen::Vector3f ask(bool is_ready, bool was_warm);
  void exchange(bool is_stopping);
};

/// What must be done before the scheduler starts.
void HdapiDevice::Servo::begin() {
  gate = ForceGate(pbdsurg::limits_of_motors(limits.max_force, limits.max_continuous_force).peak,
                   static_cast<float>(kPeriod));
  hdMakeCurrentDevice(open.handle());
  for (const HDenum capability : {HD_FORCE_OUTPUT, HD_FORCE_RAMPING, HD_MAX_FORCE_CLAMPING}) {
    hdEnable(capability);
  }
  if (const std::optional<HDerror> error = newest_error()) {
    throw BackendUnavailable(
        "haptic device '" + options.label +
        "' refuses force with its ramp and clamp: " + hdGetErrorString(*error));
  }
  look();
  if (status.is_lost) {
    throw BackendUnavailable("haptic device '" + options.label + "' answers no more");
  }
}

void HdapiDevice::Servo::note(DeviceFault fault, std::uint64_t count) {
  if (is_fatal(fault)) {
    if (status.is_lost) {
      return;  // it repeats itself
    }
    status.is_lost = true;
  }
  has_fault = has_fault || stops_force(fault);
  is_warm = is_warm || fault == DeviceFault::warm_motors;
  status.faults.add(fault, count);
}

/// Errors say which device they are of; they may come while another is looked at.
void HdapiDevice::Servo::note_error(const HDErrorInfo& info) {
  const DeviceFault fault = fault_of(info.errorCode);
  Servo* owner = this;
  for (const std::unique_ptr<HdapiDevice>& device : *session_devices) {
    if (fault == DeviceFault::scheduler_failure) {
      device->servo_->note(fault);  // there is one for all
    } else if (device->servo_->open.handle() == info.hHD) {
      owner = device->servo_.get();
    }
  }
  if (fault != DeviceFault::scheduler_failure) {
    owner->note(fault);
  }
}

void HdapiDevice::Servo::take_faults() {
  take_errors([this](const HDErrorInfo& info) { note_error(info); });
}

/// After a call that makes this device the current one, and a take_faults() before it. A refusal is
/// this device's, whichever was current until then.
/// @return  whether HDAPI took the call
bool HdapiDevice::Servo::take_faults_of_call() {
  bool is_taken = true;
  take_errors([&](const HDErrorInfo& info) {
    const DeviceFault fault = fault_of(info.errorCode);
    if (fault == DeviceFault::wrong_handle || fault == DeviceFault::bad_call) {
      is_taken = false;
      note(fault);
    } else {
      note_error(info);
    }
  });
  return is_taken;
}

/// Goes on with the calibration of the device, and looks who it is. The errors before are taken.
void HdapiDevice::Servo::look() {
  hdMakeCurrentDevice(open.handle());
  if (!take_faults_of_call()) {
    return;  // what follows would be about another device
  }
  HDenum calibration = hdCheckCalibration();
  if (calibration == HD_CALIBRATION_NEEDS_UPDATE) {
    hdUpdateCalibration(calibration_style());
    calibration = hdCheckCalibration();
  }
  if (calibration == HD_CALIBRATION_OK) {
    status.calibration = HdapiCalibration::done;
    update_count = 0;
  } else if (calibration == HD_CALIBRATION_NEEDS_UPDATE) {
    status.calibration = HdapiCalibration::under_way;
    if (++update_count == kMostUpdates) {
      note(DeviceFault::stuck_calibration);
    }
  } else {
    status.calibration = HdapiCalibration::needs_inkwell;
    update_count = 0;
  }
  const HDstring serial_number = hdGetString(HD_DEVICE_SERIAL_NUMBER);
  if (!options.serial_number.empty() && serial_number != nullptr &&
      options.serial_number != serial_number) {
    note(DeviceFault::swapped_devices);
  }
  take_faults();
}

/// Reads the frame of the current device.
void HdapiDevice::Servo::read() {
  std::array<HDdouble, 16> transform{};
  hdGetDoublev(HD_CURRENT_TRANSFORM, transform.data());
  status.velocity = read_vector(HD_CURRENT_VELOCITY, kMetresOfMillimetre);
  if (extras.has_inkwell) {
    status.is_in_inkwell = is_in_inkwell();
  }
  if (extras.has_gimbal) {
    status.gimbal_angles = read_vector(HD_CURRENT_GIMBAL_ANGLES, 1);
  }
  if (extras.has_temperature) {
    status.motor_temperature = warmest_motor();
  }
  const std::optional<Eigen::Isometry3f> pose = pose_of(transform);
  if (!pose || !status.velocity.allFinite()) {
    note(DeviceFault::bad_reading);
    status.velocity.setZero();
    return;
  }
  state.pose = *pose;
  state.buttons = read_buttons();
}

/// The force that is asked for. It is called also where nothing will pass, and when the device is
/// gone: the safety chain behind it has to know, and tells of its own force until that is zero.
Eigen::Vector3f HdapiDevice::Servo::ask(bool is_ready, bool was_warm) {
  if (!options.force) {
    return Eigen::Vector3f::Zero();
  }
  const Eigen::Vector3f wanted =
      options.force({state.time, state.pose, status.velocity, state.buttons, is_ready, was_warm});
  if (!wanted.allFinite()) {
    note(DeviceFault::simulation_not_a_number);
  }
  return is_ready ? wanted : Eigen::Vector3f::Zero();
}

/// One frame: where the device is, and what its motors shall do.
void HdapiDevice::Servo::exchange(bool is_stopping) {
  take_faults();  // which others left: they must not seem to be the frame's
  Frame frame(open.handle());
  const bool has_begun = take_faults_of_call();
  if (has_begun && !status.is_lost) {
    read();
    take_faults();
  }
  if (!has_begun || status.is_lost) {
    status.velocity.setZero();
  }
  const bool is_ready =
      !has_fault && !status.is_lost && !is_stopping && status.calibration == HdapiCalibration::done;
  // what comes from here on is for the next tick's callback
  has_fault = false;
  const Eigen::Vector3f wanted = ask(is_ready, std::exchange(is_warm, false));
  if (has_begun) {
    const Eigen::Vector3d force = gate.pass(wanted).cast<double>();
    hdSetDoublev(HD_CURRENT_FORCE, force.data());
  } else {
    frame.abandon();  // the motors may still have the last force: the gate stays there
  }
  is_abandoned = status.is_lost && gate.force().isZero(0);
}

/// @param of_clock  what the time of this tick shows
/// @param dropped   ticks that should have been since the last one
void HdapiDevice::Servo::tick(double time, std::optional<DeviceFault> of_clock,
                              std::uint64_t dropped, bool is_stopping) {
  if (of_clock) {
    note(*of_clock, std::max<std::uint64_t>(dropped, 1));
  }
  state.time = time;
  if (is_abandoned) {
    static_cast<void>(ask(false, false));
  } else {
    exchange(is_stopping);
  }
  take_faults();
  status.commanded_force = gate.force();
  ++status.tick_count;
  state.is_connected = !status.is_lost;
  mailbox.draft() = {state, status};
  mailbox.publish();
}

HdapiDevice::HdapiDevice(std::unique_ptr<Servo> servo, const pbdsurg::Clock& clock)
    : servo_(std::move(servo)), clock_(clock) {}

HdapiDevice::~HdapiDevice() = default;

std::string HdapiDevice::name() const {
  return servo_->limits.model + " (" + servo_->options.label + ")";
}

pbdsurg::DeviceState HdapiDevice::state() noexcept {
  servo_->mailbox.take();
  pbdsurg::DeviceState state = servo_->mailbox.value().state;
  state.is_connected = state.is_connected && clock_.now() - state.time < kStalled;
  return state;
}

HdapiStatus HdapiDevice::status() noexcept {
  servo_->mailbox.take();
  return servo_->mailbox.value().status;
}

const HdapiLimits& HdapiDevice::limits() const noexcept {
  return servo_->limits;
}

const char* hdapi_flavour() noexcept {
  return PBDSURG_HDAPI_FLAVOUR;
}

/// The one callback of the scheduler.
struct HdapiSession::Ticker {
  explicit Ticker(pbdsurg::Clock& session_clock) : clock(session_clock) {}
  Ticker(const Ticker&) = delete;
  Ticker& operator=(const Ticker&) = delete;
  ~Ticker();

  void open(std::vector<HdapiDeviceOptions> options);
  void start();
  void tick() noexcept;
  static HDCallbackCode HDCALLBACK call(void* data) {
    static_cast<Ticker*>(data)->tick();
    return HD_CALLBACK_CONTINUE;
  }

  OnlySession only{};  // first: devices are closed before another session begins
  pbdsurg::Clock& clock;
  std::vector<std::unique_ptr<HdapiDevice>> devices{};
  std::optional<HDSchedulerHandle> callback{};
  std::optional<double> last_time{};       // s, of a tick; the scheduler's thread's
  std::atomic<bool> is_looked_for{false};  // a look at calibrations is asked for
  std::atomic<bool> is_stopping{false};
  std::atomic<bool> is_quiet{false};  // stopping, and all forces are zero

 private:
  void exchange_swapped();
};

void HdapiSession::Ticker::open(std::vector<HdapiDeviceOptions> options) {
  drop_errors();  // of whoever came before
  for (HdapiDeviceOptions& device : options) {
    OpenDevice open_device(device);
    auto servo = std::make_unique<HdapiDevice::Servo>(std::move(device), std::move(open_device));
    hdMakeCurrentDevice(servo->open.handle());
    servo->limits = read_limits();
    servo->extras = find_extras();
    servo->session_devices = &devices;
    devices.push_back(std::make_unique<HdapiDevice>(std::move(servo), clock));
  }
  exchange_swapped();
  for (const std::unique_ptr<HdapiDevice>& device : devices) {
    HdapiDevice::Servo& servo = *device->servo_;
    servo.begin();
    servo.state.time = clock.now();
    servo.mailbox.draft() = {servo.state, servo.status};
    servo.mailbox.publish();
  }
}

/// Gives each the device that has its serial number.
void HdapiSession::Ticker::exchange_swapped() {
  for (const std::unique_ptr<HdapiDevice>& device : devices) {
    HdapiDevice::Servo& servo = *device->servo_;
    const std::string& wanted = servo.options.serial_number;
    if (wanted.empty() || wanted == servo.limits.serial_number) {
      continue;
    }
    const auto other = std::find_if(devices.begin(), devices.end(), [&](const auto& candidate) {
      return candidate->servo_->limits.serial_number == wanted;
    });
    if (other == devices.end()) {
      throw BackendUnavailable("haptic device '" + servo.options.label + "' has serial number '" +
                               servo.limits.serial_number + "'; it must be '" + wanted + "'");
    }
    HdapiDevice::Servo& swapped = *(*other)->servo_;
    std::swap(servo.open, swapped.open);
    std::swap(servo.limits, swapped.limits);
    std::swap(servo.extras, swapped.extras);
    for (HdapiDevice::Servo* const exchanged : {&servo, &swapped}) {
      exchanged->status.faults.add(DeviceFault::swapped_devices);
    }
  }
}

void HdapiSession::Ticker::start() {
  callback = hdScheduleAsynchronous(&Ticker::call, this, HD_MAX_SCHEDULER_PRIORITY);
  if (const std::optional<HDerror> error = newest_error()) {
    callback.reset();
    throw BackendUnavailable(std::string("the haptic scheduler takes no callback: ") +
                             hdGetErrorString(*error));
  }
  hdStartScheduler();
  if (const std::optional<HDerror> error = newest_error()) {
    throw BackendUnavailable(std::string("the haptic scheduler does not start: ") +
                             hdGetErrorString(*error));
  }
}

HdapiSession::Ticker::~Ticker() {
  is_stopping = true;
  if (callback) {
    const double deadline = clock.now() + kMostStopTime;
    while (!is_quiet && clock.now() < deadline) {
      clock.wait_until(clock.now() + kPeriod);
    }
    hdStopScheduler();
    hdUnschedule(*callback);
  }
  drop_errors();
}

void HdapiSession::Ticker::tick() noexcept {
  const double time = clock.now();
  // the scheduler may take its time until the first tick
  const double interval = time - last_time.value_or(time - kPeriod);
  last_time = time;
  std::optional<DeviceFault> of_clock;
  std::uint64_t dropped = 0;
  if (!(interval >= 0 && interval < kClockJump)) {
    of_clock = DeviceFault::clock_jump;
  } else if (interval >= kDropped * kPeriod) {
    of_clock = DeviceFault::dropped_tick;
    dropped = static_cast<std::uint64_t>(std::lround(interval / kPeriod)) - 1;
  } else if (interval >= kLate * kPeriod) {
    of_clock = DeviceFault::late_tick;
  }
  const bool is_look = is_looked_for.exchange(false, std::memory_order_relaxed);
  const bool is_last = is_stopping;
  bool all_quiet = is_last;
  for (const std::unique_ptr<HdapiDevice>& device : devices) {
    HdapiDevice::Servo& servo = *device->servo_;
    servo.tick(time, of_clock, dropped, is_last);
    all_quiet = all_quiet && servo.gate.force().isZero(0);
  }
  if (is_look) {  // after all frames, as it may take long
    for (const std::unique_ptr<HdapiDevice>& device : devices) {
      if (!device->servo_->status.is_lost) {
        device->servo_->look();
      }
    }
  }
  is_quiet = all_quiet;
}

HdapiSession::HdapiSession(std::vector<HdapiDeviceOptions> devices, pbdsurg::Clock& clock)
    : ticker_(std::make_unique<Ticker>(clock)) {
  if (devices.empty()) {
    throw InvalidArgument("a haptic session has 0 devices; it needs at least one");
  }
  for (std::size_t index = 0; index < devices.size(); ++index) {
    const HdapiDeviceOptions& device = devices[index];
    for (std::size_t before = 0; before < index; ++before) {
      const HdapiDeviceOptions& other = devices[before];
      if (other.name == device.name ||
          (!device.serial_number.empty() && other.serial_number == device.serial_number)) {
        throw InvalidArgument("haptic devices '" + other.label + "' and '" + device.label +
                              "' have the name '" + device.name + "' or the serial number '" +
                              device.serial_number + "' both; they must differ");
      }
    }
  }
  ticker_->open(std::move(devices));
  ticker_->start();
}

HdapiSession::~HdapiSession() = default;

int HdapiSession::device_count() const noexcept {
  return static_cast<int>(ticker_->devices.size());
}

HdapiDevice& HdapiSession::device(int index) {
  if (index < 0 || index >= device_count()) {
    throw InvalidArgument("haptic device " + std::to_string(index) + " is not among the " +
                          std::to_string(device_count()) + " of the session");
  }
  return *ticker_->devices[static_cast<std::size_t>(index)];
}

void HdapiSession::poll() noexcept {
  ticker_->is_looked_for.store(true, std::memory_order_relaxed);
}

}  // namespace rig
