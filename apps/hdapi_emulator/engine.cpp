// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi_emulator/engine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "pbdsurg/base/error.h"

namespace hdapi_emulator {
namespace {

constexpr double kPeriod = 1e-3;          // s
constexpr double kLateness = 0.7;         // of a period
constexpr std::size_t kMostJobs = 32;     // that may be scheduled
constexpr std::size_t kMostErrors = 256;  // that are kept, the newest
constexpr HHD kFirstHandle = 1;

Engine* alive = nullptr;

void check(bool holds, const std::string& rule) {
  if (!holds) {
    throw pbdsurg::InvalidArgument(rule);
  }
}

void check_device(const DeviceOptions& device, int index) {
  const std::string element = "emulated device " + std::to_string(index) + ": ";
  const auto check_positive = [&](const char* name, double value) {
    check(value > 0 && std::isfinite(value),
          element + name + " is " + std::to_string(value) + "; it must be positive");
  };
  check_positive("resolution", device.resolution);
  check_positive("mass", device.mass);
  check_positive("max_force", device.max_force);
  check_positive("max_continuous_force", device.max_continuous_force);
  check(device.damping >= 0 && device.friction >= 0,
        element + "damping " + std::to_string(device.damping) + " N s/m and friction " +
            std::to_string(device.friction) + " N must not be negative");
}

}  // namespace

double Engine::JumpingClock::now() const noexcept {
  const double time = engine_.time();
  const Lock lock(engine_.mutex_);
  return time + engine_.jumps(time);
}

void Engine::JumpingClock::wait_until(double time) {
  if (!engine_.options_.has_real_time) {
    while (now() < time) {
      engine_.step(1);
    }
    return;
  }
  for (double left = time - now(); left > 0; left = time - now()) {
    engine_.real_clock_.wait_until(engine_.real_clock_.now() + left);
  }
}

Engine::Engine(const EmulatorOptions& options) : options_(options) {
  for (const DeviceOptions& device : options.devices) {
    check_device(device, static_cast<int>(devices_.size()));
    for (const EmulatedDevice& other : devices_) {
      check(other.options().name != device.name,
            "two emulated devices are called '" + device.name + "'; names must differ");
    }
    devices_.emplace_back(device);
  }
  if (!options.devices.empty()) {
    check(alive == nullptr, "an emulator lives already; a process has one HDAPI");
    alive = this;
  }
}

Engine::~Engine() {
  stop();
  if (alive == this) {
    alive = nullptr;
  }
}

Engine& Engine::current() {
  static Engine empty{EmulatorOptions{.devices = {}}};
  return alive != nullptr ? *alive : empty;
}

// --- errors and handles
// ---------------------------------------------------------------------------

void Engine::push(HDerror error, HHD handle) {
  if (errors_.size() == kMostErrors) {
    errors_.pop_front();
  }
  errors_.push_back({{error, 0, handle}, std::this_thread::get_id()});
}

void Engine::push(const Errors& errors, HHD handle) {
  for (const HDerror error : errors) {
    push(error, handle);
  }
}

HDErrorInfo Engine::take_error() {
  const Lock lock(mutex_);
  const auto is_mine = [this](const StackedError& error) {
    return options_.error_stack == ErrorStack::global || error.thread == std::this_thread::get_id();
  };
  const auto newest = std::find_if(errors_.rbegin(), errors_.rend(), is_mine);
  if (newest == errors_.rend()) {
    return {HD_SUCCESS, 0, HD_INVALID_HANDLE};
  }
  const HDErrorInfo info = newest->info;
  errors_.erase(std::next(newest).base());
  return info;
}

int Engine::index_of(const EmulatedDevice& device) const {
  return static_cast<int>(&device - devices_.data());
}

HHD Engine::handle_of(const EmulatedDevice& device) const {
  return kFirstHandle + static_cast<HHD>(index_of(device));
}

/// Null, after an error, where it is none.
EmulatedDevice* Engine::find(HHD handle) {
  const std::size_t index = static_cast<std::size_t>(handle - kFirstHandle);
  if (index < devices_.size() && devices_[index].is_open() &&
      !is_active_now(Fault::wrong_handle, static_cast<int>(index))) {
    return &devices_[index];
  }
  push(HD_BAD_HANDLE, handle);
  return nullptr;
}

EmulatedDevice* Engine::current_or_error() {
  return find(current_);
}

// --- faults
// ---------------------------------------------------------------------------------------

bool Engine::is_active_now(Fault fault, int device) const {
  const double now = time();
  return std::any_of(plans_.begin(), plans_.end(), [&](const FaultPlan& plan) {
    return plan.fault == fault && plan.device == device && now >= plan.begin &&
           now < plan.begin + plan.duration;
  });
}

ActiveFaults Engine::faults_of(const EmulatedDevice& device) const {
  if (plans_.empty()) {
    return {};
  }
  const int index = index_of(device);
  return {.has_lost_communication = is_active_now(Fault::lost_communication, index),
          .has_warm_motors = is_active_now(Fault::warm_motors, index),
          .has_stuck_calibration = is_active_now(Fault::stuck_calibration, index),
          .has_force_error = is_active_now(Fault::force_error, index),
          .is_unplugged = is_active_now(Fault::unplugged, index)};
}

/// s, by which the program's clock is ahead.
double Engine::jumps(double time) const {
  return kClockJump * static_cast<double>(
                          std::count_if(plans_.begin(), plans_.end(), [&](const FaultPlan& plan) {
                            return plan.fault == Fault::clock_jump && time >= plan.begin;
                          }));
}

void Engine::inject(const FaultPlan& plan) {
  check(plan.device >= 0 && static_cast<std::size_t>(plan.device) < devices_.size(),
        std::string(name_of(plan.fault)) + ": device " + std::to_string(plan.device) +
            " is not among the " + std::to_string(devices_.size()) + " emulated ones");
  check(plan.begin >= 0 && plan.duration >= 0,
        std::string(name_of(plan.fault)) + ": begins at " + std::to_string(plan.begin) + " s for " +
            std::to_string(plan.duration) + " s; neither may be negative");
  check(plan.fault != Fault::swapped_devices || devices_.size() >= 2,
        "one device cannot be swapped: the emulator needs two");
  const Lock lock(mutex_);
  plans_.push_back(plan);
}

bool Engine::is_active(Fault fault, int device) const {
  const Lock lock(mutex_);
  return is_active_now(fault, device);
}

// --- devices
// --------------------------------------------------------------------------------------

HHD Engine::init_device(HDstring name) {
  const Lock lock(mutex_);
  calls_.emplace_back("hdInitDevice");
  const auto found = name == HD_DEFAULT_DEVICE
                         ? devices_.begin()
                         : std::find_if(devices_.begin(), devices_.end(), [&](const auto& device) {
                             return device.options().name == name;
                           });
  if (found == devices_.end() || faults_of(*found).is_unplugged) {
    push(HD_DEVICE_FAULT, HD_INVALID_HANDLE);
    return HD_INVALID_HANDLE;
  }
  if (found->is_open()) {
    push(HD_DEVICE_ALREADY_INITIATED, handle_of(*found));
    return HD_INVALID_HANDLE;
  }
  found->open();
  current_ = handle_of(*found);
  return current_;
}

void Engine::disable_device(HHD handle) {
  const Lock lock(mutex_);
  calls_.emplace_back("hdDisableDevice");
  if (EmulatedDevice* const device = find(handle)) {
    if (is_running_ && !jobs_.empty()) {
      push(HD_INVALID_OPERATION, handle);  // callbacks would meet a device that is gone
    }
    device->close();
    if (current_ == handle) {
      current_ = HD_INVALID_HANDLE;
    }
  }
}

void Engine::make_current(HHD handle) {
  const Lock lock(mutex_);
  if (find(handle) != nullptr) {
    current_ = handle;
  }
}

HHD Engine::current_device() {
  const Lock lock(mutex_);
  return current_;
}

void Engine::begin_frame(HHD handle) {
  const Lock lock(mutex_);
  if (EmulatedDevice* const device = find(handle)) {
    current_ = handle;
    Errors errors;
    device->begin_frame(faults_of(*device), errors);
    push(errors, handle);
  }
}

void Engine::end_frame(HHD handle) {
  const Lock lock(mutex_);
  if (EmulatedDevice* const device = find(handle)) {
    Errors errors;
    device->end_frame(time(), faults_of(*device), errors);
    push(errors, handle);
  }
}

void Engine::enable(HDenum capability, bool is_enabled) {
  const Lock lock(mutex_);
  if (EmulatedDevice* const device = current_or_error()) {
    if (device->is_capability(capability)) {
      device->enable(capability, is_enabled);
    } else {
      push(HD_INVALID_ENUM, current_);
    }
  }
}

bool Engine::is_enabled(HDenum capability) {
  const Lock lock(mutex_);
  const EmulatedDevice* const device = current_or_error();
  if (device != nullptr && !device->is_capability(capability)) {
    push(HD_INVALID_ENUM, current_);
  }
  return device != nullptr && device->is_enabled(capability);
}

template <class Value>
void Engine::get(HDenum parameter, Value* values) {
  const Lock lock(mutex_);
  const EmulatedDevice* const device = current_or_error();
  if (device == nullptr || device->get(parameter, values) > 0) {
    return;
  }
  std::array<HDdouble, kMostValues> doubles;
  std::array<HDint, kMostValues> integers;
  std::array<HDboolean, kMostValues> booleans;
  const bool has_other_type = device->get(parameter, doubles.data()) > 0 ||
                              device->get(parameter, integers.data()) > 0 ||
                              device->get(parameter, booleans.data()) > 0;
  push(has_other_type ? HD_INVALID_INPUT_TYPE : HD_INVALID_ENUM, current_);
}

template void Engine::get(HDenum parameter, HDdouble* values);
template void Engine::get(HDenum parameter, HDint* values);
template void Engine::get(HDenum parameter, HDboolean* values);

HDstring Engine::get_string(HDenum parameter) {
  const Lock lock(mutex_);
  const EmulatedDevice* const device = current_or_error();
  if (device == nullptr) {
    return "";
  }
  switch (parameter) {
    case HD_DEVICE_MODEL_TYPE:
      return device->options().model.c_str();
    case HD_DEVICE_SERIAL_NUMBER: {
      const int index = index_of(*device);
      const bool is_swapped = index < 2 && is_active_now(Fault::swapped_devices, 0);
      return (is_swapped ? devices_[1 - index] : *device).options().serial_number.c_str();
    }
    case HD_DEVICE_DRIVER_VERSION:
    case HD_VERSION:
      return "emulator";
    default:
      push(HD_INVALID_ENUM, current_);
      return "";
  }
}

void Engine::set_doubles(HDenum parameter, const HDdouble* values) {
  const Lock lock(mutex_);
  EmulatedDevice* const device = current_or_error();
  if (device != nullptr && !device->set_doubles(parameter, values)) {
    push(HD_INVALID_ENUM, current_);
  }
}

HDenum Engine::check_calibration() {
  const Lock lock(mutex_);
  const EmulatedDevice* const device = current_or_error();
  return device != nullptr ? device->check_calibration(faults_of(*device))
                           : HDenum{HD_CALIBRATION_NEEDS_MANUAL_INPUT};
}

void Engine::update_calibration(HDenum style) {
  const Lock lock(mutex_);
  if (EmulatedDevice* const device = current_or_error()) {
    Errors errors;
    device->update_calibration(style, faults_of(*device), errors);
    push(errors, current_);
  }
}

// --- the scheduler
// --------------------------------------------------------------------------------

/// Null, after an error, where it cannot be.
Engine::Job* Engine::add(HDSchedulerCallback callback, void* data, int priority,
                         bool is_synchronous, Lock& lock) {
  static_cast<void>(lock);
  if (priority < HD_MIN_SCHEDULER_PRIORITY || priority > HD_MAX_SCHEDULER_PRIORITY) {
    push(HD_INVALID_PRIORITY, HD_INVALID_HANDLE);
    return nullptr;
  }
  if (jobs_.size() == kMostJobs) {
    push(HD_SCHEDULER_FULL, HD_INVALID_HANDLE);
    return nullptr;
  }
  const auto before = std::find_if(jobs_.begin(), jobs_.end(),
                                   [&](const Job& job) { return job.priority < priority; });
  return &*jobs_.insert(before, {++last_handle_, callback, data, priority, is_synchronous});
}

HDSchedulerHandle Engine::schedule(HDSchedulerCallback callback, void* data, int priority) {
  Lock lock(mutex_);
  calls_.emplace_back("hdScheduleAsynchronous");
  const Job* const job = add(callback, data, priority, false, lock);
  return job != nullptr ? job->handle : 0;
}

void Engine::run_in_tick(HDSchedulerCallback callback, void* data, int priority) {
  Lock lock(mutex_);
  if (is_in_tick()) {
    lock.unlock();
    callback(data);
    return;
  }
  calls_.emplace_back("hdScheduleSynchronous");
  if (!is_running_) {
    push(HD_INVALID_OPERATION, HD_INVALID_HANDLE);
    return;
  }
  const Job* const job = add(callback, data, priority, true, lock);
  if (job == nullptr) {
    return;
  }
  const HDSchedulerHandle handle = job->handle;
  const auto is_gone = [&] {
    return std::none_of(jobs_.begin(), jobs_.end(),
                        [&](const Job& other) { return other.handle == handle; });
  };
  if (options_.has_real_time) {
    has_finished_.wait(lock, is_gone);
  } else {
    while (!is_gone()) {
      tick(lock);
    }
  }
}

void Engine::unschedule(HDSchedulerHandle handle) {
  const Lock lock(mutex_);
  calls_.emplace_back("hdUnschedule");
  const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const Job& job) {
    return job.handle == handle && !job.is_done;
  });
  if (found == jobs_.end()) {
    push(HD_INVALID_OPERATION, HD_INVALID_HANDLE);
  } else {
    found->is_done = true;  // a tick that is under way may be looking at it
    if (ticking_thread_ == std::thread::id{}) {
      jobs_.erase(found);
    }
    has_finished_.notify_all();
  }
}

