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

void check_edges(std::size_t index, const SnapshotBodyContact& contact, std::size_t vertex_count) {
  std::array<Index, 4> ends{contact.vertex, contact.edges[0], contact.edges[1], contact.edges[2]};
  std::ranges::for_each(ends, [&](Index v) { check_number(index, "vertex", v, vertex_count); });
  std::ranges::sort(ends);
  if (const auto twice = std::ranges::adjacent_find(ends); twice != ends.end()) {
    refuse_touch(index, "has vertex " + std::to_string(*twice) +
                            " twice in its two edges, which have four ends");
  }
  if (contact.body != kInvalidIndex) {
    refuse_touch(index, "has body " + std::to_string(contact.body) + "; of two edges it has none");
  }
}

// In one order whichever edge comes first.
std::array<Index, 5> key_of(const SnapshotBodyContact& contact) {
  if (contact.edges[0] == kInvalidIndex) {
    return {contact.vertex, contact.body, kInvalidIndex, kInvalidIndex, kInvalidIndex};
  }
  std::array<Index, 2> first{contact.vertex, contact.edges[0]};
  std::array<Index, 2> second{contact.edges[1], contact.edges[2]};
  std::ranges::sort(first);
  std::ranges::sort(second);
  const auto& [low, high] = std::minmax(first, second);
  return {low[0], kInvalidIndex, low[1], high[0], high[1]};
}

}  // namespace

void RememberedTouch::sort_edges() {
  std::array<Index, 2> first{slot.place, slot.edges[0]}, second{slot.edges[1], slot.edges[2]};
  std::ranges::sort(first);
  std::ranges::sort(second);
  if (second < first) {
    std::swap(first, second);
    normal = -1.0F * normal;
    friction = -1.0F * friction;
  }
  slot = slot_of_edges(first[0], first[1], second[0], second[1]);
}

void TissueTouches::forget_from(Index place, Index body) {
  const std::size_t lost = std::erase_if(remembered, [&](const RememberedTouch& known) {
    const TouchSlot& slot = known.slot;
    return slot.place >= place || slot.body >= body ||
           std::ranges::any_of(slot.edges, [&](Index end) { return end >= place; });
  });
  const bool is_any_gone = std::ranges::any_of(contacts, [&](const TissueTouch& touch) {
    return std::ranges::any_of(touch.places, [&](Index corner) { return corner >= place; }) ||
           std::ranges::any_of(touch.bodies, [&](Index each) { return each >= body; });
  });
  if (lost > 0 || is_any_gone) {
    contacts.clear();
    told.clear();
  }
}

std::vector<SnapshotBodyContact> touches_of(const SolverState& state, const CopyState& copy) {
  std::vector<SnapshotBodyContact> contacts;
  if (copy.touches.remembered.empty()) {
    return contacts;
  }
  const std::vector<Index> vertex_at = state.vertices_at_places();
  for (const RememberedTouch& known : copy.touches.remembered) {
    SnapshotBodyContact& contact = contacts.emplace_back();
    contact.vertex = vertex_at[known.slot.place];
    contact.body = known.slot.body;
    contact.normal = vector_of(known.normal);
    contact.force = known.force;
    contact.friction = vector_of(known.friction);
    if (known.slot.has_edges()) {
      std::ranges::transform(known.slot.edges, contact.edges.begin(),
                             [&](Index place) { return vertex_at[place]; });
    }
  }
  return contacts;
}

void check_touches(std::span<const SnapshotBodyContact> contacts, std::size_t vertex_count,
                   std::size_t body_count) {
  std::vector<std::array<Index, 5>> keys;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SnapshotBodyContact& contact = contacts[i];
    check_number(i, "vertex", contact.vertex, vertex_count);
    constexpr std::array kNone{kInvalidIndex, kInvalidIndex, kInvalidIndex};
    if (contact.edges == kNone) {
      check_number(i, "body", contact.body, body_count);
    } else {
      check_edges(i, contact, vertex_count);
    }
    check_force(contact, [&](const std::string& why) { refuse_touch(i, why); });
    keys.push_back(key_of(contact));
  }
  std::ranges::sort(keys);
  if (const auto twice = std::ranges::adjacent_find(keys); twice != keys.end()) {
    const auto& [vertex, body, end, second, second_end] = *twice;
    throw InvalidArgument(
        "the snapshot has two contacts of " +
        (end == kInvalidIndex
             ? "vertex " + std::to_string(vertex) + " with body " + std::to_string(body)
             : "edge " + std::to_string(vertex) + ", " + std::to_string(end) + " with edge " +
                   std::to_string(second) + ", " + std::to_string(second_end)) +
        "; a vertex has one with each body, and so have two edges with each other");
  }
}

void set_touches(std::span<const SnapshotBodyContact> contacts, const SolverState& state,
                 CopyState& copy) {
  std::vector<RememberedTouch>& remembered = copy.touches.remembered;
  copy.touches.contacts.clear();
  copy.touches.told.clear();
  remembered.clear();
  for (const SnapshotBodyContact& contact : contacts) {
    RememberedTouch& known = remembered.emplace_back();
    known = {slot_of_vertex(state.place_of_vertex[contact.vertex], contact.body),
             load(contact.normal), contact.force, load(contact.friction)};
    if (contact.edges[0] != kInvalidIndex) {
      std::ranges::transform(contact.edges, std::begin(known.slot.edges),
                             [&](Index v) { return state.place_of_vertex[v]; });
      known.sort_edges();
    }
  }
  std::ranges::sort(remembered, {}, &RememberedTouch::slot);
}

}  // namespace pbdsurg
