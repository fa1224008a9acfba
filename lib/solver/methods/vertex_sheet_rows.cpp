// SPDX-License-Identifier: Apache-2.0
// How triangles of sheets, and hinges, lie in the rows of their vertices.
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg {
namespace {

// A start is a step without a triangle. Where sheets branch at a vertex, there are many.
constexpr std::size_t kMostFans = 2;

}  // namespace

void VertexBlocks::find_triangles(Index vertex) {
  for (const Index t : triangles_at(vertex)) {
    const VertexTriangle& triangle = given_triangles_[t];
    if (!(triangle.stiffness > 0)) {
      continue;
    }
    const auto here = std::ranges::find(triangle.vertices, vertex) - triangle.vertices.begin();
    const auto a = static_cast<std::size_t>(here + 1) % 3,
               b = static_cast<std::size_t>(here + 2) % 3;
    neighborhood_.triangles.push_back({{triangle.vertices[a], triangle.vertices[b]},
                                       {triangle.weights[b], triangle.weights[a]},
                                       triangle.stiffness,
                                       triangle.target,
                                       triangle.area_damping});
    if (triangle.edge_damping[0] > 0) {
      add_dashpot(triangle.vertices[a], triangle.edge_damping[b]);
      add_dashpot(triangle.vertices[b], triangle.edge_damping[a]);
    }
  }
}

// Along an edge of triangles: one for each neighbour, as pulls are.
void VertexBlocks::add_dashpot(Index neighbor, float damping) {
  const auto known = std::ranges::find_if(neighborhood_.springs, [&](const Spring& spring) {
    return spring.neighbor == neighbor && spring.stiffness == 0;
  });
  if (known == neighborhood_.springs.end()) {
    neighborhood_.springs.push_back({neighbor, 0, 0, damping});
  } else {
    known->damping += damping;
  }
}

void VertexBlocks::write_triangles(const VertexBlock& block, Index lane, Index count) noexcept {
  const std::vector<Area>& triangles = neighborhood_.triangles;
  const Index vertex = place_at(block.corners[lane]);
  const Area padding{{vertex, vertex}, {0, 0}, 0, 0, 0};
  for (Index i = 0; i < count; ++i) {
    const Area& area = i < static_cast<Index>(triangles.size()) ? triangles[i] : padding;
    TriangleRow& row = triangles_[block.triangles.first + i];
    for (int k = 0; k < 2; ++k) {
      row.neighbors[k][lane] = offset_of(area.neighbors[k]);
      row.weights[k][lane] = area.weights[k];
    }
    row.stiffness[lane] = area.stiffness;
    row.target[lane] = area.target;
    if (has_damping_) {
      DampedRow& damped = damped_triangles_[block.triangles.first + i];
      damped.stiffness[lane] = area.stiffness;
      damped.target[lane] = area.target;
      damped.damping[lane] = area.damping;
    }
  }
}

void VertexBlocks::find_hinges(Index vertex) {
  for (const Index h : hinges_at(vertex)) {
    const VertexHinge& hinge = given_hinges_[h];
    std::array<Index, 4> v = hinge.vertices;
    const auto corner = static_cast<int>(std::ranges::find(v, vertex) - v.begin());
    for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
      const auto [a, b] = kTetEdges[e];
      if ((a == corner || b == corner) && hinge.weights[e] != 0) {
        add_pull({v[a + b - corner], hinge.weights[e], 0});
      }
    }
    if (hinge.moment == 0 && hinge.stiffness == 0 && hinge.damping == 0) {
      continue;
    }
    if (corner == 1 || corner == 3) {  // by half a turn
      v = {v[1], v[0], v[3], v[2]};
    }
    const bool is_opposite = corner >= 2;
    neighborhood_.hinges.push_back({{v[1], is_opposite ? v[0] : v[2], v[3]},
                                    is_opposite,
                                    is_opposite ? -hinge.moment : hinge.moment,
                                    hinge.stiffness,
                                    hinge.rest,
                                    hinge.damping});
  }
}

