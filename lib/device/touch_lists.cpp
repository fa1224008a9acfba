// SPDX-License-Identifier: Apache-2.0
#include "lib/device/touch_lists.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <span>

#include "lib/solver/methods/touch_tree.h"

namespace pbdsurg::cuda {
namespace {

using Body = ContactBodies::Body;
using PlacedEdge = ContactBodies::Edge;

constexpr CrossingEdge kNoEdge{
    {kInvalidIndex, kInvalidIndex}, {kInvalidIndex, kInvalidIndex}, kInvalidIndex, false};

template <class T>
void fill_up(std::vector<T>& list, std::size_t unit, const T& with) {
  const std::size_t units = (list.size() + unit - 1) / unit;
  list.resize(units > 0 ? unit * std::bit_ceil(units) : 0, with);
}

template <class T>
void fill_group(std::vector<T>& list, const T& with) {
  constexpr std::size_t kGroup = TouchArrays::kGroup;
  list.resize((list.size() + kGroup - 1) / kGroup * kGroup, with);
}

Index group_count(std::size_t elements) {
  return static_cast<Index>(elements / TouchArrays::kGroup);
}

}  // namespace

TouchLists::TouchLists(const ContactBodies& of) {
  const std::span<const Body> all = of.bodies();
  const auto index_of = [&](Index body) { return static_cast<Index>(&of.body(body) - all.data()); };
  struct SlottedVertex {
    TouchSlot slot;
    TouchVertex vertex;
  };
  std::vector<SlottedVertex> slotted;
  const auto add_vertices = [&](Index from, Index to, Index pair) {
    for (const Index place : all[from].places) {
      slotted.push_back({slot_of_vertex(place, all[to].body), {place, all[from].body, to, pair}});
    }
  };
  for (const ContactPair& pair : of.pairs()) {
    const Index first = index_of(pair.first), second = index_of(pair.second);
    const auto number = static_cast<Index>(pairs.size());
    pairs.push_back({pair.contact.thickness, pair.contact.friction, first, second});
    thickest = std::max(thickest, pair.contact.thickness);
    add_vertices(first, second, number);
    if (first != second) {
      add_vertices(second, first, number);
    }
  }
  std::ranges::sort(slotted, {}, &SlottedVertex::slot);
  for (const SlottedVertex& each : slotted) {
    vertices.push_back(each.vertex);
  }
  constexpr std::size_t kFlags = 16;  // that a device reads at a time
  fill_up(vertices, kFlags, {kInvalidIndex, kInvalidIndex, kInvalidIndex, kInvalidIndex});

  std::vector<Particle> rest;
  for (const Vec3<float>& x : of.rest_positions()) {
    rest.push_back({x.x, x.y, x.z, 0});
  }
  struct OwnEdge {
    std::array<Index, 2> ends;
    Index body, index;
  };
  std::vector<OwnEdge> own_edges;
  for (Index b = 0; b < static_cast<Index>(all.size()); ++b) {
    for (std::size_t e = 0; e < all[b].edges.size(); ++e) {
      own_edges.push_back({all[b].edges[e].ends, b, static_cast<Index>(e)});
    }
  }
  std::ranges::sort(own_edges, {}, &OwnEdge::ends);
  std::vector<std::vector<Index>> number_of(all.size());  // [body][edge] among all
  for (std::size_t b = 0; b < all.size(); ++b) {
    number_of[b].resize(all[b].edges.size());
  }
  for (const OwnEdge& own : own_edges) {
    const PlacedEdge& edge = all[own.body].edges[own.index];
    number_of[own.body][own.index] = static_cast<Index>(edges.size());
    edges.push_back({{edge.ends[0], edge.ends[1]},
                     {edge.opposite[0], edge.opposite[1]},
                     all[own.body].body,
                     all[own.body].is_two_sided});
    edge_bodies.push_back(own.body);
  }
  fill_up(edges, 1, kNoEdge);
  fill_up(edge_bodies, 1, kInvalidIndex);

  TouchTree tree;
  for (std::size_t b = 0; b < all.size(); ++b) {
    const Body& body = all[b];
    TouchBody& own = bodies.emplace_back();
    own.body = body.body;
    own.is_two_sided = body.is_two_sided;
    own.first_group = group_count(triangles.size());
    order(body.triangles, rest, tree);
    for (const Index t : tree.order) {
      const ContactBodies::PlaceTriangle& corners = body.triangles[t];
      triangles.push_back({{corners[0], corners[1], corners[2]}, t});
    }
    fill_group(triangles, {{kInvalidIndex, kInvalidIndex, kInvalidIndex}, kInvalidIndex});
    own.group_count = group_count(triangles.size()) - own.first_group;
    own.first_edge_group = group_count(edge_groups.size());
    order(body.edges, rest, tree);
    for (const Index e : tree.order) {
      edge_groups.push_back(number_of[b][e]);
    }
    fill_group(edge_groups, kInvalidIndex);
    own.edge_group_count = group_count(edge_groups.size()) - own.first_edge_group;
  }
  fill_up(triangles, TouchArrays::kGroup,
          {{kInvalidIndex, kInvalidIndex, kInvalidIndex}, kInvalidIndex});
  fill_up(edge_groups, TouchArrays::kGroup, kInvalidIndex);
}

}  // namespace pbdsurg::cuda
