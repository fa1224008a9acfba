// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a world of one liver takes, and how long its frames are.

#include <cstdint>
#include <string>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg::bench {

/// How much is measured.
struct SizeEffort {
  int constructions;
  int frames;  ///< quiet ones, then as many that burn
};

/// Medians of frames, ms.
struct FrameTimes {
  double heat, edit, step, readback;  ///< see Frame::times
  double frame;                       ///< all of World::step()
  double stages_over_frame;           ///< the stages' sum over the frame, within each
};

struct SizeTimes {
  std::string backend;
  Index vertices, tets;
  Index removed_tets;                       ///< in all frames, by heat and program
  std::int64_t tissue_bytes, solver_bytes;  ///< memory_bytes(); those on a device, too
  std::int64_t heat_bytes, surface_bytes;   ///< of the heap, when they were made
  std::int64_t heap_bytes, resident_bytes;  ///< growth, from the mesh to the last frame
  double tissue_ms, solver_ms, heat_ms;     ///< of constructors, medians
  FrameTimes quiet, burn;
  std::uint64_t strict_hash;  ///< of a few strict frames; the serial executor gives the same
};

/// @throws Error  if strict frames end otherwise than the serial executor's, or the stages' sum
///                misses the frame by more than 5 %, or the hook heats nothing
[[nodiscard]] SizeTimes measure_size(const TetMesh& liver, const Executor& executor,
                                     const SizeEffort& effort);

}  // namespace pbdsurg::bench
