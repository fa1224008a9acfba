// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/edit/followed_version.h"

#include <cstddef>
#include <string>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/owned.h"
#include "pbdsurg/edit/compaction.h"

namespace pbdsurg {
namespace {

// Maps of another compaction, of the same version, mostly lead elsewhere.
void check_map(const char* what, const std::vector<Index>& ids, std::size_t count) {
  std::size_t living = 0;
  for (const Index id : ids) {
    if (id != kInvalidIndex && (id < 0 || static_cast<std::size_t>(id) >= count)) {
      throw InvalidArgument("the compaction leads to number " + std::to_string(id) + " of " +
                            std::to_string(count) + " " + what + ": it is of another solver");
    }
    living += id != kInvalidIndex ? 1 : 0;
  }
  if (living != count) {
    throw InvalidArgument("the compaction leads to " + std::to_string(living) + " of " +
                          std::to_string(count) + " " + what + ": it is of another solver");
  }
}

}  // namespace

void FollowedVersion::check_not_moved_from(const char* who) const {
  if (now_ == kMovedFrom) {
    throw_moved_from(who);
  }
}

void FollowedVersion::check(const Solver& solver, const char* who) const {
  check_not_moved_from(who);
  if (solver.topology_version() != now_) {
    throw InvalidArgument(std::string(who) + " is at topology version " + std::to_string(now_) +
                          ", the solver at " + std::to_string(solver.topology_version()) +
                          ": it must take part in every edit");
  }
}

void FollowedVersion::renumber(const Solver& solver, const Renumbering& ids, const char* who) {
  check_not_moved_from(who);
  if (ids.version_before != now_) {
    throw InvalidArgument(std::string(who) + " is at topology version " + std::to_string(now_) +
                          ", the compaction was of version " + std::to_string(ids.version_before));
  }
  if (solver.topology_version() != ids.version) {
    throw InvalidArgument("the compaction made topology version " + std::to_string(ids.version) +
                          ", the solver is at " + std::to_string(solver.topology_version()) + ": " +
                          who + " must be renumbered before the next edit");
  }
  check_map("vertices", ids.vertices, static_cast<std::size_t>(solver.vertex_count()));
  check_map("tets", ids.tets, solver.tets().size());
  check_map("links", ids.links, solver.links().size());
  check_map("bodies", ids.bodies, solver.bodies().size());
  now_ = before_ = ids.version;
}

}  // namespace pbdsurg