/// @return  whether it is still scheduled
bool Engine::wait_for(HDSchedulerHandle handle, HDenum wait) {
  Lock lock(mutex_);
  const auto is_scheduled = [&] {
    return std::any_of(jobs_.begin(), jobs_.end(),
                       [&](const Job& job) { return job.handle == handle && !job.is_done; });
  };
  if (wait == HD_WAIT_CHECK_STATUS) {
    return is_scheduled();
  }
  if (wait != HD_WAIT_INFINITE || !is_running_ || is_in_tick()) {
    push(wait != HD_WAIT_INFINITE ? HD_INVALID_ENUM : HD_INVALID_OPERATION, HD_INVALID_HANDLE);
    return is_scheduled();
  }
  if (options_.has_real_time) {
    has_finished_.wait(lock, [&] { return !is_scheduled(); });
  } else {
    while (is_scheduled()) {
      tick(lock);
    }
  }
  return false;
}

void Engine::start() {
  const Lock lock(mutex_);
  calls_.emplace_back("hdStartScheduler");
  if (is_running_ || std::none_of(devices_.begin(), devices_.end(),
                                  [](const auto& device) { return device.is_open(); })) {
    push(HD_TIMER_ERROR, HD_INVALID_HANDLE);
    return;
  }
  for (EmulatedDevice& device : devices_) {
    if (device.is_open()) {
      device.enable(HD_FORCE_OUTPUT, true);
      device.start_force(time());
    }
  }
  is_running_ = true;
  if (options_.has_real_time) {
    thread_ = std::thread([this] { run(); });
  }
}