void VertexBlocks::write_hinges(const VertexBlock& block, Index lane, Index count) noexcept {
  const std::vector<Bend>& hinges = neighborhood_.hinges;
  const Index vertex = place_at(block.corners[lane]);
  const Bend padding{{vertex, vertex, vertex}, false, 0, 0, 0, 0};
  for (Index i = 0; i < count; ++i) {
    const Bend& bend = i < static_cast<Index>(hinges.size()) ? hinges[i] : padding;
    HingeRow& row = hinges_[block.hinges.first + i];
    for (int k = 0; k < 3; ++k) {
      row.neighbors[k][lane] = offset_of(bend.neighbors[k]);
    }
    row.moment[lane] = bend.moment;
    row.stiffness[lane] = bend.stiffness;
    row.rest[lane] = bend.rest;
    row.is_opposite[lane] = bend.is_opposite ? 1.0F : 0.0F;
    row.damping[lane] = bend.damping;
  }
}

// Where volumes pull along, strips have the pulls; what damping changes is in rows alone.
// @return  VertexBlock::fan_steps
Index VertexBlocks::find_fan() {
  fan_entries_.clear();
  const std::vector<Area>& triangles = neighborhood_.triangles;
  if (triangles.empty() || !neighborhood_.volumes.empty() || is_neighborhood_damped()) {
    return 0;
  }
  is_left_.assign(triangles.size(), true);
  const auto find_left = [&](const auto& is_it) {
    std::size_t i = 0;
    while (i < triangles.size() && !(is_left_[i] && is_it(triangles[i]))) {
      ++i;
    }
    return i;
  };
  const auto start = [&] {  // one that follows no other, or any
    const std::size_t end = find_left([&](const Area& area) {
      return find_left([&](const Area& other) {
               return other.neighbors[1] == area.neighbors[0];
             }) == triangles.size();
    });
    return end < triangles.size() ? end : find_left([](const Area&) { return true; });
  };
  for (std::size_t i = start(); i < triangles.size(); i = start()) {
    fan_entries_.push_back({triangles[i].neighbors[0], 0, 0, 0, 0});
    while (i < triangles.size()) {
      const Area& area = triangles[i];
      is_left_[i] = false;
      fan_entries_.push_back(
          {area.neighbors[1], area.stiffness, area.target, area.weights[0] + area.weights[1], 0});
      i = find_left([&](const Area& next) { return next.neighbors[0] == area.neighbors[1]; });
    }
  }
  const auto steps = static_cast<Index>(fan_entries_.size());
  if (fan_entries_.size() > triangles.size() + kMostFans) {
    fan_entries_.clear();
    return 0;
  }
  const auto pull = [&](Index corner, float weight) {
    const auto entry = std::ranges::find(fan_entries_, corner, &FanEntry::corner);
    if (entry == fan_entries_.end()) {
      fan_entries_.push_back({corner, 0, 0, 0, weight});
    } else {
      entry->weight += weight;
    }
  };
  for (const Area& area : triangles) {
    pull(area.neighbors[0], area.weights[0]);
    pull(area.neighbors[1], area.weights[1]);
  }
  for (const Pull& each : neighborhood_.pulls) {
    pull(each.neighbor, each.weight);
  }
  return steps;
}

void VertexBlocks::write_fan(const VertexBlock& block, Index lane, Index count) noexcept {
  const FanEntry padding{place_at(block.corners[lane]), 0, 0, 0, 0};
  for (Index i = 0; i < count; ++i) {
    const FanEntry& entry = i < static_cast<Index>(fan_entries_.size()) ? fan_entries_[i] : padding;
    FanRow& row = fans_[block.fans.first + i];
    row.corners[lane] = offset_of(entry.corner);
    row.stiffness[lane] = entry.stiffness;
    row.target[lane] = entry.target;
    row.within[lane] = entry.within;
    row.weights[lane] = entry.weight;
  }
}

}  // namespace pbdsurg
