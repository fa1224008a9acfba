// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Loads the scene and plays it against a clock, in a thread of its own.

#include <atomic>
#include <functional>
#include <thread>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/mailbox.h"

#include "apps/cholecystectomy/organ_files.h"
#include "apps/cholecystectomy/play/contact_thread.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/play/session.h"

namespace cholecystectomy {

/// Publishes a state when the window has taken the last, or kSilence after it, so that a picture
/// that takes its time shows what is nearly now. States begin with organs at rest, in
/// Phase::loading, and those of a failure with Phase::failed; a session that is lost begins anew.
class SimulationThread {
 public:
  static constexpr double kSilence = 0.03;  ///< s

  struct Options {
    OrganFiles organs;
    Detail detail = Detail::full;
    bool is_paper = false;
    /// Called in the thread, which makes the device's context there.
    std::function<pbdsurg::Executor()> executor;
    /// Called in the thread whenever a session begins; may be empty.
    std::function<void(const SurgicalScene&)> on_begin{};
    /// Likewise, when the scene went back, and when pedals are to be let go; may be empty.
    std::function<void()> on_undo{}, on_let_go{};
  };

  /// Begins at once.
  /// @param hands, clock, contacts  kept by reference: they outlive the thread
  /// @param contacts                of hands that feel; null if none does
  SimulationThread(Options options, const Hands& hands, pbdsurg::Clock& clock,
                   ContactThread* contacts = nullptr);

  /// Ends after the step, or stage of loading, that runs.
  ~SimulationThread();
  SimulationThread(const SimulationThread&) = delete;
  SimulationThread& operator=(const SimulationThread&) = delete;

  pbdsurg::Mailbox<Orders> orders;      ///< the window writes
  pbdsurg::Mailbox<Seen> seen;          ///< the window writes
  pbdsurg::Mailbox<SceneState> states;  ///< the window reads

 private:
  struct Load;
  void run();
  void play(const Load& load, const pbdsurg::SolverOptions& solver);
  void show_rest(const Load& load);
  void fail(const std::string& message);

  Options options_;
  Hands hands_;
  pbdsurg::Clock& clock_;
  ContactThread* contacts_;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace cholecystectomy
