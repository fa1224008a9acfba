// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A backend that keeps the state to itself, as one on a device does, and hears of changes from the
/// log alone. It steps with the serial backend, so its bits are those if the log tells all.
///
/// State lies as on a device, in arrays of all copies with room for more vertices; what nobody
/// wrote there is not a number.

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "lib/solver/host/host_backends.h"
#include "lib/solver/program/backend.h"
#include "tests/support/device_memory.h"

namespace pbdsurg::testing {

class FakeDevice final : public Backend {
 public:
  static constexpr std::size_t kMemory = 12'345'678;  // bytes

  FakeDevice(const SolverData& data, int device);

  [[nodiscard]] const char* name() const noexcept override { return "fake device"; }
  [[nodiscard]] bool keeps_state() const noexcept override { return true; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept override { return kMemory; }
  [[nodiscard]] Maker maker() const override;

  void follow_edit(SolverData& data) noexcept override;
  void start_step(SolverData& data) override;
  StepReport finish_step(SolverState& data) override;
  void fetch_state(SolverState& data, Index index) override;
  void read_positions(const SolverState& data, Index copy, std::span<const Index> places,
                      std::span<Eigen::Vector3f> out) override;
  void ask_for_motion(std::span<const Index> places) override;
  void collect_motion(Index copy, std::span<VertexMotion> out) override;

  [[nodiscard]] bool is_running() const noexcept { return is_running_; }

  const int number;
  int fetch_count = 0;
  int remade_count = 0;         ///< how often vertices outgrew their room
  std::size_t asked_count = 0;  ///< vertices that it was asked about, in all

 private:
  [[nodiscard]] VertexMotion motion_of(Index copy, Index place) const;
  void answer();
  void take_all(const SolverData& data);
  template <class Constraint>
  void refresh(DeviceRecords<Constraint>& records, const SolverData& data);
  void take_over(const SolverData& data);
  void take_over_state(const SolverData& data);
  void take_over_forces(const SolverData& data, Index copy);
  void take_over_blocks(const VertexBlocks& blocks, const Changes& changes);
  void check_blocks(const VertexBlocks& blocks, const Changes& changes) const;

  // Constraints and tetrahedra in the log, when this was told of the last edit.
  std::pair<std::size_t, std::size_t> followed_;
  SolverData own_;
  DeviceState state_;
  std::size_t vertex_count_ = 0;  // in the last step
  DeviceRecords<DistanceConstraint> distances_;
  DeviceRecords<VolumeConstraint> volumes_;
  DeviceRecords<NeoHookeanConstraint> neo_hookeans_;
  DeviceRecords<FibreConstraint> fibres_;
  DeviceRecords<MembraneConstraint> membranes_;
  DeviceRecords<StrainLimitConstraint> strain_limits_;
  DeviceRecords<BendingConstraint> bendings_;
  DeviceRecords<StiffLinkConstraint> stiff_links_;
  VertexBlocks blocks_;  // as taken over: a step changes those in own_
  std::vector<Index> watched_;
  std::unique_ptr<Backend> serial_ = make_serial_backend();
  bool is_running_ = false;
  std::vector<Index> asked_;                       // while a step runs
  std::vector<std::vector<VertexMotion>> motion_;  // [copy][asked]
};

/// Makes a backend of a solver's data, or throws what a device would.
using MakeBackend = std::function<std::unique_ptr<Backend>(const SolverData& data)>;

/// @param instead  who works where the device refuses to
[[nodiscard]] Executor device_of_test(MakeBackend make, Executor instead = {});

[[nodiscard]] Executor fake_device(int number = 0);

/// @param solver  on a fake device
[[nodiscard]] FakeDevice& fake_device_of(Solver& solver);

}  // namespace pbdsurg::testing
