// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/interruption.h"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <initializer_list>
#include <string_view>

#include <unistd.h>

namespace cholecystectomy {
namespace {

// A key that bounces, or a wrapper that sends on what its group got, is no second wish.
constexpr std::int64_t kOneWish = 1'000'000'000;  // ns

std::atomic<std::int64_t> noted_at = 0;  // ns; 0: no signal yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "signal handlers use it");

// What follows calls nothing but async-signal-safe functions.

std::int64_t now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

[[noreturn]] void end_with(std::string_view message) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, message.data(), message.size());
  _exit(kInterruptedStatus);
}

extern "C" void end_program(int) {
  end_with("interrupted before the operation; nothing was written\n");
}

extern "C" void note_signal(int) {
  std::int64_t first = 0;
  const std::int64_t time = now();
  if (!noted_at.compare_exchange_strong(first, time) && time - first >= kOneWish) {
    end_with("\ninterrupted again: ended at once, without a report\n");
  }
}

void handle(void (*handler)(int)) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(signal, handler) == SIG_IGN) {
      std::signal(signal, SIG_IGN);
    }
  }
}

}  // namespace

void end_on_interrupt() {
  handle(end_program);
}

void note_interrupt() {
  handle(note_signal);
}

bool is_interrupted() noexcept {
  return noted_at != 0;
}

}  // namespace cholecystectomy
