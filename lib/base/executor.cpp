// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/executor.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/base/executor_state.h"
#include "lib/base/processors.h"
#include "lib/base/step_team.h"

namespace pbdsurg {
namespace {

// No use for many more, and a slip of the finger should not start a million.
constexpr int kMostThreadsOfAProcessor = 8;

int resolve(int threads) {
  const int processors = processor_count();
  return threads == 0 ? processors : std::min(threads, kMostThreadsOfAProcessor * processors);
}

std::string name_of(ExecutorKind kind, bool chooses, int threads) {
  if (kind == ExecutorKind::serial) {
    return "serial";
  }
  return (chooses && threads > 1 ? "up to " : "") + std::to_string(threads) +
         (threads == 1 ? " thread" : " threads");
}

const ExecutorState& checked(const Executor& executor) {
  if (!executor) {
    throw InvalidArgument("an executor that is nobody has no kind and no name");
  }
  return *executor.state();
}

}  // namespace

Executor::Executor() noexcept = default;
Executor::Executor(std::shared_ptr<ExecutorState> state) noexcept : state_(std::move(state)) {}
Executor::~Executor() = default;
Executor::Executor(const Executor&) noexcept = default;
Executor::Executor(Executor&&) noexcept = default;
Executor& Executor::operator=(const Executor&) noexcept = default;
Executor& Executor::operator=(Executor&&) noexcept = default;

ExecutorKind Executor::kind() const {
  return checked(*this).kind();
}
const std::string& Executor::name() const {
  return checked(*this).name();
}

Executor executor::serial() {
  return Executor(std::make_shared<ExecutorState>(ExecutorKind::serial, 1));
}

Executor executor::threads(int count) {
  if (count < 0) {
    throw InvalidArgument("threads is " + std::to_string(count) +
                          "; it must be >= 1, or 0 for as many as pay");
  }
  return Executor(std::make_shared<ExecutorState>(ExecutorKind::threads, count));
}

ExecutorState::ExecutorState(ExecutorKind kind, int threads)
    : kind_(kind),
      chooses_(threads == 0),
      threads_(resolve(threads)),
      name_(name_of(kind, chooses_, threads_)) {}

ExecutorState::ExecutorState(std::shared_ptr<Device> device, Executor instead)
    : kind_(ExecutorKind::device),
      name_(device->name()),
      device_(std::move(device)),
      instead_(std::move(instead)) {}

ExecutorState::~ExecutorState() = default;

TeamLease::TeamLease(ExecutorState* executor, int threads) {
  if (executor == nullptr || threads == 1 || executor->most_threads() == 1 ||
      executor->is_taken_.test_and_set(std::memory_order_acquire)) {
    return;
  }
  try {
    std::call_once(executor->is_team_made_, [executor] {
      executor->team_ = std::make_unique<StepTeam>(executor->most_threads());
    });
  } catch (...) {  // no memory for it: alone, until there is
    executor->is_taken_.clear(std::memory_order_release);
    return;
  }
  state_ = executor;
  team_ = executor->team_.get();
}

TeamLease::~TeamLease() {
  if (state_ != nullptr) {
    state_->is_taken_.clear(std::memory_order_release);
  }
}

}  // namespace pbdsurg
