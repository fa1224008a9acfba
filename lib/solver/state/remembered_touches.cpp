// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/remembered_touches.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/solver/state/load_store.h"
#include "lib/solver/state/remembered_contacts.h"

namespace pbdsurg {
namespace {

[[noreturn]] void refuse_touch(std::size_t contact, const std::string& why) {
  throw InvalidArgument("contact " + std::to_string(contact) + " between bodies of the snapshot " +
                        why);
}

void check_number(std::size_t contact, const char* what, Index id, std::size_t count) {
  if (id < 0 || static_cast<std::size_t>(id) >= count) {
    refuse_touch(contact, "has " + std::string(what) + " " + std::to_string(id) +
                              "; ids must be in [0, " + std::to_string(count) + ")");
  }
}

}  // namespace

std::vector<SnapshotBodyContact> touches_of(const SolverState& state, const CopyState& copy) {
  std::vector<SnapshotBodyContact> contacts;
  if (copy.touches.remembered.empty()) {
    return contacts;
  }
  const std::vector<Index> vertex_at = state.vertices_at_places();
  for (const RememberedTouch& known : copy.touches.remembered) {
    contacts.push_back({vertex_at[known.slot.place], known.slot.body, vector_of(known.normal),
                        known.force, vector_of(known.friction)});
  }
  return contacts;
}

void check_touches(std::span<const SnapshotBodyContact> contacts, std::size_t vertex_count,
                   std::size_t body_count) {
  std::vector<std::pair<Index, Index>> slots;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SnapshotBodyContact& contact = contacts[i];
    check_number(i, "vertex", contact.vertex, vertex_count);
    check_number(i, "body", contact.body, body_count);
    check_force(contact, [&](const std::string& why) { refuse_touch(i, why); });
    slots.emplace_back(contact.vertex, contact.body);
  }
  std::ranges::sort(slots);
  if (const auto twice = std::ranges::adjacent_find(slots); twice != slots.end()) {
    throw InvalidArgument("the snapshot has two contacts of vertex " +
                          std::to_string(twice->first) + " with body " +
                          std::to_string(twice->second) + "; a vertex has one with each body");
  }
}

void set_touches(std::span<const SnapshotBodyContact> contacts, const SolverState& state,
                 CopyState& copy) {
  std::vector<RememberedTouch>& remembered = copy.touches.remembered;
  copy.touches.contacts.clear();
  remembered.clear();
  for (const SnapshotBodyContact& contact : contacts) {
    remembered.push_back({{state.place_of_vertex[contact.vertex], contact.body},
                          load(contact.normal),
                          contact.force,
                          load(contact.friction)});
  }
  std::ranges::sort(remembered, {}, &RememberedTouch::slot);
}

}  // namespace pbdsurg
