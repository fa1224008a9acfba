// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/remembered_contacts.h"

#include <algorithm>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

[[noreturn]] void refuse(std::size_t contact, const std::string& why) {
  throw InvalidArgument("contact " + std::to_string(contact) + " of the snapshot " + why);
}

}  // namespace

std::vector<SnapshotContact> contacts_of(const SolverState& state, const CopyState& copy) {
  std::vector<SnapshotContact> contacts;
  if (std::ranges::all_of(copy.tools,
                          [](const ToolState& tool) { return tool.remembered.empty(); })) {
    return contacts;
  }
  const std::vector<Index> vertex_at = state.vertices_at_places();
  for (std::size_t t = 0; t < copy.tools.size(); ++t) {
    for (const RememberedContact& known : copy.tools[t].remembered) {
      SnapshotContact contact{ToolId(static_cast<Index>(t)),
                              {},
                              vector_of(known.normal),
                              known.force,
                              vector_of(known.friction)};
      contact.vertices.fill(kInvalidIndex);
      for (int k = 0; k < known.feature.count(); ++k) {
        contact.vertices[k] = vertex_at[known.feature.places[k]];
      }
      contacts.push_back(contact);
    }
  }
  return contacts;
}

void check_contacts(std::span<const SnapshotContact> contacts, std::span<const ToolState> tools,
                    std::size_t vertex_count) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SnapshotContact& contact = contacts[i];
    if (contact.tool < 0 || contact.tool >= static_cast<Index>(tools.size())) {
      refuse(i, "is of tool " + std::to_string(contact.tool.value) + "; there are " +
                    std::to_string(tools.size()));
    }
    bool is_behind = false;
    for (std::size_t k = 0; k < contact.vertices.size(); ++k) {
      const Index v = contact.vertices[k];
      const bool is_there = v >= 0 && static_cast<std::size_t>(v) < vertex_count;
      if (!is_there && !(v == kInvalidIndex && k > 0)) {
        refuse(i, "has vertex " + std::to_string(v) + "; ids must be in [0, " +
                      std::to_string(vertex_count) + ")");
      }
      if (is_there && is_behind) {
        refuse(i, "has vertex " + std::to_string(v) + " behind one that there is not");
      }
      is_behind = !is_there;
    }
    check_force(contact, [&](const std::string& why) { refuse(i, why); });
  }
}

void set_contacts(std::span<const SnapshotContact> contacts, const SolverState& state,
                  CopyState& copy) {
  for (const SnapshotContact& contact : contacts) {
    if (copy.tools[contact.tool].is_removed) {
      continue;
    }
    RememberedContact known{{}, load(contact.normal), contact.force, load(contact.friction)};
    std::ranges::transform(contact.vertices, known.feature.places, [&](Index v) {
      return v == kInvalidIndex ? v : state.place_of_vertex[v];
    });
    known.feature.sort();
    copy.tools[contact.tool].remembered.push_back(known);
  }
  for (ToolState& tool : copy.tools) {
    std::ranges::sort(tool.remembered, {}, &RememberedContact::feature);
  }
}

}  // namespace pbdsurg
