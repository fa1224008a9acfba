// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The operation as hands play it: step by step, without a clock or a thread.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "pbdsurg/haptics/device.h"
#include "pbdsurg/haptics/device_trace.h"

#include "apps/cholecystectomy/play/instrument_contacts.h"
#include "apps/cholecystectomy/play/scene_feed.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/smoke.h"
#include "apps/rig/age_histogram.h"

namespace cholecystectomy {

/// What hands and feet did, step by step, for a device to play again.
struct HandRecording {
  static constexpr std::size_t kMostSteps = 180000;  ///< half an hour; what follows is lost
  std::array<pbdsurg::DeviceTrace, 2> traces{};      ///< of the grasper and the hook

  /// The hook has the pedals of all. @param now  s, by the clock of the hands
  void add(std::array<pbdsurg::DeviceState, 2> states, const pbdsurg::Pedals& pedals, double now);
};

/// The devices of both hands, by what they hold, and what else has pedals.
struct Hands {
  pbdsurg::Device* grasper;
  pbdsurg::Device* hook;
  std::vector<pbdsurg::Device*> feet{};  ///< of these, pedals alone count
  HandRecording* recording = nullptr;  ///< of what hands and feet do; null where none is asked for
};

/// One play from its start on. Deterministic: the same states of hands and the same orders, step by
/// step, give the same bits.
class Session {
 public:
  static constexpr double kTimeStep = 10e-3;  ///< s; twice the script's, which leaves two cores
                                              ///< time for pictures
  static constexpr float kTopSpeed = 0.4F;    ///< m/s, of tips; hands that are faster are followed
  static constexpr float kGrip = 40;          ///< N; more slips out of the jaws
  static constexpr double kSilence = 2;       ///< s; pedals of who was not heard of since are up
  static constexpr std::size_t kMostStrokes = 8;  ///< that can be taken back

  /// @param scene, backdrop, hands  kept by reference: they must outlive the session
  /// @param generation              of its states: above zero, another one for each session
  Session(const SurgicalScene& scene, const pbdsurg::MeshData& backdrop,
          const pbdsurg::SolverOptions& options, const Hands& hands, std::uint32_t generation);

  /// One step.
  /// @param now     s, by the clock of the hands
  /// @param events  of the whole play; those of this step are added
  void step(const Orders& orders, double now, EventCounts& events);

  /// Takes back the last stroke that changed anything, between two steps: the scene is as it was
  /// before it. A stroke begins when a pedal goes down, or when jaws close on tissue and no current
  /// flows; what happens until the next begins is part of it. Hands stay where they are. Jaws hold
  /// what they held then if their hand is not open now, and within kSameHold of where it was. A
  /// pedal that is down counts once it was up.
  ///
  /// Cost: as of World's constructor of a WorldState.
  void undo(EventCounts& events);
  static constexpr float kSameHold = 10e-3F;  ///< m

  /// Whether positions are no longer finite: only a new session helps.
  [[nodiscard]] bool is_lost() const { return simulation_->totals.non_finite_vertices > 0; }

  /// What is near both instruments after a step: see InstrumentContacts::collect().
  /// @param sequence  ascending, also from session to session
  void collect(std::uint64_t sequence, double time, const ContactPatches& patches);

  /// As the last step found it. @param hand  0 the grasper's, 1 the hook's
  [[nodiscard]] const pbdsurg::DeviceState& hand(std::size_t hand) const { return states_[hand]; }
  /// Of all hands and feet, in the last step.
  [[nodiscard]] const pbdsurg::Pedals& pedals() const { return pedals_; }

  /// s, how old states of hands were when steps began; since the start.
  [[nodiscard]] const rig::AgeHistogram& hand_ages() const { return hand_ages_; }

  /// All of a state but what time and events are.
  void fill(SceneState& state, const Seen& seen);

  /// Of its last state: the next session takes a later one.
  [[nodiscard]] std::uint32_t generation() const { return feed_.generation(); }

  /// Another one after each undo().
  [[nodiscard]] const Simulation& simulation() const { return *simulation_; }

 private:
  // What there was before a stroke.
  struct Moment {
    SimulationState simulation;
    SkinRecord skin;
    double energy;  // J, that the hook had delivered
    Smoke smoke;
    bool is_closed;
  };

  void work_jaws(float jaw, EventCounts& events);
  void begin_stroke();
  void settle_strokes();
  void put_hands(const Simulation& before);

  const SurgicalScene& scene_;
  StageTimes stages_;
  std::unique_ptr<Simulation> simulation_;
  SceneFeed feed_;
  Smoke smoke_;
  Hands hands_;
  bool is_closed_ = false;
  bool has_seen_pedals_up_ = false;  // who begins with a foot down lifts it first
  pbdsurg::Activation activation_ = pbdsurg::Activation::none;
  bool is_refused_ = false;
  std::optional<InstrumentContacts> contacts_;  // of this simulation, from the first patch on
  pbdsurg::GraspState grasp_ = pbdsurg::GraspState::open;
  std::array<pbdsurg::DeviceState, 2> states_;  // of both hands, in the last step
  pbdsurg::Pedals pedals_;                      // likewise, of all
  rig::AgeHistogram hand_ages_;
  StepTimes times_;
  std::deque<Moment> strokes_;  // oldest first; the last may have changed nothing yet
};

}  // namespace cholecystectomy
