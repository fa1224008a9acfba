// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/contact_thread.h"

#include "apps/cholecystectomy/play/instrument_contacts.h"

namespace cholecystectomy {

ContactThread::ContactThread(rig::Rig& rig, const std::array<rig::Side, 2>& sides,
                             const pbdsurg::Clock& clock)
    : rig_(rig), sides_(sides), clock_(clock), thread_([this] { run(); }) {}

ContactThread::~ContactThread() {
  is_ending_ = true;
  publish();
  thread_.join();
}

std::array<pbdsurg::ContactPatch*, 2> ContactThread::drafts() {
  std::array<pbdsurg::ContactPatch*, 2> drafts{};
  for (std::size_t i = 0; i < drafts.size(); ++i) {
    drafts[i] = rig_.has_servo(sides_[i]) ? &patches_[i].draft() : nullptr;
  }
  return drafts;
}

void ContactThread::publish() {
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    if (!is_ending_ && rig_.has_servo(sides_[i])) {
      patches_[i].publish();
    }
  }
  ++published_;
  published_.notify_one();
}

void ContactThread::run() {
  rig::AgeHistogram all_ages;
  for (std::uint32_t seen = 0;;) {
    published_.wait(seen);
    seen = published_;  // before patches are taken: one that comes now wakes again
    if (is_ending_) {
      return;
    }
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      if (patches_[i].take() > 0) {
        const pbdsurg::ContactPatch& patch = patches_[i].value();
        rig_.publish(sides_[i], packet_of(patch));
        all_ages.add(clock_.now() - patch.time);
      }
    }
    ages.draft() = all_ages;
    ages.publish();
  }
}

}  // namespace cholecystectomy
