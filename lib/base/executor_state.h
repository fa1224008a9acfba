// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an executor is inside: a kind, a team of threads, a device.

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

class StepTeam;

/// What works for a library of devices. Each module that can use one has an interface of its own
/// for that, which a device derives from, too, and which the module asks it for.
class PBDSURG_API Device {
 public:
  virtual ~Device() = default;
  [[nodiscard]] virtual const std::string& name() const noexcept = 0;
};

class PBDSURG_API ExecutorState {
 public:
  /// @param threads  0: as many as pay
  ExecutorState(ExecutorKind kind, int threads);
  /// @param instead  who works where the device refuses to; may be nobody
  ExecutorState(std::shared_ptr<Device> device, Executor instead);
  ~ExecutorState();
  ExecutorState(const ExecutorState&) = delete;
  ExecutorState& operator=(const ExecutorState&) = delete;

  [[nodiscard]] ExecutorKind kind() const noexcept { return kind_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  [[nodiscard]] const Executor& instead() const noexcept { return instead_; }

  /// Null on a host.
  [[nodiscard]] Device* device() const noexcept { return device_.get(); }

  /// Whether how many threads work is to be found out.
  [[nodiscard]] bool is_to_choose() const noexcept { return chooses_; }
  /// The caller's included: at most so many, and of work that nobody tries out.
  [[nodiscard]] int most_threads() const noexcept { return threads_; }
  [[nodiscard]] int threads() const noexcept { return chooses_ ? 1 : threads_; }

 private:
  friend class TeamLease;

  ExecutorKind kind_;
  bool chooses_ = false;
  int threads_ = 1;
  std::string name_;
  std::shared_ptr<Device> device_;
  Executor instead_;
  std::once_flag is_team_made_;
  std::unique_ptr<StepTeam> team_;
  std::atomic_flag is_taken_;
};

/// The team of an executor, for as long as a piece of work. Who finds it taken works alone: the
/// team may be busy for another thread, or this piece may be part of another's.
class PBDSURG_API TeamLease {
 public:
  /// @param executor  may be nobody, and then there is no team
  /// @param threads   that would be of use; with one, nothing is taken
  TeamLease(ExecutorState* executor, int threads);
  ~TeamLease();
  TeamLease(const TeamLease&) = delete;
  TeamLease& operator=(const TeamLease&) = delete;

  /// Null: alone.
  [[nodiscard]] StepTeam* team() const noexcept { return team_; }

 private:
  ExecutorState* state_ = nullptr;  // from whom it is
  StepTeam* team_ = nullptr;
};

}  // namespace pbdsurg