void Engine::stop() {
  std::thread ending;
  {
    const Lock lock(mutex_);
    if (!is_running_) {
      return;
    }
    calls_.emplace_back("hdStopScheduler");
    if (is_in_tick()) {
      push(HD_INVALID_OPERATION, HD_INVALID_HANDLE);
      return;
    }
    is_running_ = false;
    ending = std::move(thread_);
  }
  if (ending.joinable()) {
    ending.join();
  }
  const Lock lock(mutex_);
  for (EmulatedDevice& device : devices_) {
    device.stop_force();
  }
  jobs_.remove_if([](const Job& job) { return job.is_synchronous; });
  has_finished_.notify_all();
}

void Engine::set_rate(HDulong rate) {
  const Lock lock(mutex_);
  if (rate != 1000) {
    push(HD_INVALID_VALUE, HD_INVALID_HANDLE);  // USB devices have this one
  }
}

double Engine::time_in_tick() {
  return options_.has_real_time ? real_clock_.now() - tick_time_ : 0;
}

/// s. In virtual time that of the tick, in real time by the clock.
double Engine::time() const {
  return options_.has_real_time ? real_clock_.now() : tick_time_.load();
}

void Engine::step(int ticks) {
  if (options_.has_real_time) {
    throw pbdsurg::InvalidArgument("real time cannot be stepped; it passes by itself");
  }
  if (ticks < 0) {
    throw pbdsurg::InvalidArgument("cannot step by " + std::to_string(ticks) +
                                   " ticks; time never goes back");
  }
  Lock lock(mutex_);
  for (int tick_index = 0; tick_index < ticks; ++tick_index) {
    tick(lock);
  }
}

