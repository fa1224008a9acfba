// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a scene of Neo-Hookean bodies and links comes to rest, in double precision and without a
/// solver of the library.

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "pbdsurg/tissue/scene.h"

#include "bench/support/neo_hookean.h"

namespace pbdsurg::bench {

using Positions = std::vector<Eigen::Vector3d>;  // [vertex_count] m

/// A link, or an edge beyond the limit of its stretch.
struct Bar {
  Index first, second;
  double stiffness;    ///< N/m
  double rest_length;  ///< m
  bool is_limit;       ///< pulls only where it is longer
};

/// Elastic energy and weight of a scene, with what tools do to it.
class StaticEnergy {
 public:
  /// @param scene  of Neo-Hookean bodies; must outlive this
  explicit StaticEnergy(const Scene& scene);

  /// From now on these stay where positions have them, as fixed ones do.
  void hold(std::span<const Index> vertices);

  /// A sphere without friction that pushes vertices out, by a penalty ten thousand times as stiff
  /// as the tissue at a vertex.
  void press(const Eigen::Vector3d& center, double radius);

  /// A force that does not turn with the tissue, N.
  void pull(Index vertex, const Eigen::Vector3d& force);

  /// J, without the constant of the rest state.
  [[nodiscard]] double value(const Positions& positions) const;

  /// Out-of-balance force on each vertex, N; zero on those that stay.
  [[nodiscard]] Positions forces(const Positions& positions) const;

  /// Second derivative, N/m; of vertices that stay a diagonal of one.
  [[nodiscard]] Eigen::SparseMatrix<double> hessian(const Positions& positions) const;

  /// Sum of the magnitudes of the forces, N.
  [[nodiscard]] double imbalance(const Positions& positions) const;

  /// Sum of the magnitudes of what acts from outside: weight, pulls, holds and spheres, N.
  [[nodiscard]] double load(const Positions& positions) const;

  /// What holds these vertices, N.
  /// @return  [n]
  [[nodiscard]] std::vector<Eigen::Vector3d> holding_forces(std::span<const Index> vertices,
                                                            const Positions& positions) const;

  /// What keeps the spheres where they are, together, N.
  [[nodiscard]] Eigen::Vector3d pressing_force(const Positions& positions) const;

  [[nodiscard]] const Scene& scene() const noexcept { return scene_; }
  [[nodiscard]] bool stays(Index vertex) const { return stays_[vertex]; }

 private:
  struct Sphere {
    Eigen::Vector3d center;
    double radius;
  };

  [[nodiscard]] Positions all_forces(const Positions& positions) const;

  const Scene& scene_;
  std::vector<Element> elements_;
  std::vector<Bar> bars_;
  std::vector<bool> stays_;
  std::vector<Sphere> spheres_;
  Positions pulls_;               // [vertex_count] N
  double contact_stiffness_ = 0;  // N/m, of a vertex
};

/// Newton's method with a sparse Cholesky factorisation.
/// @param start  with what is held at its place
/// @throws Error  unless the imbalance falls below 1e-9 of the load
[[nodiscard]] Positions find_equilibrium(const StaticEnergy& energy, Positions start);

/// Likewise from rest shape, with held vertices brought to their places step by step.
/// @param places  of all vertices; those that are not held are not read
[[nodiscard]] Positions find_equilibrium_by_steps(const StaticEnergy& energy,
                                                  const Positions& places, int steps);

/// What a tool's force is compared with, and how far tissue is from rest.
struct HeldRest {
  Eigen::Vector3d force;  ///< N, of tissue on what holds or presses it
  double farthest = 0;    ///< m, of a vertex from its place at rest
};

/// The static solution with some vertices held where they are.
/// @param positions  m, of all vertices
[[nodiscard]] HeldRest rest_with_held(const Scene& scene, std::span<const Index> held,
                                      std::span<const Eigen::Vector3f> positions);

/// The static solution with a ball that presses: see StaticEnergy::press().
/// @param center     m
/// @param radius     m
/// @param positions  m, of all vertices
[[nodiscard]] HeldRest rest_under_ball(const Scene& scene, const Eigen::Vector3d& center,
                                       double radius, std::span<const Eigen::Vector3f> positions);

/// Of the lowest mode, 1/s: Rayleigh's quotient of the shape in which a scene sags.
[[nodiscard]] double lowest_frequency(const Scene& scene, const Positions& equilibrium);

}  // namespace pbdsurg::bench
