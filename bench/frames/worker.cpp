// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/worker.h"

#include <utility>

namespace pbdsurg::bench {

Worker::Worker() : thread_([this] { run(); }) {}

Worker::~Worker() {
  {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
  }
  has_changed_.notify_all();
  thread_.join();
}

void Worker::start(std::function<void()> work) {
  {
    std::unique_lock lock(mutex_);
    has_changed_.wait(lock, [&] { return !work_; });
    work_ = std::move(work);
  }
  has_changed_.notify_all();
}

void Worker::wait() {
  std::unique_lock lock(mutex_);
  has_changed_.wait(lock, [&] { return !work_; });
  if (failure_ != nullptr) {
    std::rethrow_exception(std::exchange(failure_, nullptr));
  }
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    has_changed_.wait(lock, [&] { return work_ || is_over_; });
    if (!work_) {
      return;
    }
    lock.unlock();
    std::exception_ptr failure;
    try {
      work_();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure != nullptr) {
      failure_ = failure;
    }
    work_ = nullptr;
    has_changed_.notify_all();
  }
}

}  // namespace pbdsurg::bench