/// A period passes, at whose end callbacks run.
void Engine::tick(Lock& lock) {
  ++ticks_;
  if (!options_.has_real_time) {
    // faults are those of the tick's own time, however late it comes
    const double due = static_cast<double>(ticks_) * kPeriod;
    tick_time_ = due;
    if (is_active_now(Fault::late_tick, 0)) {
      tick_time_ = due + kLateness * kPeriod;
    }
  }
  for (EmulatedDevice& device : devices_) {
    device.advance(time(), kPeriod, faults_of(device));
  }
  if (is_running_ && !is_active_now(Fault::dropped_tick, 0)) {
    run_jobs(lock);
  }
}

void Engine::run_jobs(Lock& lock) {
  ticking_thread_ = std::this_thread::get_id();
  for (EmulatedDevice& device : devices_) {
    device.begin_tick();
  }
  for (Job& job : jobs_) {  // a list: callbacks may add others
    if (job.is_done) {
      continue;
    }
    lock.unlock();
    const HDCallbackCode code = job.run(job.data);
    lock.lock();
    job.is_done = job.is_done || code == HD_CALLBACK_DONE || job.is_synchronous;
  }
  for (EmulatedDevice& device : devices_) {
    Errors errors;
    device.end_tick(errors);
    push(errors, handle_of(device));
  }
  ticking_thread_ = {};
  jobs_.remove_if([](const Job& job) { return job.is_done; });
  has_finished_.notify_all();
}

