// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Local systems that a device solves, and where pbdsurg::cuda, if a program links it, leaves word
/// of its own. The core knows no more of it.

#include <array>
#include <memory>
#include <span>

#include "pbdsurg/core/export.h"
#include "pbdsurg/core/types.h"
#include "pbdsurg/thermal/field_backend.h"

#include "thermal/local_system.h"
#include "thermal/system_rows.h"

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

/// @return  a system on the device, never null
/// @throws BackendUnavailable  if there is none, saying why
using MakeDeviceSystem = std::unique_ptr<DeviceSystem> (*)();

/// Called before main() by the static initialiser of pbdsurg::cuda, and by tests.
/// @param make  or null
/// @return      the one before, or null
PBDSURG_API MakeDeviceSystem set_device_system_maker(MakeDeviceSystem make) noexcept;

/// Rows from which an automatic choice asks a device. Measured on an H200 beside its Xeon: a
/// potential in a ball of 1,100 vertices takes 0.16 to 0.18 ms there and 0.23 to 0.30 ms on one
/// thread, of 850 vertices 0.12 and 0.10; heat of 1,040 rows takes as long on both, of 4,046 rows
/// 0.22 and 0.38.
inline constexpr Index kPotentialRowsWorthDevice = 1000;
inline constexpr Index kHeatRowsWorthDevice = 1500;

/// Whether a device solves, and the system on it: made once rows are worth it, or at construction
/// where a device is asked for. A copy has the same wish, and makes a system of its own once it has
/// rows for it.
class DeviceChoice {
 public:
  /// @throws InvalidArgument     if the backend is none of FieldBackend
  /// @throws BackendUnavailable  if a device is asked for and there is none, saying why
  explicit DeviceChoice(FieldBackend backend);
  DeviceChoice(const DeviceChoice& other) noexcept : backend_(other.backend_) {}
  DeviceChoice& operator=(const DeviceChoice&) = delete;

  /// @param rows_worth  from which an automatic choice asks a device
  /// @return            the system to solve so many rows with, valid while this lives; null: the
  ///                    CPU is asked for, or the choice is automatic and there is no device or too
  ///                    few rows
  /// @throws Error      if a device cannot be opened, as the constructor
  [[nodiscard]] DeviceSystem* find(Index rows, Index rows_worth);

 private:
  void look();

  FieldBackend backend_;
  bool has_looked_ = false;               // for a device
  std::unique_ptr<DeviceSystem> system_;  // null: none
};

}  // namespace pbdsurg
