// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "lib/solver/methods/group_balance.h"
#include "lib/solver/methods/workers.h"

namespace pbdsurg::testing {

/// The twists of some pieces, by one worker.
inline GroupSpace balanced(const std::vector<RigidBody>& bodies,
                           const std::vector<GroupContact>& contacts) {
  std::vector<GroupAnswer> answers(contacts.size());
  GroupSpace space{};
  GroupBalance(OneWorker{}, bodies.data(), static_cast<Index>(bodies.size()), contacts.data(),
               static_cast<Index>(contacts.size()), answers.data(), space)
      .run();
  return space;
}

}  // namespace pbdsurg::testing