void Engine::run() {
  double due = real_clock_.now();
  while (is_running_) {
    due += kPeriod;
    {
      const Lock lock(mutex_);
      if (is_active_now(Fault::late_tick, 0)) {
        due += kLateness * kPeriod;
      }
    }
    real_clock_.wait_until(due);
    const double now = real_clock_.now();
    tick_time_ = now;
    if (now - due > 5 * kPeriod) {
      due = now;  // ticks that were missed are not made up for
    }
    Lock lock(mutex_);
    tick(lock);
  }
}

// --- the rear side
// --------------------------------------------------------------------------------

std::vector<ForceRecord> Engine::forces(int device) const {
  const Lock lock(mutex_);
  return devices_.at(static_cast<std::size_t>(device)).forces();
}

Eigen::Vector3d Engine::position(int device) const {
  const Lock lock(mutex_);
  return devices_.at(static_cast<std::size_t>(device)).position();
}

int Engine::open_device_count() const {
  const Lock lock(mutex_);
  return static_cast<int>(std::count_if(devices_.begin(), devices_.end(),
                                        [](const auto& device) { return device.is_open(); }));
}

int Engine::callback_count() const {
  const Lock lock(mutex_);
  return static_cast<int>(jobs_.size());
}

int Engine::error_count() const {
  const Lock lock(mutex_);
  return static_cast<int>(errors_.size());
}

std::vector<std::string> Engine::calls() const {
  const Lock lock(mutex_);
  return calls_;
}

}  // namespace hdapi_emulator
