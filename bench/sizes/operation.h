// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A liver in a world, a hook that burns it, and a program that removes tetrahedra.

#include <cstdint>
#include <vector>

#include "pbdsurg/world/world.h"

namespace pbdsurg::bench {

/// A frame and how long World::step() took.
struct Timed {
  Frame frame;
  double ms;
};

/// The liver's upper part is fixed; the hook waits below.
class Operation {
 public:
  Operation(const TetMesh& liver, const SolverOptions& options, const CauteryOptions& cautery = {});

  /// Nothing touches the liver, nothing changes it.
  /// @throws Error  if the world refuses something or a vertex is not finite
  Timed quiet_frame();

  /// The hook burns where the liver is lowest; a few tetrahedra go at its far end.
  /// @throws Error  likewise
  Timed burn_frame();

  [[nodiscard]] World& world() { return world_; }
  /// Of the heap, while the cautery was added.
  [[nodiscard]] std::int64_t heat_bytes() const { return heat_bytes_; }
  /// Of the heap, while the surface was made.
  [[nodiscard]] std::int64_t surface_bytes() const { return surface_bytes_; }

 private:
  Timed step();

  World world_;
  ToolId hook_;
  CauteryId burner_;
  const Surface* skin_;
  std::vector<Index> next_removed_;  // from its end
  std::int64_t heat_bytes_, surface_bytes_;
};

}  // namespace pbdsurg::bench
