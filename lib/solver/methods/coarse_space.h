// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The slow, wide motions of a scene, which sweeps over vertices take many rounds to find: a few
/// nodes spread over the tissue, each moving what is near it affinely, as in a deformation graph
/// (Sumner, Schmid, Pauly 2007, "Embedded Deformation for Shape Manipulation"). Of these motions
/// the softest modes at rest are kept. What moves by them: coarse_correction.h.

#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/topology_edit.h"

#include "lib/solver/methods/coarse_kernel.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

class SolverData;

/// What a node moves, ascending by place.
struct NodeMembers {
  std::vector<Index> own;  ///< places of vertices that are nearer to it than to other nodes
  std::vector<Index> places;
  std::vector<CoarseShares> shares;
};

class CoarseSpace {
 public:
  CoarseSpace() = default;

  /// Cost: O(V log V + T) and the eigenvectors of a matrix of 576 rows at most: see SolverOptions.
  /// @param data  with rows of vertices, at rest; inverse masses say which of these are free
  explicit CoarseSpace(const SolverData& data);

  [[nodiscard]] std::span<const CoarseVertex> vertices() const noexcept { return vertices_; }
  [[nodiscard]] Index node_count() const noexcept {
    return static_cast<Index>(piece_of_node_.size());
  }
  [[nodiscard]] Index piece_count() const noexcept { return piece_count_; }
  [[nodiscard]] Index piece_of(Index node) const noexcept { return piece_of_node_[node]; }

  [[nodiscard]] const NodeMembers& members(Index node) const noexcept { return members_[node]; }

  /// 1/s^2, of each mode: its stiffness over its mass.
  [[nodiscard]] std::span<const float> stiffnesses() const noexcept { return stiffnesses_; }

  /// 1/sqrt(kg), numbers of a mode: [node][1, X, Y, Z][axis].
  [[nodiscard]] std::span<const float> mode(Index mode) const noexcept {
    return {modes_.data() + mode * number_count(), static_cast<std::size_t>(number_count())};
  }

  /// [mode][number], and [number][mode]
  [[nodiscard]] std::span<const float> all_modes() const noexcept { return modes_; }
  [[nodiscard]] std::span<const float> all_numbers() const noexcept { return numbers_; }

  /// The same number of all modes.
  [[nodiscard]] std::span<const float> numbers(Index number) const noexcept {
    return {numbers_.data() + number * stiffnesses_.size(), stiffnesses_.size()};
  }

  // Edits. What they cut or remove stays in the modes, which are then too stiff and no less good a
  // direction; new bodies take no part.

  /// @param place_of_vertex  of what there is, with the new ones
  void add(std::span<const NewVertex> vertices, std::span<const Index> place_of_vertex);

  /// New places take no part; an undo takes the last away.
  void resize(std::size_t place_count);
  void reserve(std::size_t more);

  /// The first place that has changed since it was last asked for; no place if none has.
  [[nodiscard]] PBDSURG_API Index take_first_changed() noexcept;

  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  [[nodiscard]] Index number_count() const noexcept { return kAffineNumbers * node_count(); }

  void add(const CoarseVertex& vertex);

  std::vector<CoarseVertex> vertices_;  // [place]
  std::vector<NodeMembers> members_;    // [node]
  std::vector<Index> piece_of_node_;
  Index piece_count_ = 0;
  Index first_changed_ = kMostParticles;
  std::vector<float> stiffnesses_;  // [mode] ascending
  std::vector<float> modes_;        // [mode][number]
  std::vector<float> numbers_;      // [number][mode]
};

}  // namespace pbdsurg
