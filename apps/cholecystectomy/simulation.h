// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The scene in motion under two instruments, with what the report needs to know.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/world/world.h"

#include "apps/cholecystectomy/surgical_scene.h"

namespace cholecystectomy {

/// Milliseconds spent, by stage: the only part of the report that differs from run to run.
using StageTimes = std::map<std::string, double>;

/// Adds the time of its life to a stage.
class StageTimer {
 public:
  StageTimer(StageTimes& times, const std::string& stage);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& total_;
  std::int64_t start_;
};

/// Least, mean and largest of what was added.
struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  double sum = 0;
  std::int64_t count = 0;

  void add(double value);
};

/// Why a script cannot go on: the scene is not what it was written for.
class CannotGoOn : public pbdsurg::Error {
 public:
  using Error::Error;
};

/// Counts of a run so far.
struct Totals {
  std::int64_t steps = 0;
  std::int64_t grasper_touches = 0, hook_touches = 0;  ///< steps with a force of tissue on it
  std::int64_t tets_deleted = 0;
  std::int64_t links_cut = 0;
  float residual_max = 0;   ///< largest |C| relative to the rest value, over all steps
  float residual_last = 0;  ///< the same after the last step
  pbdsurg::Index inverted_tets_max = 0;
  pbdsurg::Index non_finite_vertices = 0;
  std::int64_t dropped_contacts = 0;
  std::int64_t refused_edits = 0;
  std::string first_refusal;
  // of the cautery; ranges over the steps in which current flowed
  std::int64_t tets_torn_by_steam = 0;
  pbdsurg::Index tets_deferred_max = 0;
  std::int64_t unconverged = 0, sparks = 0;         ///< steps
  double hottest = 0;                               ///< degrees Celsius
  Range burn_power, burn_resistance, burn_voltage;  ///< W, ohm, V
};

/// An instrument: its tip, and the port in the abdominal wall that its shaft passes through.
struct Instrument {
  pbdsurg::ToolId tool{};
  Eigen::Vector3f port;  ///< m
  Eigen::Vector3f tip;   ///< m, where it is wanted
  Eigen::Quaternionf orientation = Eigen::Quaternionf::Identity();
  bool is_aimed = true;  ///< the shaft turns to the port by itself, but while tissue is held
  std::vector<pbdsurg::Index> held{};  ///< scene vertices
  /// m, from where it is wanted: how far tissue had pushed it when it closed, while it holds that.
  Eigen::Vector3f offset{0, 0, 0};

  [[nodiscard]] pbdsurg::ToolPose pose() const;
};

/// Four sweeps of vertices a step, over-relaxed by 1.2, and a coarse correction after the first,
/// with a drag for the organs around that lets what is dragged come back in half a second; or the
/// paper's solver.
[[nodiscard]] pbdsurg::SolverOptions solver_options(const pbdsurg::Executor& executor, bool paper);

/// What the hook heats.
inline constexpr std::array<pbdsurg::BodyId, 3> kBurnable{
    body_of(Organ::gallbladder), body_of(Organ::liver), body_of(Organ::calot_fat)};

/// A simulation at a moment. Its copies share the world.
struct SimulationState {
  pbdsurg::WorldState world;
  Instrument grasper, hook;
  pbdsurg::CauteryId burner;
  pbdsurg::CauteryReport last_burn;
  Totals totals;
};

class Simulation {
 public:
  /// @param scene  kept by reference: must outlive the simulation
  /// @param seed   of the instruments' tremor, of which hands of a person need none
  Simulation(const SurgicalScene& scene, const pbdsurg::SolverOptions& options,
             std::optional<std::uint64_t> seed, StageTimes& times, double time_step = kTimeStep);
  static constexpr double kTimeStep = 5e-3;  ///< s, of the scripted operation

  /// As it was at a moment, without tremor: see World's constructor of its state.
  /// @param scene  of the simulation that was saved, kept by reference
  Simulation(const SurgicalScene& scene, const SimulationState& state, StageTimes& times,
             double time_step = kTimeStep);

  /// This moment; world.record() comes before.
  [[nodiscard]] SimulationState save() const;

  /// One step with these settings at the hook.
  void advance(const std::optional<pbdsurg::GeneratorSettings>& settings);

  /// Closes the grasper around the vertices of an organ near its tip, reaching further where the
  /// mesh is so coarse that fewer than four lie within the radius.
  /// @return  the scene vertices that it holds
  /// @throws CannotGoOn  if there are none within eight times the radius
  std::vector<pbdsurg::Index> grasp(Organ organ, float radius);
  void release();

  /// Where an instrument is, as tissue lets it.
  [[nodiscard]] pbdsurg::ToolPose pose_of(const Instrument& instrument) const;

  /// Moves a tip towards a point, at most at a speed, m/s.
  void approach(Instrument& instrument, const Eigen::Vector3f& point, float speed);

  /// Energy that the hook has delivered so far, into tissue, links and its own metal, J.
  [[nodiscard]] double energy_in() const {
    return cautery.field().ledger().in + cautery.link_energy_spent() + cautery.electrode_energy();
  }

  [[nodiscard]] double time() const noexcept {
    return time_step * static_cast<double>(totals.steps);
  }
  [[nodiscard]] const pbdsurg::Surface& surface(Organ organ) const {
    return *surfaces_[static_cast<std::size_t>(body_of(organ))];
  }

  /// Of those that have tissue left, m.
  [[nodiscard]] std::vector<Eigen::Vector3f> tissue_of(Organ organ) const;

  const SurgicalScene& scene;
  double time_step;  ///< s
  pbdsurg::World world;
  pbdsurg::Solver& solver;                       ///< of the world
  const pbdsurg::ConnectiveTissue& connections;  ///< of the world
  Instrument grasper;
  Instrument hook;
  pbdsurg::CauteryId burner;         ///< at the hook
  const pbdsurg::Cautery& cautery;   ///< that it is
  double hook_power = 0;             ///< W, as set in the last step
  pbdsurg::CauteryReport last_burn;  ///< of the last step
  Totals totals;
  StageTimes& times;

 private:
  void find_surfaces();
  void place(Instrument& instrument);
  void count(const pbdsurg::CauteryReport& report);

  std::vector<const pbdsurg::Surface*> surfaces_;  // [organ]
  std::optional<std::uint64_t> seed_;
};

}  // namespace cholecystectomy
