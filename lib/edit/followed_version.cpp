// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/followed_version.h"

#include <string>

#include "pbdsurg/core/error.h"
#include "pbdsurg/edit/compaction.h"

namespace pbdsurg {

void FollowedVersion::check(const Solver& solver, const char* who) const {
  if (solver.topology_version() != now_) {
    throw InvalidArgument(std::string(who) + " is at topology version " + std::to_string(now_) +
                          ", the solver at " + std::to_string(solver.topology_version()) +
                          ": it must take part in every edit");
  }
}

void FollowedVersion::renumber(const Solver& solver, const Renumbering& ids, const char* who) {
  if (ids.version_before != now_) {
    throw InvalidArgument(std::string(who) + " is at topology version " + std::to_string(now_) +
                          ", the compaction was of version " + std::to_string(ids.version_before));
  }
  if (solver.topology_version() != ids.version) {
    throw InvalidArgument("the compaction made topology version " + std::to_string(ids.version) +
                          ", the solver is at " + std::to_string(solver.topology_version()) + ": " +
                          who + " must be renumbered before the next edit");
  }
  now_ = before_ = ids.version;
}

}  // namespace pbdsurg
