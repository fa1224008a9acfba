// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An edited scene as plainly as can be, to compare a solver with.

#include <Eigen/Core>
#include <map>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

/// What an edited scene is made of. Edges are known by their vertices; what follows from live
/// tetrahedra (masses, constraints, surfaces, pieces) is not kept, so it cannot lag behind: see
/// model_difference.h.
struct LiveModel {
  explicit LiveModel(const Scene& scene);

  /// @param solver  before the edit, which it accepts
  void apply(const Solver& solver, const TopologyEdit& edit);

  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(points.size()); }
  [[nodiscard]] const Body& body_of_tet(Index tet) const { return bodies[tet_bodies[tet]]; }

  std::vector<Body> bodies;                // [body_count] as they came, also those that went
  std::vector<Eigen::Vector3d> points;     // [vertex_count] m, at rest
  std::vector<double> particle_masses;     // [vertex_count] kg, zero of all that are no particles
  std::vector<Index> vertex_bodies;        // [vertex_count]
  std::vector<bool> is_fixed;              // [vertex_count]
  std::vector<Tet> tets;                   // [tet_count]
  std::vector<bool> tet_alive;             // [tet_count]
  std::vector<Index> tet_bodies;           // [tet_count]
  std::vector<float> rest_volumes;         // [tet_count] m^3
  std::vector<float> stiffnesses;          // [tet_count] times that of the material
  std::vector<Fibre> fibres;               // [tet_count]
  std::vector<Triangle> triangles;         // [triangle_count]
  std::vector<bool> triangle_alive;        // [triangle_count]
  std::vector<Index> triangle_bodies;      // [triangle_count]
  std::vector<float> rest_areas;           // [triangle_count] m^2
  std::vector<float> sheet_stiffnesses;    // [triangle_count] times that of the material
  std::vector<Link> links;                 // [link_count]
  std::vector<bool> link_alive;            // [link_count] unless an end has lost its tissue
  std::vector<Hinge> hinges;               // [hinge_count]
  std::vector<bool> hinge_alive;           // [hinge_count]
  std::map<Edge, float> rest_lengths;      // m, of edges that are or were
  std::map<Edge, float> limits;            // m, the same where stretch is limited
  std::vector<Eigen::Vector3f> forces;     // [vertex_count] N
  std::vector<Eigen::Vector3f> gravities;  // [body_count] m/s^2
  Eigen::Vector3f gravity;                 // m/s^2, of bodies to come
  bool has_grown = false;                  // whether edits brought vertices or tetrahedra

 private:
  void add_bodies(const Scene& added);
  void remove_body(Index body);
  struct Element {  // that hinges may be of: a tetrahedron, or a triangle of a sheet
    std::vector<Index> corners;
    Index id;  // triangles behind tetrahedra, as far as numbers go
    bool is_alive;
  };
  [[nodiscard]] std::vector<Element> elements() const;
  using HingeOwners = std::array<Index, 2>;  // elements that have its triangles
  [[nodiscard]] std::vector<HingeOwners> hinge_owners() const;
  void follow_hinges(const std::vector<HingeOwners>& before, const TopologyEdit& edit,
                     Index first_new_vertex, Index first_new_tet);
  void change_volume(const RestVolumeChange& change);
  void move_corner(const CornerMove& move);
  void add_tet(const NewTet& tet, const TopologyEdit& edit, Index first_new_vertex);
};

/// An edge by its vertices, smaller first.
[[nodiscard]] Edge edge_between(Index a, Index b);

}  // namespace pbdsurg::testing
