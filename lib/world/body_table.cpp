// SPDX-License-Identifier: Apache-2.0
#include "lib/world/body_table.h"

#include <algorithm>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/renumbering.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/tissue/renumber.h"

namespace pbdsurg {

BodyId BodyTable::add(const std::string& name, const TissueRecord& record, Index in_tissue) {
  entries_.push_back({name, record, in_tissue, kInvalidIndex, std::max(in_tissue, kInvalidIndex)});
  return BodyId(static_cast<Index>(entries_.size()) - 1);
}

const BodyTable::Entry& BodyTable::entry(BodyId body) const {
  if (body < 0 || body >= static_cast<Index>(entries_.size())) {
    throw InvalidArgument("there is no body " + std::to_string(body.value) + "; the world has " +
                          std::to_string(entries_.size()));
  }
  return entries_[body];
}

Index BodyTable::in_tissue(BodyId body) const {
  const Entry& own = entry(body);
  if (own.in_tissue == kWaiting) {
    throw InvalidArgument("body '" + own.name + "' is not there yet; it comes with the next step");
  }
  if (own.in_tissue == kInvalidIndex) {
    throw InvalidArgument("body '" + own.name +
                          "' is not there any more; it was removed, or refused when it came");
  }
  return own.in_tissue;
}

const TissueRecord& BodyTable::record(BodyId body) const {
  return entry(body).record;
}

const std::string& BodyTable::name(BodyId body) const {
  return entry(body).name;
}

BodyId BodyTable::find(const std::string& name) const {
  const auto found = std::find_if(entries_.rbegin(), entries_.rend(),
                                  [&](const Entry& entry) { return entry.name == name; });
  if (found == entries_.rend()) {
    std::string known;
    for (const Entry& entry : entries_) {
      known += (known.empty() ? "" : ", ") + entry.name;
    }
    throw InvalidArgument("there is no body named '" + name +
                          "'; the world has: " + (known.empty() ? "none" : known));
  }
  return BodyId(static_cast<Index>(entries_.rend() - found) - 1);
}

void BodyTable::stop_waiting() noexcept {
  for (Entry& entry : entries_) {
    entry.in_tissue = entry.in_tissue == kWaiting ? kInvalidIndex : entry.in_tissue;
  }
}

void BodyTable::follow(const Tissue& /*tissue*/, const TissueChange& change) noexcept {
  const TopologyEdit& edit = change.edit;
  for (Entry& entry : entries_) {
    entry.before = entry.in_tissue == kWaiting ? kInvalidIndex : entry.in_tissue;
    if (entry.in_tissue == kWaiting) {
      const auto come = std::ranges::find(edit.new_bodies.bodies(), entry.name, &Body::name);
      if (come != edit.new_bodies.bodies().end()) {
        entry.in_tissue =
            change.first_new_body + static_cast<Index>(come - edit.new_bodies.bodies().begin());
        entry.last_in_tissue = entry.in_tissue;
      }
    } else if (std::ranges::count(edit.remove_bodies, entry.in_tissue) > 0) {
      entry.in_tissue = kInvalidIndex;
    }
  }
}

// What was added since the edit waits on.
void BodyTable::undo(const Tissue& /*tissue*/, const TissueChange& /*change*/) noexcept {
  for (Entry& entry : entries_) {
    if (entry.in_tissue == kWaiting) {
      continue;
    }
    if (entry.in_tissue != kInvalidIndex && entry.before == kInvalidIndex) {
      entry.last_in_tissue = kInvalidIndex;  // it came with the edit
    }
    entry.in_tissue = entry.before;
  }
}

void BodyTable::renumber(const Tissue& /*tissue*/, const Renumbering& ids) noexcept {
  for (Entry& entry : entries_) {
    if (entry.in_tissue != kWaiting) {
      entry.in_tissue = new_id(entry.in_tissue, ids.bodies);
    }
    entry.last_in_tissue = new_id(entry.last_in_tissue, ids.bodies);
  }
}

}  // namespace pbdsurg
