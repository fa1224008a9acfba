// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The machine behind the emulated HDAPI: devices, scheduler, errors, faults. hd.cpp gives it
/// HDAPI's names, emulator.cpp the ones of tests.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <list>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <HD/hd.h>

#include "pbdsurg/base/clock.h"

#include "apps/hdapi_emulator/emulated_device.h"
#include "apps/hdapi_emulator/emulator.h"

namespace hdapi_emulator {

/// Any thread may call its functions.
class Engine {
 public:
  explicit Engine(const EmulatorOptions& options);
  ~Engine();

  /// That of the emulator which lives; else one without devices.
  [[nodiscard]] static Engine& current();

  /// @name HDAPI
  /// @{
  HHD init_device(HDstring name);
  void disable_device(HHD handle);
  void make_current(HHD handle);
  [[nodiscard]] HHD current_device();
  void begin_frame(HHD handle);
  void end_frame(HHD handle);
  void enable(HDenum capability, bool is_enabled);
  [[nodiscard]] bool is_enabled(HDenum capability);
  template <class Value>
  void get(HDenum parameter, Value* values);
  [[nodiscard]] HDstring get_string(HDenum parameter);
  void set_doubles(HDenum parameter, const HDdouble* values);
  [[nodiscard]] HDenum check_calibration();
  void update_calibration(HDenum style);
  [[nodiscard]] HDErrorInfo take_error();
  HDSchedulerHandle schedule(HDSchedulerCallback callback, void* data, int priority);
  void run_in_tick(HDSchedulerCallback callback, void* data, int priority);
  void unschedule(HDSchedulerHandle handle);
  [[nodiscard]] bool wait_for(HDSchedulerHandle handle, HDenum wait);
  void start();
  void stop();
  void set_rate(HDulong rate);
  [[nodiscard]] double time_in_tick();
  /// @}

  /// @name The rear side
  /// @{
  [[nodiscard]] pbdsurg::Clock& clock() { return clock_; }
  [[nodiscard]] double time() const;
  void step(int ticks);
  void inject(const FaultPlan& plan);
  [[nodiscard]] bool is_active(Fault fault, int device) const;
  [[nodiscard]] std::vector<ForceRecord> forces(int device) const;
  [[nodiscard]] Eigen::Vector3d position(int device) const;
  [[nodiscard]] int open_device_count() const;
  [[nodiscard]] int callback_count() const;
  [[nodiscard]] int error_count() const;
  [[nodiscard]] bool is_running() const { return is_running_; }
  [[nodiscard]] std::vector<std::string> calls() const;
  /// @}

 private:
  using Lock = std::unique_lock<std::mutex>;

  /// Scheduler time and the jumps of the program's clock.
  class JumpingClock final : public pbdsurg::Clock {
   public:
    explicit JumpingClock(Engine& engine) : engine_(engine) {}
    [[nodiscard]] double now() const noexcept override;
    void wait_until(double time) override;

   private:
    Engine& engine_;
  };

  struct Job {
    HDSchedulerHandle handle;
    HDSchedulerCallback run;
    void* data;
    int priority;
    bool is_synchronous;
    bool is_done = false;
  };

  struct StackedError {
    HDErrorInfo info;
    std::thread::id thread;
  };

  // All of the following are called with the mutex held.
  void push(HDerror error, HHD handle);
  void push(const Errors& errors, HHD handle);
  [[nodiscard]] EmulatedDevice* find(HHD handle);
  [[nodiscard]] EmulatedDevice* current_or_error();
  [[nodiscard]] bool is_active_now(Fault fault, int device) const;
  [[nodiscard]] ActiveFaults faults_of(const EmulatedDevice& device) const;
  [[nodiscard]] int index_of(const EmulatedDevice& device) const;
  [[nodiscard]] HHD handle_of(const EmulatedDevice& device) const;
  [[nodiscard]] double jumps(double time) const;
  Job* add(HDSchedulerCallback callback, void* data, int priority, bool is_synchronous, Lock& lock);
  void tick(Lock& lock);
  void pass_time();
  void run_jobs(Lock& lock);
  [[nodiscard]] bool is_in_tick() const { return ticking_thread_ == std::this_thread::get_id(); }

  void run();  // of the thread, in real time

  const EmulatorOptions options_;
  JumpingClock clock_{*this};
  pbdsurg::RealClock real_clock_;

  mutable std::mutex mutex_;  // of what follows; never held while a callback runs
  std::vector<EmulatedDevice> devices_;
  std::deque<StackedError> errors_;  // the newest last
  HHD current_ = HD_INVALID_HANDLE;
  std::vector<FaultPlan> plans_;
  std::vector<std::string> calls_;

  std::list<Job> jobs_;  // by descending priority
  HDSchedulerHandle last_handle_ = 0;
  std::condition_variable has_finished_;  // a job
  std::thread::id ticking_thread_{};
  std::uint64_t ticks_ = 0;
  std::atomic<double> tick_time_ = 0;  // s
  std::atomic<bool> is_running_ = false;
  std::thread thread_;
};

}  // namespace hdapi_emulator
