// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver is built of, and the building.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"

#include "solver/constraint_numbers.h"
#include "solver/vertex_blocks.h"

namespace pbdsurg {

class Backend;
class SolverData;

/// Living tissue with its numbers: a scene's at rest, or a solver's after edits.
struct SolverInput {
  SolverOptions options;  ///< with a composition that is not automatic
  Eigen::Vector3f gravity;
  std::vector<Body> bodies;
  std::vector<Eigen::Vector3d> positions;  ///< [vertex_count] m, finite; near ones get near places
  std::vector<double> vertex_masses;       ///< [vertex_count] kg
  std::vector<bool> is_fixed;              ///< [vertex_count]
  std::vector<Tet> tets;                   ///< [tet_count]
  std::vector<double> tet_masses;          ///< [tet_count] kg
  std::vector<Edge> edges;                 ///< [edge_count] from find_edges()
  std::vector<Link> links;                 ///< [link_count]
  ConstraintNumbers numbers;
  std::vector<VertexTet> vertex_tets;  ///< [tet_count] of the vertex-block method, else empty
};

/// @param options  with a composition that is not automatic
[[nodiscard]] SolverInput input_of(const Scene& scene, const SolverOptions& options);

/// Colours and plans; all but a backend.
[[nodiscard]] std::unique_ptr<SolverData> build_solver_data(SolverInput input);

/// One that works on the arrays of a solver's data.
/// @throws BackendUnavailable  see Solver
[[nodiscard]] std::unique_ptr<Backend> make_host_backend(const SolverOptions& options);

}  // namespace pbdsurg
