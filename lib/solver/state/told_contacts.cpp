// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/told_contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

// The vertices of a contact, before kInvalidIndex.
template <std::size_t Count>
std::span<const Index> corners_of(const std::array<Index, Count>& vertices) {
  const auto end = std::ranges::find(vertices, kInvalidIndex);
  return {vertices.begin(), end};
}

template <std::size_t Count>
void check_corners(const std::array<Index, Count>& vertices,
                   const std::array<float, Count>& weights, std::size_t vertex_count) {
  const std::span<const Index> corners = corners_of(vertices);
  for (const Index v : corners) {
    if (v < 0 || static_cast<std::size_t>(v) >= vertex_count) {
      throw InvalidArgument("a contact is told of vertex " + std::to_string(v) +
                            "; ids must be in [0, " + std::to_string(vertex_count) + ")");
    }
  }
  if (corners.empty() || std::ranges::count(vertices, kInvalidIndex) !=
                             static_cast<std::ptrdiff_t>(Count - corners.size())) {
    throw InvalidArgument("a contact is told of vertices that do not follow each other");
  }
  for (const float weight : weights) {
    if (!std::isfinite(weight)) {
      throw InvalidArgument("a contact is told with a weight of " + std::to_string(weight) +
                            "; weights must be finite");
    }
  }
}

// Whether they are there now.
template <std::size_t Count>
bool renumber_corners(std::array<Index, Count>& vertices, const std::vector<Index>& ids) {
  const std::size_t count = corners_of(vertices).size();
  const std::span<Index> corners(vertices.data(), count);
  std::ranges::transform(corners, corners.begin(), [&](Index v) { return ids[v]; });
  return corners_of(vertices).size() == count;
}

}  // namespace

std::vector<ToolContact> contacts_of_tool(const SolverState& state, const CopyState& copy,
                                          const ToolState& tool) {
  if (tool.surface_contacts.empty()) {
    return tool.told;
  }
  const float scale = copy.factors.stiffness;  // see substep_numbers()
  const std::vector<Index> vertex_at = state.vertices_at_places();
  std::vector<ToolContact> contacts;
  for (std::size_t c = 0; c < tool.surface_contacts.size(); ++c) {
    const SurfaceContact& contact = tool.surface_contacts[c];
    const RememberedContact& force = tool.remembered[c];
    ToolContact& told = contacts.emplace_back();
    told.vertices.fill(kInvalidIndex);
    for (int k = 0; k < contact.feature.count(); ++k) {
      told.vertices[k] = vertex_at[contact.feature.places[k]];
    }
    std::ranges::copy(contact.weights, told.weights.begin());
    told.point = vector_of(contact.point);
    told.normal = vector_of(contact.normal);
    told.force = -scale * vector_of(force.force * force.normal + force.friction);
  }
  return contacts;
}

std::vector<BodyContact> contacts_of_bodies(const SolverState& state, const CopyState& copy) {
  const TissueTouches& touches = copy.touches;
  if (touches.contacts.empty()) {
    return touches.told;
  }
  const float scale = copy.factors.stiffness;  // see substep_numbers()
  const std::vector<Index> vertex_at = state.vertices_at_places();
  std::vector<BodyContact> contacts;
  for (std::size_t c = 0; c < touches.contacts.size(); ++c) {
    const TissueTouch& touch = touches.contacts[c];
    const RememberedTouch& force = touches.remembered[c];
    BodyContact& told = contacts.emplace_back();
    told.first = touch.bodies[0];
    told.second = touch.bodies[1];
    told.first_count = touch.first_corners;
    std::array<Eigen::Vector3f, 2> points{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      const bool is_again = k == 3 && touch.places[k] == touch.places[k - 1];
      const int side = touch.side_of(k);
      told.vertices[k] = is_again ? kInvalidIndex : vertex_at[touch.places[k]];
      told.weights[k] = side == 0 ? touch.weights[k] : -touch.weights[k];
      points[side] += told.weights[k] * vector_of(load(copy.particles[touch.places[k]]));
    }
    told.point = points[1];
    told.normal = vector_of(touch.normal);
    told.distance = told.normal.dot(points[0] - points[1]);
    told.force = scale * vector_of(force.force * force.normal + force.friction);
  }
  return contacts;
}

void forget_told(CopyState& copy) noexcept {
  for (ToolState& tool : copy.tools) {
    tool.told.clear();
  }
  copy.touches.told.clear();
}

void check_told(const std::vector<ToolContact>& contacts, std::size_t vertex_count) {
  for (const ToolContact& contact : contacts) {
    check_corners(contact.vertices, contact.weights, vertex_count);
    if (!contact.force.allFinite()) {
      throw InvalidArgument("a contact is told with a force that is not finite");
    }
  }
}

void check_told(const std::vector<BodyContact>& contacts, std::size_t vertex_count,
                std::size_t body_count) {
  for (const BodyContact& contact : contacts) {
    check_corners(contact.vertices, contact.weights, vertex_count);
    for (const Index body : {contact.first, contact.second}) {
      if (body < 0 || static_cast<std::size_t>(body) >= body_count) {
        throw InvalidArgument("a contact is told of body " + std::to_string(body) +
                              "; ids must be in [0, " + std::to_string(body_count) + ")");
      }
    }
    if (contact.first_count != 1 && contact.first_count != 2) {
      throw InvalidArgument("a contact is told with " + std::to_string(contact.first_count) +
                            " vertices of its first body; it has 1 or 2");
    }
    if (!contact.force.allFinite()) {
      throw InvalidArgument("a contact is told with a force that is not finite");
    }
  }
}

void renumber(std::vector<ToolContact>& contacts, const std::vector<Index>& vertices) {
  std::erase_if(contacts, [&](ToolContact& contact) {
    return !renumber_corners(contact.vertices, vertices);
  });
}

void renumber(std::vector<BodyContact>& contacts, const std::vector<Index>& vertices,
              const std::vector<Index>& bodies) {
  std::erase_if(contacts, [&](BodyContact& contact) {
    contact.first = bodies[contact.first];
    contact.second = bodies[contact.second];
    return !renumber_corners(contact.vertices, vertices) || contact.first == kInvalidIndex ||
           contact.second == kInvalidIndex;
  });
}

}  // namespace pbdsurg
