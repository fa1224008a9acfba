// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is simulated: bodies, materials, fixed vertices, links between bodies, gravity.

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/material.h"

namespace pbdsurg {

struct SceneRecord;
struct TissueData;

/// A body's place in the numbering that all bodies of a scene share.
struct Body {
  std::string name;          ///< unlike that of any other body
  Material material;         ///< of all its tetrahedra, or of the sheet
  Index first_vertex = 0;    ///< the others follow
  Index vertex_count = 0;    ///< those that it came with
  Index first_tet = 0;       ///< the others follow
  Index tet_count = 0;       ///< those that it came with; of particles and sheets 0
  Index first_triangle = 0;  ///< of a sheet; the others follow
  Index triangle_count = 0;  ///< those that it came with; 0 of all that is no sheet
  float thickness = 0;       ///< m, of a sheet; else 0
};

/// A distance constraint between two vertices of the scene that no tetrahedron joins: connective
/// tissue, a strand of a membrane, a suture.
struct Link {
  Index first = kInvalidIndex;   ///< scene vertex
  Index second = kInvalidIndex;  ///< scene vertex
  float rest_length = 0;         ///< m, >= 0
  Stiffness stiffness;           ///< compliance in m/N
};

/// Two triangles of a body's surface, or of a sheet, that share an edge and resist a change of the
/// angle between them: a capsule or serosa that is stiffer than the tissue below, or the bending of
/// a sheet. See constraints/bending.h.
struct Hinge {
  std::array<Index, 4> vertices{};  ///< scene vertices: the ends of the edge, then one a triangle
  float rigidity = 0;               ///< N m, the flexural rigidity of the plate that it is part of
};

/// A scene description. Solvers copy what they need: a scene may be changed or dropped afterwards.
///
/// Vertices, tetrahedra, triangles, links and hinges have one numbering across all bodies, in the
/// order in which they were added; a body's local vertex v is scene vertex body(b).first_vertex +
/// v.
class PBDSURG_API Scene {
 public:
  /// Adds a body at rest.
  /// @throws InvalidArgument  if the name is empty or taken, a material value is out of range, or
  ///                          the scene would exceed 2^31 - 1 vertices or tetrahedra
  BodyId add_body(std::string name, const TetMesh& mesh, const Material& material = {});

  /// Adds a body of particles without tetrahedra, to be joined by links: a thread, a strand.
  /// @param positions  [n] m
  /// @param mass       kg of each particle, positive
  /// @throws InvalidArgument  as add_body(), or naming the particle that is not finite
  BodyId add_particles(std::string name, std::span<const Eigen::Vector3d> positions, double mass);

  /// Adds a sheet at rest: a body of triangles with a thickness, which resists stretch as a
  /// membrane and bending by a hinge at every edge of two triangles. Each corner of a triangle has
  /// a third of its mass. Sheets share no vertex with other bodies; links join them. Cost: O(T log
  /// T).
  /// @param positions  [n] m
  /// @param triangles  [triangle_count] ids in [0, n), wound alike where a side is to be known
  /// @throws InvalidArgument  if the name is empty or taken, a value of the material is out of
  ///                          range, or naming the vertex that is not finite, the triangle that
  ///                          names a vertex out of range or twice, has next to no area or is there
  ///                          twice, or the hinge whose compliance is out of [1e-12, 1e12]
  ///                          1/(N m); then nothing has changed
  BodyId add_sheet(std::string name, std::span<const Eigen::Vector3d> positions,
                   std::span<const Triangle> triangles, const SheetMaterial& material = {});

  /// Holds vertices of a body where they are, until an edit lets them go.
  /// @param vertices  [n] ids within the body
  /// @throws InvalidArgument  naming the body and the id out of range; then none is fixed
  void fix_vertices(Index body, std::span<const Index> vertices);

  /// Fixes the vertices of a body whose rest position satisfies a condition.
  /// @param condition  bool(const Eigen::Vector3d& position), position in m
  /// @return           how many were fixed
  template <class Condition>
  Index fix_where(Index body, Condition condition);

  /// Makes a Neo-Hookean body, or a sheet, stiffer in some places than in others, in place of what
  /// was set before. A hinge of a sheet is as many times as stiff as its two triangles in the mean.
  /// @param factors  [tet_count of the body, or triangle_count of the sheet] how many times as
  ///                 stiff as the body's material each tetrahedron or triangle is, in
  ///                 [kSmallestStiffness, kLargestStiffness]
  /// @throws InvalidArgument  naming the body that is neither, or the tetrahedron or triangle and
  ///                          its factor, or if the sizes differ; then nothing has changed
  void set_stiffnesses(Index body, std::span<const float> factors);

  /// Gives the tetrahedra of a Neo-Hookean body fibres, in place of those that they had. Compliance
  /// mode only.
  /// @param fibres  [tet_count of the body]
  /// @throws InvalidArgument  naming the body that is not Neo-Hookean, or the tetrahedron whose
  ///                          direction has not the length 1 or whose stiffness is negative or not
  ///                          finite, or if the sizes differ; then nothing has changed
  void set_fibres(Index body, std::span<const Fibre> fibres);

  /// Links two vertices of the scene.
  /// @return  the link's index
  /// @throws InvalidArgument  naming the vertex that is out of range or has no tissue, or if both
  ///                          are the same or a value is out of range
  Index add_link(const Link& link);

