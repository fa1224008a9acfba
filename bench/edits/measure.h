// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What deletions and cuts cost, beside the step.

#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"

#include "bench/edits/cut_times.h"
#include "bench/edits/deletions.h"

namespace pbdsurg::bench {

/// How much is measured.
struct EditEffort {
  std::vector<int> rates;     ///< tetrahedra a second, ascending
  int frames;                 ///< at each rate
  double most_deleted = 0.2;  ///< of the mesh, at each rate: fewer frames where it would be more
  int cut_frames = 0;
};

/// One pattern at one rate; medians over frames.
struct EditTimes {
  Pattern pattern;
  int deletions_per_s;  ///< 0: none
  int frames;
  Index deleted;         ///< in all
  double plain_step_ms;  ///< of a solver that is not edited, which takes turns
  double step_ms;        ///< that follows an edit, or with the edit within it
  double edit_ms;        ///< the whole transaction
  double us_per_deletion;
  double added_ms;  ///< by which the edit and the step exceed the plain one
};

/// All patterns and rates on one mesh.
struct EditRun {
  std::string plan;
  std::string backend;
  bool overlaps;  ///< edits go on while a device steps
  std::vector<EditTimes> times;
  std::optional<CutTimes> cut;
};

/// Steps the scene of a mesh at 60 frames a second, and deletes tetrahedra in one edit a frame, in
/// which all that follows topology takes part; and cuts it.
/// @throws Error  if a step leaves vertices that are not finite
[[nodiscard]] EditRun measure_edits(const TetMesh& mesh, const Material& material,
                                    const SolverOptions& options, const EditEffort& effort);

}  // namespace pbdsurg::bench
