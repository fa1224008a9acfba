// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who does the work: the caller's thread, a team of threads, or a device.

#include <cstdint>
#include <memory>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

class ExecutorState;

/// What an executor works with.
enum class ExecutorKind : std::uint8_t {
  serial,   ///< one thread, operation by operation: the definition of correct
  threads,  ///< threads and vector registers
  device,   ///< of a library beside this one, as pbdsurg::cuda
};

/// Who does the work of solvers, heat and colourings. A handle: its copies mean the same threads,
/// or the same device, and keep them as long as there is one.
///
/// Threads are started at the first work that takes them, and sleep between works. Objects that
/// share them may be used by several threads of a program: while one has the team, others work
/// alone, with the same bits.
///
/// On devices some work stays with the caller's thread: edits, and what is too small to travel.
class PBDSURG_API Executor {
 public:
  /// Nobody by name: an object asks its owner's, and without an owner takes executor::threads().
  Executor() noexcept;
  /// Internal: those of namespace executor, and cuda::device(), make executors.
  explicit Executor(std::shared_ptr<ExecutorState> state) noexcept;
  ~Executor();
  Executor(const Executor&) noexcept;             ///< the same threads, or the same device
  Executor(Executor&&) noexcept;                  ///< leaves nobody in the other
  Executor& operator=(const Executor&) noexcept;  ///< likewise
  Executor& operator=(Executor&&) noexcept;       ///< likewise

  /// Whether there is one by name.
  [[nodiscard]] explicit operator bool() const noexcept { return state_ != nullptr; }

  /// What it works with.
  /// @throws InvalidArgument  if there is none
  [[nodiscard]] ExecutorKind kind() const;
  /// "serial", "up to 16 threads", "2 threads", or the device's.
  /// @throws InvalidArgument  if there is none
  [[nodiscard]] const std::string& name() const;

  /// This one, or another where this is nobody.
  [[nodiscard]] const Executor& or_else(const Executor& other) const noexcept {
    return state_ != nullptr ? *this : other;
  }

  [[nodiscard]] ExecutorState* state() const noexcept { return state_.get(); }  ///< internal

  /// Whether one is a copy of the other.
  friend bool operator==(const Executor&, const Executor&) noexcept = default;

 private:
  std::shared_ptr<ExecutorState> state_;
};

/// The executors of a host. That of a device comes from its library: cuda::device(), and
/// cuda::best(), which takes one where there is one.
namespace executor {

/// The caller's thread alone.
[[nodiscard]] PBDSURG_API Executor serial();

/// The caller's thread and others.
/// @param count  >= 1, at most eight a processor; 0: a solver takes as many as its steps are seen
///               to be faster with, up to one a processor, and fewer while other programs are busy;
///               heat and colourings take the caller's alone. The bits are the same.
/// @throws InvalidArgument  if it is negative
[[nodiscard]] PBDSURG_API Executor threads(int count = 0);

}  // namespace executor
}  // namespace pbdsurg
