// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the simulation's thread and the window's tell each other, through mailboxes.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/haptics/device.h"

#include "apps/rig/age_histogram.h"
#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

inline constexpr std::size_t kOrganCount = pbdsurg::kOrgans.size();

/// What the trainee asks for beside what hands do. Values that are lost between two steps lose
/// nothing: what happens once is counted.
struct Orders {
  double speed = 1;  ///< of time, above 0
  bool is_paused = false;
  std::uint32_t single_steps = 0;  ///< so far, while paused
  std::uint32_t undos = 0;         ///< so far
  std::uint32_t restarts = 0;      ///< so far
  std::uint32_t let_gos = 0;       ///< so far: pedals are up until pressed anew
  double cut_power = 30;           ///< W
  double coagulation_power = 30;   ///< W
};

struct InstrumentState {
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  bool is_closed = false;
  bool is_holding = false;                          ///< tissue
  Eigen::Vector3f force = Eigen::Vector3f::Zero();  ///< N, of the tissue on it
  float distance = 0;                               ///< m, from the tip to the nearest organ
};

/// What a generator shows.
struct GeneratorState {
  pbdsurg::Activation activation = pbdsurg::Activation::none;
  bool is_refused = false;  ///< both pedals are down
  bool is_touching = false;
  bool is_arcing = false;
  double power = 0;       ///< W, delivered
  double voltage = 0;     ///< V
  double resistance = 0;  ///< ohm; infinite where the circuit is open
  double hottest = 0;     ///< degrees Celsius
  double energy = 0;      ///< J so far
};

/// What is worth a word, and how often it has happened.
enum class Event : std::uint8_t {
  grasped,
  missed,   ///< jaws closed on nothing
  slipped,  ///< more force than jaws hold
  undone,   ///< a stroke was taken back
  no_undo,  ///< there was none
  restarted,
  lost,  ///< the state was no longer finite, and the scene began anew
  tissue_removed,
  strand_parted,
};
inline constexpr std::size_t kEventCount = 9;
using EventCounts = std::array<std::uint32_t, kEventCount>;

enum class Phase : std::uint8_t { loading, playing, failed };

/// ms of the processor's clock in the last step.
struct StepTimes {
  double heat = 0, edit = 0, solve = 0, readback = 0;
  double publish = 0;  ///< what pictures cost the simulation
};

/// A moment for the window.
struct SceneState {
  Phase phase = Phase::loading;
  std::string message;  ///< why it failed

  std::uint32_t generation = 0;  ///< grows when all surfaces are new: then they are in `whole`
  std::vector<Surface> whole;    ///< [organs and backdrop], empty but in the first of a generation
  std::array<SurfaceChange, kOrganCount> changes;  ///< since what the window has seen
  std::array<std::uint64_t, kOrganCount> triangle_versions{}, burn_versions{};
  std::array<std::size_t, kOrganCount> vertex_counts{};

  std::vector<Surface> sheets;
  std::vector<SmokePuff> smoke;
  float haze = 0;
  InstrumentState grasper, hook;
  GeneratorState generator;
  EventCounts events{};

  double time = 0;  ///< s, simulated
  std::int64_t step = 0;
  std::int64_t all_steps = 0;   ///< those before the scene began anew or went back, too
  double factor = 1;            ///< simulated time over the time asked for
  double owed = 0;              ///< s by which steps are late
  double made = 0;              ///< s of the clock, when this was filled
  rig::AgeHistogram hand_ages;  ///< s, of hands at the beginning of steps, of this session
  StepTimes times;
  std::int64_t removed_tets = 0, parted_strands = 0;
};

/// What of the states the window has taken over.
struct Seen {
  std::uint64_t sequence = 0;  ///< of the mailbox
  std::uint32_t generation = 0;
  std::array<std::uint64_t, kOrganCount> triangle_versions{}, burn_versions{};
  std::array<std::size_t, kOrganCount> vertex_counts{};
};

}  // namespace cholecystectomy
