// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Makes contact packets for servos, after each step of the simulation, in a thread of its own.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/contact/contact_patch.h"

#include "apps/rig/age_histogram.h"
#include "apps/rig/rig.h"

namespace cholecystectomy {

class ContactThread {
 public:
  /// @param rig    outlives the thread, as the clock
  /// @param sides  where the grasper and the hook are held
  ContactThread(rig::Rig& rig, const std::array<rig::Side, 2>& sides, const pbdsurg::Clock& clock);
  ~ContactThread();
  ContactThread(const ContactThread&) = delete;
  ContactThread& operator=(const ContactThread&) = delete;

  /// @name The simulation's thread
  /// @{
  /// To be filled: null where nobody feels it.
  [[nodiscard]] std::array<pbdsurg::ContactPatch*, 2> drafts();
  void publish();  ///< wakes the thread
  /// @}

  /// s, how old the poses of hands were, for which a packet was made, when it was. The window
  /// reads.
  pbdsurg::Mailbox<rig::AgeHistogram> ages;

 private:
  void run();

  rig::Rig& rig_;
  std::array<rig::Side, 2> sides_;
  const pbdsurg::Clock& clock_;
  std::array<pbdsurg::Mailbox<pbdsurg::ContactPatch>, 2> patches_;  // of the grasper, of the hook
  std::atomic<std::uint32_t> published_ = 0;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;  // last: it uses the others
};

}  // namespace cholecystectomy
