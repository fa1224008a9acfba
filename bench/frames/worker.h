// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A thread that does one thing after another.

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace pbdsurg::bench {

class Worker {
 public:
  Worker();
  ~Worker();  ///< ends what it does first
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Waits until it is free, and lets it begin.
  void start(std::function<void()> work);
  /// Waits until it is free.
  /// @throws what its work threw
  void wait();

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable has_changed_;
  std::function<void()> work_;  // empty while it is free
  std::exception_ptr failure_;
  bool is_over_ = false;
  std::thread thread_;
};

}  // namespace pbdsurg::bench