  /// Hinges two neighbouring triangles of a body's surface, or of a sheet, whose own hinges are
  /// there already. Cost: O(tetrahedra and triangles of the body + hinges).
  /// @return  the hinge's index
  /// @throws InvalidArgument  naming the hinge and what is wrong with it: a vertex out of range or
  ///                          listed twice, a triangle that is not on the surface of a body, nor of
  ///                          a sheet, or has
  ///                          a hinge over that edge to the same neighbour already, or has next to
  ///                          no height over the edge; a rigidity that is not positive and finite,
  ///                          or gives a compliance out of [1e-12, 1e12] 1/(N m)
  Index add_hinge(const Hinge& hinge);

  /// Hinges all neighbouring triangles of a body's surface, rims and both faces of a thin body
  /// included: at every edge of two such triangles. Edges where more than two meet get none.
  /// Cost: O(T log T).
  ///
  /// Projections bring stiff or damped hinges to rest slowly, and no report measures them: compare
  /// with the vertex-block method, or with more substeps.
  /// @param rigidity  N m, flexural_rigidity() of constraints/bending.h: a capsule of 0.1 mm and
  ///                  1 MPa has 1e-7
  /// @return          how many were added
  /// @throws InvalidArgument  as add_hinge(), or if the body has neither tetrahedra nor triangles;
  ///                          then none is added
  Index add_hinges(Index body, float rigidity);

  /// Acceleration of free vertices, m/s^2. Default: earth's, downwards along y.
  /// @throws InvalidArgument  if it is not finite
  void set_gravity(const Eigen::Vector3f& gravity);
  /// m/s^2
  [[nodiscard]] const Eigen::Vector3f& gravity() const noexcept { return gravity_; }

  /// [body_count] in the order in which they were added.
  [[nodiscard]] std::span<const Body> bodies() const noexcept { return bodies_; }

  /// @throws InvalidArgument  naming the index and how many bodies there are
  [[nodiscard]] const Body& body(Index index) const;

  /// @throws InvalidArgument  naming the bodies that there are
  [[nodiscard]] BodyId find_body(const std::string& name) const;

  /// Adds all bodies of another scene, behind its own, their links and hinges. Gravity stays.
  /// @throws InvalidArgument  as add_body(); then nothing has changed
  void append(const Scene& other);

  /// Of all bodies.
  [[nodiscard]] Index vertex_count() const noexcept {
    return static_cast<Index>(positions_.size());
  }

  /// [vertex_count] m, at rest.
  [[nodiscard]] std::span<const Eigen::Vector3d> positions() const noexcept { return positions_; }

  /// [vertex_count] kg, lumped; zero for a vertex that no tetrahedron or triangle uses, which then
  /// never moves.
  [[nodiscard]] std::span<const double> masses() const noexcept { return masses_; }

  /// Whether a vertex was fixed.
  /// @throws InvalidArgument  naming the vertex out of range
  [[nodiscard]] bool is_fixed(Index vertex) const;

  /// [tet_count] scene vertex ids.
  [[nodiscard]] std::span<const Tet> tets() const noexcept { return tets_; }

  /// [triangle_count] of sheets, scene vertex ids.
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept { return triangles_; }

  /// [tet_count] see set_stiffnesses(); 1 where nothing was set.
  [[nodiscard]] std::span<const float> stiffnesses() const noexcept { return stiffnesses_; }

  /// [triangle_count] likewise.
  [[nodiscard]] std::span<const float> triangle_stiffnesses() const noexcept {
    return triangle_stiffnesses_;
  }

  /// [tet_count] see set_fibres(); of no stiffness where nothing was set.
  [[nodiscard]] std::span<const Fibre> fibres() const noexcept { return fibres_; }

  /// [link_count]
  [[nodiscard]] std::span<const Link> links() const noexcept { return links_; }

  /// [hinge_count]
  [[nodiscard]] std::span<const Hinge> hinges() const noexcept { return hinges_; }

 private:
  friend Scene scene_of(const TissueData& data);  // which fills it
  friend Scene scene_of(const SceneRecord& record);

  Body& append_body(std::string name, std::span<const Eigen::Vector3d> positions,
                    std::span<const double> masses, std::size_t tet_count,
                    const Material& material);

  BodyId append_sheet(std::string name, std::span<const Eigen::Vector3d> positions,
                      std::span<const Triangle> triangles, const SheetMaterial& material);

  std::vector<Body> bodies_;
  std::vector<Eigen::Vector3d> positions_;
  std::vector<double> masses_;
  std::vector<bool> fixed_;
  std::vector<Tet> tets_;
  std::vector<Triangle> triangles_;
  std::vector<float> stiffnesses_, triangle_stiffnesses_;
  std::vector<Fibre> fibres_;
  std::vector<Link> links_;
  std::vector<Hinge> hinges_;
  Eigen::Vector3f gravity_{0, -9.81F, 0};
};

template <class Condition>
Index Scene::fix_where(Index body_index, Condition condition) {
  const Body& where = body(body_index);
  std::vector<Index> vertices;
  for (Index v = 0; v < where.vertex_count; ++v) {
    if (condition(positions_[where.first_vertex + v])) {
      vertices.push_back(v);
    }
  }
  fix_vertices(body_index, vertices);
  return static_cast<Index>(vertices.size());
}

}  // namespace pbdsurg
