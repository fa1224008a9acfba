// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where the constraints go that an edit adds.

#include <algorithm>
#include <cstddef>
#include <memory_resource>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/sets/constraint_groups.h"
#include "lib/solver/sets/constraint_sets.h"

namespace pbdsurg {

/// Finds groups for new constraints while a change is followed: others at their vertices, removed
/// ones among them, may still be in their groups.
class FreeGroups {
 public:
  /// @param scratch   for lists of the change
  /// @param is_taken  a buffer
  /// @param opened    gets the kind of each group that is opened
  FreeGroups(ConstraintData& data, const Tissue& tissue, const TissueChange& change,
             std::pmr::memory_resource* scratch, std::vector<bool>& is_taken,
             std::vector<PhaseKind>& opened)
      : data_(data),
        tissue_(tissue),
        change_(change),
        gone_tets_(scratch),
        gone_links_(scratch),
        gone_triangles_(scratch),
        gone_hinges_(scratch),
        is_taken_(is_taken),
        opened_(opened) {}

  /// A group that a new constraint may join: the first of its kind that is projected in parallel,
  /// holds for the whole scene and has no constraint at any of some vertices; if there is none, one
  /// that is opened behind the others of its kind. Cost: proportional to the constraints at the
  /// vertices and to the groups that hold for the whole scene.
  template <class Constraint>
  Index find(std::span<const Index> vertices) {
    if (!has_found_gone_) {
      find_gone();
    }
    is_taken_.assign(static_cast<std::size_t>(data_.of<Constraint>().group_count()), false);
    for (const Index v : vertices) {
      for_each_group_at<Constraint>(v, [&](Index group) {
        if (group != kInvalidIndex) {
          is_taken_[group] = true;
        }
      });
    }
    const std::vector<Phase>& phases = data_.phases;
    auto phase = std::ranges::partition_point(
        phases, [&](const Phase& each) { return each.level < data_.last_level(); });
    for (; phase != phases.end(); ++phase) {
      if (takes(*phase, KindOf<Constraint>::kPhase) && !is_taken_[phase->color]) {
        return phase->color;
      }
    }
    return open<Constraint>();
  }

  /// A new group, behind the others of its kind.
  template <class Constraint>
  Index open() {
    opened_.push_back(KindOf<Constraint>::kPhase);
    return open_group<Constraint>(data_);
  }

 private:
  // Tetrahedra, links, triangles or hinges at vertices that an edit removed them from.
  using GoneAtVertices = std::pmr::vector<std::pair<Index, Index>>;  // ascending

  // What the edit took from the tissue may still have its constraints.
  void find_gone() {
    has_found_gone_ = true;
    for (const Index tet : change_.removed_tets) {
      for (const Index v : tissue_.tets()[tet]) {
        gone_tets_.emplace_back(v, tet);
      }
    }
    for (const Index link : change_.removed_links) {
      gone_links_.emplace_back(tissue_.links()[link].first, link);
      gone_links_.emplace_back(tissue_.links()[link].second, link);
    }
    for (const Index triangle : change_.removed_triangles) {
      for (const Index v : tissue_.triangles()[triangle]) {
        gone_triangles_.emplace_back(v, triangle);
      }
    }
    for (const Index hinge : change_.removed_hinges) {
      for (const Index v : tissue_.hinges()[hinge].vertices) {
        gone_hinges_.emplace_back(v, hinge);
      }
    }
    std::ranges::sort(gone_hinges_);
    std::ranges::sort(gone_triangles_);
    std::ranges::sort(gone_tets_);
    std::ranges::sort(gone_links_);
  }

  template <class Visit>
  static void for_each_at(Index vertex, std::span<const Index> living, const GoneAtVertices& gone,
                          Visit visit) {
    std::ranges::for_each(living, visit);
    auto each = std::ranges::lower_bound(gone, vertex, {}, &std::pair<Index, Index>::first);
    for (; each != gone.end() && each->first == vertex; ++each) {
      visit(each->second);
    }
  }

  template <class Visit>
  void for_each_edge_at(Index vertex, Visit visit) const {
    const std::span<const Edge> edges = tissue_.edges();
    for_each_at(vertex, tissue_.tets_at(vertex), gone_tets_, [&](Index tet) {
      for (const Index edge : tissue_.tet_edges()[tet]) {
        if (edges[edge][0] == vertex || edges[edge][1] == vertex) {
          visit(edge);
        }
      }
    });
  }

  // Calls visit(group) for those of the constraints of a kind at a vertex; some are kInvalidIndex.
  template <class Constraint, class Visit>
  void for_each_group_at(Index vertex, Visit visit) const {
    const auto& set = data_.of<Constraint>();
    switch (KindOf<Constraint>::kElement) {
      case Element::tet:
        for_each_at(vertex, tissue_.tets_at(vertex), gone_tets_,
                    [&](Index tet) { visit(set.group_of(tet)); });
        break;
      case Element::edge:
        for_each_edge_at(vertex, [&](Index edge) { visit(set.group_of(edge)); });
        break;
      case Element::link:
        for_each_at(vertex, tissue_.links_at(vertex), gone_links_,
                    [&](Index link) { visit(set.group_of(link)); });
        break;
      case Element::edge_or_link:
        for_each_edge_at(
            vertex, [&](Index edge) { visit(set.group_of(data_.distance_ids.of_edge(edge))); });
        for_each_at(vertex, tissue_.links_at(vertex), gone_links_,
                    [&](Index link) { visit(set.group_of(data_.distance_ids.of_link(link))); });
        break;
      case Element::triangle:
        for_each_at(vertex, tissue_.triangles_at(vertex), gone_triangles_,
                    [&](Index triangle) { visit(set.group_of(triangle)); });
        break;
      case Element::hinge:
        for_each_at(vertex, tissue_.hinges_at(vertex), gone_hinges_,
                    [&](Index hinge) { visit(set.group_of(hinge)); });
        break;
    }
  }

  ConstraintData& data_;
  const Tissue& tissue_;
  const TissueChange& change_;
  GoneAtVertices gone_tets_, gone_links_, gone_triangles_, gone_hinges_;
  std::vector<bool>& is_taken_;  // [group of a kind]
  std::vector<PhaseKind>& opened_;
  bool has_found_gone_ = false;
};

}  // namespace pbdsurg
