// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The front door: colour by name, then repair, limit and balance as asked.

#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/coloring.h"
#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/coloring/random_disc.h"

namespace pbdsurg {

/// What colours first, before repair, limit and balance.
enum class ColoringAlgorithm : std::uint8_t {
  greedy,           ///< see color_greedy()
  luby,             ///< see color_luby()
  jones_plassmann,  ///< see color_jones_plassmann()
  random_disc,      ///< see color_random_disc()
};

/// Options that name an algorithm are refused with another, unless they are as they were. Seed and
/// executor go with all: they change nothing where nothing is drawn, or all is sequential.
struct ColoringOptions {
  ColoringAlgorithm algorithm = ColoringAlgorithm::greedy;  ///< what colours first
  GreedyOrder order = GreedyOrder::natural;                 ///< of ColoringAlgorithm::greedy
  RandomDiscOptions disc = {};                              ///< of ColoringAlgorithm::random_disc
  /// Call repair_coloring(); after random_disc RepairSwaps::with_two, after others with_one.
  bool repair = false;
  bool balance = false;    ///< call balance_coloring(), last
  Index max_colors = 0;    ///< call limit_colors() unless it is 0
  std::uint64_t seed = 0;  ///< of all that is drawn at random
  /// Who works: threads, if it names how many, or a device; else the caller's thread. The result is
  /// the same. A solver on a device takes that from 1.5 million edges and tetrahedra on, where this
  /// is nobody: an H200 colours and repairs 0.25 million tetrahedra in 20 ms, one thread beside it
  /// in 14; 0.95 million in 47 and 57, 3.7 million in 92 and 217. Four threads gained nothing
  /// there. What edits bring to a solver is coloured by the caller's thread.
  Executor executor{};
};

/// Colours constraints, on a device where the executor is one: with the same result. The orders
/// smallest_last and saturation, which are sequential, are always the host's. cuda/coloring.h
/// leaves the colours on the device.
/// @throws InvalidArgument     as the functions it calls, or naming the option of another algorithm
/// @throws BackendUnavailable  if the executor is a device that cannot
[[nodiscard]] PBDSURG_API Coloring color_constraints(const ConstraintVertices& constraints,
                                                     const ColoringOptions& options = {});

/// "greedy", "luby", "jones_plassmann", "random_disc"
[[nodiscard]] PBDSURG_API const char* name_of(ColoringAlgorithm algorithm) noexcept;

/// "natural", "largest_valence", "smallest_last", "saturation"
[[nodiscard]] PBDSURG_API const char* name_of(GreedyOrder order) noexcept;

}  // namespace pbdsurg
