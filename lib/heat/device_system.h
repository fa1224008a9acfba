// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Local systems that a device solves.

#include <array>
#include <memory>
#include <span>
#include <utility>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

#include "lib/heat/local_system.h"
#include "lib/heat/system_rows.h"

namespace pbdsurg {

/// What changes from one solution to the next.
struct DeviceSolve {
  /// [tet_count] factors of the conductances; empty: 1
  std::span<const double> scales{};
  std::span<const double> added;  ///< [row_count] as LocalSystem::set_added()
  std::span<const double> b;      ///< [row_count] as LocalSystem::solve()
  /// Whether added and b are shares of the sum of a row's couplings.
  bool is_relative = false;
  LinearSolveOptions options{};
  /// Heat of the solution as a potential, if both are asked for. [tet_count] the sum of conductance
  /// times drop^2 over its edges
  std::span<double> tet_heat{};
  /// [row_count] a quarter of the heat of each tetrahedron, and b_i (1 - x_i)^2
  std::span<double> row_heat{};
};

/// As LocalSystem: the same system, preconditioner, tolerance and iterations, but sums in another
/// order, which is fixed, too. Couplings are summed afresh for each solution.
///
/// @throws Error  from all functions, if the device fails; then set_rows() must come before the
///                next solution
class PBDSURG_API DeviceSystem {
 public:
  virtual ~DeviceSystem() = default;

  /// @return  whether the device takes so large a system; if not, it has none
  virtual bool set_rows(const SystemRows& rows, std::span<const Tet> corners) = 0;

  /// @param conductances  [tet_count] as LocalSystem::set_couplings()
  virtual void set_conductances(std::span<const std::array<double, 6>> conductances) = 0;

  /// @param x  [row_count] where to start; the solution. Nothing is written to any output unless
  ///           all has succeeded.
  virtual LinearSolveReport solve(const DeviceSolve& input, std::span<double> x) = 0;
};

/// What heat and potential ask of a Device.
class PBDSURG_API FieldDevice {
 public:
  virtual ~FieldDevice() = default;

  /// @return  never null
  /// @throws BackendUnavailable  if the device cannot, saying why
  [[nodiscard]] virtual std::unique_ptr<DeviceSystem> make_system() = 0;
};

/// Whether a device solves, and the system on it, made once rows are worth it. A copy makes one of
/// its own.
class DeviceChoice {
 public:
  /// @param device_rows  from which the executor solves, if it is a device
  DeviceChoice(const Executor& executor, Index device_rows)
      : executor_(executor), device_rows_(device_rows) {}
  DeviceChoice(const DeviceChoice& other) noexcept
      : executor_(other.executor_), device_rows_(other.device_rows_) {}
  DeviceChoice& operator=(const DeviceChoice&) = delete;
  void swap(DeviceChoice& other) noexcept {
    std::swap(executor_, other.executor_);
    std::swap(device_rows_, other.device_rows_);
    std::swap(has_looked_, other.has_looked_);
    system_.swap(other.system_);
  }

  /// @return  the system to solve so many rows with, valid while this lives; null: on the host
  /// @throws BackendUnavailable  if the device cannot, and no other executor is to work instead
  /// @throws Error               if the device fails
  [[nodiscard]] DeviceSystem* find(Index rows);

 private:
  Executor executor_;
  Index device_rows_;
  bool has_looked_ = false;               // for a device
  std::unique_ptr<DeviceSystem> system_;  // null: none
};

}  // namespace pbdsurg
