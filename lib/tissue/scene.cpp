// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/check.h"
#include "lib/mesh/hinge_shape.h"
#include "lib/tissue/scene_checks.h"
#include "lib/tissue/sheet.h"

namespace pbdsurg {
namespace {

void check_stiffness(const std::string& what, const Stiffness& stiffness) {
  if (!(stiffness.fraction > 0) || !(stiffness.fraction <= 1)) {
    throw InvalidArgument(what + " fraction is " + std::to_string(stiffness.fraction) +
                          "; it must be in (0, 1]");
  }
  if (!(stiffness.compliance >= 0) || !(stiffness.compliance <= kLargestCompliance)) {
    throw InvalidArgument(what + " compliance is " + std::to_string(stiffness.compliance) +
                          "; it must be in [0, 1e12]");
  }
}

void check_material(const std::string& what, const Material& material) {
  if (material.model > ElasticModel::neo_hookean) {
    throw InvalidArgument(what + ": unknown model " +
                          std::to_string(static_cast<int>(material.model)));
  }
  check_stiffness(what + ": stretch", material.stretch);
  check_stiffness(what + ": volume", material.volume);
  if (!(material.youngs_modulus > 0) || !std::isfinite(material.youngs_modulus)) {
    throw InvalidArgument(what + ": youngs_modulus is " + std::to_string(material.youngs_modulus) +
                          " Pa; it must be positive and finite");
  }
  if (!(material.poissons_ratio >= 0) || !(material.poissons_ratio < 0.5F)) {
    throw InvalidArgument(what + ": poissons_ratio is " + std::to_string(material.poissons_ratio) +
                          "; it must be in [0, 0.5)");
  }
  if (!(material.damping >= 0) || !std::isfinite(material.damping)) {
    throw InvalidArgument(what + ": damping is " + std::to_string(material.damping) +
                          " s; it must be >= 0 and finite");
  }
  if (!(material.max_stretch > 1)) {
    throw InvalidArgument(what + ": max_stretch is " + std::to_string(material.max_stretch) +
                          "; it must be > 1, or infinite for no limit");
  }
}

// Beside its place on the surface.
// @param vertices  in range
void check_hinge(const std::string& what, const Hinge& hinge,
                 std::span<const Eigen::Vector3d> positions) {
  check_positive((what + ": its rigidity").c_str(), hinge.rigidity, " N m");
  Vec3<double> x[4];
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d& position = positions[hinge.vertices[i]];
    x[i] = {position.x(), position.y(), position.z()};
  }
  const double compliance = 1 / (hinge.rigidity * checked_hinge_shape(x, what, hinge.vertices));
  constexpr double kLeastCompliance = 1e-12;  // 1/(N m): stiffer than anything
  if (!(compliance >= kLeastCompliance && compliance <= kLargestCompliance)) {
    throw InvalidArgument(what + " has compliance " + describe(compliance) +
                          " 1/(N m); it must be in [1e-12, 1e12]");
  }
}

void check_sheet(const std::string& what, std::span<const Eigen::Vector3d> positions,
                 std::span<const Triangle> triangles) {
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) {
      throw InvalidArgument(what + ": the position of vertex " + std::to_string(v) + " is " +
                            describe(positions[v]) + " m; it must be finite");
    }
  }
  std::vector<std::pair<Triangle, std::size_t>> known;
  known.reserve(triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::string name = what + ": triangle " + std::to_string(t);
    Triangle sorted = triangles[t];
    std::ranges::sort(sorted);
    for (const Index v : sorted) {
      if (v < 0 || static_cast<std::size_t>(v) >= positions.size()) {
        throw InvalidArgument(name + " refers to vertex " + std::to_string(v) +
                              "; ids must be in [0, " + std::to_string(positions.size()) + ")");
      }
    }
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
      throw InvalidArgument(name + " has vertex " + std::to_string(*twice) +
                            " twice; its three vertices must differ");
    }
    double longest = 0;  // m^2
    for (int i = 0; i < 3; ++i) {
      longest =
          std::max(longest, (positions[sorted[i]] - positions[sorted[(i + 1) % 3]]).squaredNorm());
    }
    constexpr double kLeastShare = 1e-6;
    const double area = triangle_area(positions, sorted);
    if (!(area > kLeastShare * longest)) {
      throw InvalidArgument(name + " has " + describe(area) +
                            " m^2; it must be more than 1e-6 of the square of its longest edge, " +
                            describe(longest) + " m^2");
    }
    known.emplace_back(sorted, t);
  }
  std::ranges::sort(known);
  const auto twice =
      std::ranges::adjacent_find(known, {}, &std::pair<Triangle, std::size_t>::first);
  if (twice != known.end()) {
    throw InvalidArgument(what + ": triangles " + std::to_string(twice->second) + " and " +
                          std::to_string(std::next(twice)->second) +
                          " have the same vertices; each must have others");
  }
}

std::array<Index, 4> sorted_ends(std::array<Index, 4> hinge) {
  std::sort(hinge.begin(), hinge.begin() + 2);
  std::sort(hinge.begin() + 2, hinge.end());
  return hinge;
}

}  // namespace

void check_link(const std::string& what, const Link& link, Index vertex_count) {
  for (const Index v : {link.first, link.second}) {
    if (v < 0 || v >= vertex_count) {
      throw InvalidArgument(what + " refers to vertex " + std::to_string(v) +
                            "; ids must be in [0, " + std::to_string(vertex_count) + ")");
    }
  }
  if (link.first == link.second) {
    throw InvalidArgument(what + " joins vertex " + std::to_string(link.first) + " to itself");
  }
  if (!(link.rest_length >= 0) || !std::isfinite(link.rest_length)) {
    throw InvalidArgument(what + " has rest length " + std::to_string(link.rest_length) +
                          " m; it must be >= 0 and finite");
  }
  check_stiffness(what + ":", link.stiffness);
}

void check_stiffness_factor(const std::string& what, float factor) {
  if (!(factor >= kSmallestStiffness && factor <= kLargestStiffness)) {
    throw InvalidArgument(what + " is to be " + describe(factor) +
                          " times as stiff as its body's material; it must be in [" +
                          describe(kSmallestStiffness) + ", " + describe(kLargestStiffness) + "]");
  }
}

void check_fibre(const std::string& what, const Fibre& fibre) {
  constexpr float kNear = 1e-3F;
  const float length = fibre.direction.norm();
  if (!(std::abs(length - 1) <= kNear)) {
    throw InvalidArgument(what + ": the direction of its fibres has length " + describe(length) +
                          "; it must be 1");
  }
  if (!(fibre.stiffness >= 0) || !std::isfinite(fibre.stiffness)) {
    throw InvalidArgument(what + ": the stiffness of its fibres is " + describe(fibre.stiffness) +
                          " Pa; it must be >= 0 and finite");
  }
}

void check_takes_fibres(const std::string& what, const Body& body) {
  if (body.tet_count == 0 || body.material.model != ElasticModel::neo_hookean) {
    throw InvalidArgument(what + " of body '" + body.name +
                          "' cannot have fibres: only Neo-Hookean tetrahedra do");
  }
}

void check_has_moduli(const std::string& what, const Body& body) {
  if (body.tet_count == 0 || body.material.model != ElasticModel::neo_hookean) {
    throw InvalidArgument(what + " belongs to body '" + body.name +
                          "', which is not Neo-Hookean; only such tissue has moduli to scale");
  }
}

Body& Scene::append_body(std::string name, std::span<const Eigen::Vector3d> positions,
                         std::span<const double> masses, std::size_t tet_count,
                         const Material& material) {
  if (name.empty()) {
    throw InvalidArgument("a body needs a name");
  }
  if (std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.name == name; })) {
    throw InvalidArgument("there is a body named '" + name + "' already; names must differ");
  }
  constexpr std::size_t kMost = std::numeric_limits<Index>::max();
  if (positions_.size() + positions.size() > kMost || tets_.size() + tet_count > kMost) {
    throw InvalidArgument("body '" + name +
                          "' would take the scene beyond 2147483647 vertices or tetrahedra");
  }
  bodies_.push_back({std::move(name), material, vertex_count(),
                     static_cast<Index>(positions.size()), static_cast<Index>(tets_.size()),
                     static_cast<Index>(tet_count), static_cast<Index>(triangles_.size())});
  positions_.insert(positions_.end(), positions.begin(), positions.end());
  masses_.insert(masses_.end(), masses.begin(), masses.end());
  fixed_.resize(positions_.size(), false);
  return bodies_.back();
}

BodyId Scene::add_body(std::string name, const TetMesh& mesh, const Material& material) {
  check_material("body '" + name + "'", material);
  const Body& body =
      append_body(std::move(name), mesh.positions(), lumped_masses(mesh, material.density),
                  mesh.tets().size(), material);
  for (Tet tet : mesh.tets()) {
    for (Index& v : tet) {
      v += body.first_vertex;
    }
    tets_.push_back(tet);
  }
  stiffnesses_.resize(tets_.size(), 1);
  fibres_.resize(tets_.size());
  return BodyId(static_cast<Index>(bodies_.size()) - 1);
}

BodyId Scene::add_particles(std::string name, std::span<const Eigen::Vector3d> positions,
                            double mass) {
  if (!(mass > 0) || !std::isfinite(mass)) {
    throw InvalidArgument("body '" + name + "': particle mass is " + std::to_string(mass) +
                          " kg; it must be positive and finite");
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) {
      throw InvalidArgument("body '" + name + "': the position of particle " + std::to_string(v) +
                            " is not finite");
    }
  }
  append_body(std::move(name), positions, std::vector<double>(positions.size(), mass), 0, {});
  return BodyId(static_cast<Index>(bodies_.size()) - 1);
}

BodyId Scene::add_sheet(std::string name, std::span<const Eigen::Vector3d> positions,
                        std::span<const Triangle> triangles, const SheetMaterial& material) {
  Scene whole = *this;
  const BodyId id = whole.append_sheet(std::move(name), positions, triangles, material);
  whole.add_hinges(id, static_cast<float>(plate_rigidity(
                           material.youngs_modulus, material.thickness, material.poissons_ratio)));
  *this = std::move(whole);
  return id;
}

// Without hinges.
BodyId Scene::append_sheet(std::string name, std::span<const Eigen::Vector3d> positions,
                           std::span<const Triangle> triangles, const SheetMaterial& material) {
  const std::string what = "body '" + name + "'";
  check_positive((what + ": thickness").c_str(), material.thickness, " m");
  check_positive((what + ": density").c_str(), material.density, " kg/m^3");
  const Material solid{.density = material.density,
                       .youngs_modulus = material.youngs_modulus,
                       .poissons_ratio = material.poissons_ratio,
                       .damping = material.damping};
  check_material(what, solid);
  check_sheet(what, positions, triangles);
  if (triangles_.size() + triangles.size() > std::numeric_limits<Index>::max()) {
    throw InvalidArgument(what + " would take the scene beyond 2147483647 triangles");
  }
  Body& body =
      append_body(std::move(name), positions, std::vector<double>(positions.size(), 0), 0, solid);
  body.triangle_count = static_cast<Index>(triangles.size());
  body.thickness = material.thickness;
  for (Triangle triangle : triangles) {
    const double mass = triangle_mass(body, positions, triangle);
    for (Index& v : triangle) {
      v += body.first_vertex;
      masses_[v] += mass / 3;
    }
    triangles_.push_back(triangle);
  }
  triangle_stiffnesses_.resize(triangles_.size(), 1);
  return BodyId(static_cast<Index>(bodies_.size()) - 1);
}

void Scene::fix_vertices(Index body_index, std::span<const Index> vertices) {
  const Body& where = body(body_index);
  for (const Index v : vertices) {
    if (v < 0 || v >= where.vertex_count) {
      throw InvalidArgument("body '" + where.name + "' has no vertex " + std::to_string(v) +
                            "; ids must be in [0, " + std::to_string(where.vertex_count) + ")");
    }
  }
  for (const Index v : vertices) {
    fixed_[where.first_vertex + v] = true;
  }
}

void Scene::set_stiffnesses(Index body_index, std::span<const float> factors) {
  const Body& where = body(body_index);
  const bool has_triangles = is_sheet(where);
  if (!has_triangles) {
    check_has_moduli("the stiffness", where);
  }
  const Index count = has_triangles ? where.triangle_count : where.tet_count;
  if (factors.size() != static_cast<std::size_t>(count)) {
    throw InvalidArgument("body '" + where.name + "' has " + std::to_string(count) +
                          (has_triangles ? " triangles" : " tetrahedra") + " and got " +
                          std::to_string(factors.size()) + " stiffnesses; it needs one each");
  }
  for (std::size_t t = 0; t < factors.size(); ++t) {
    check_stiffness_factor(
        "body '" + where.name + "': " + (has_triangles ? "triangle " : "tet ") + std::to_string(t),
        factors[t]);
  }
  std::ranges::copy(factors, has_triangles ? triangle_stiffnesses_.begin() + where.first_triangle
                                           : stiffnesses_.begin() + where.first_tet);
}

void Scene::set_fibres(Index body_index, std::span<const Fibre> fibres) {
  const Body& where = body(body_index);
  check_takes_fibres("tissue", where);
  if (fibres.size() != static_cast<std::size_t>(where.tet_count)) {
    throw InvalidArgument("body '" + where.name + "' has " + std::to_string(where.tet_count) +
                          " tetrahedra and got " + std::to_string(fibres.size()) +
                          " fibres; it needs one each");
  }
  for (std::size_t t = 0; t < fibres.size(); ++t) {
    check_fibre("body '" + where.name + "': tet " + std::to_string(t), fibres[t]);
  }
  std::ranges::copy(fibres, fibres_.begin() + where.first_tet);
}

Index Scene::add_link(const Link& link) {
  const std::string what = "link " + std::to_string(links_.size());
  check_link(what, link, vertex_count());
  for (const Index v : {link.first, link.second}) {
    if (!(masses_[v] > 0)) {
      throw InvalidArgument(what + " refers to vertex " + std::to_string(v) +
                            ", which no tetrahedron has");
    }
  }
  links_.push_back(link);
  return static_cast<Index>(links_.size()) - 1;
}

void Scene::append(const Scene& other) {
  Scene both = *this;
  const Index first_vertex = vertex_count(), first_tet = static_cast<Index>(tets_.size());
  const std::size_t first_triangle = triangles_.size();
  for (const Body& body : other.bodies_) {
    const auto first = static_cast<std::size_t>(body.first_vertex);
    const auto count = static_cast<std::size_t>(body.vertex_count);
    Body& added = both.append_body(body.name, other.positions().subspan(first, count),
                                   other.masses().subspan(first, count),
                                   static_cast<std::size_t>(body.tet_count), body.material);
    added.triangle_count = body.triangle_count;
    added.thickness = body.thickness;
    const auto triangles = other.triangles().subspan(body.first_triangle, body.triangle_count);
    both.triangles_.insert(both.triangles_.end(), triangles.begin(), triangles.end());
    const auto factors =
        other.triangle_stiffnesses().subspan(body.first_triangle, body.triangle_count);
    both.triangle_stiffnesses_.insert(both.triangle_stiffnesses_.end(), factors.begin(),
                                      factors.end());
    for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
      both.tets_.push_back(other.tets_[t]);
      both.stiffnesses_.push_back(other.stiffnesses_[t]);
      both.fibres_.push_back(other.fibres_[t]);
    }
  }
  for (auto tet = both.tets_.begin() + first_tet; tet != both.tets_.end(); ++tet) {
    std::ranges::for_each(*tet, [&](Index& v) { v += first_vertex; });
  }
  for (Triangle& triangle : std::span(both.triangles_).subspan(first_triangle)) {
    std::ranges::for_each(triangle, [&](Index& v) { v += first_vertex; });
  }
  std::copy(other.fixed_.begin(), other.fixed_.end(), both.fixed_.begin() + first_vertex);
  for (Link link : other.links_) {
    link.first += first_vertex;
    link.second += first_vertex;
    both.links_.push_back(link);
  }
  for (Hinge hinge : other.hinges_) {
    std::ranges::for_each(hinge.vertices, [&](Index& v) { v += first_vertex; });
    both.hinges_.push_back(hinge);
  }
  *this = std::move(both);
}

Index Scene::add_hinge(const Hinge& hinge) {
  const std::string what = "hinge " + std::to_string(hinges_.size());
  const std::array<Index, 4>& v = hinge.vertices;
  for (std::size_t i = 0; i < 4; ++i) {
    if (v[i] < 0 || v[i] >= vertex_count()) {
      throw InvalidArgument(what + " refers to vertex " + std::to_string(v[i]) +
                            "; ids must be in [0, " + std::to_string(vertex_count()) + ")");
    }
    if (std::find(v.begin(), v.begin() + i, v[i]) != v.begin() + i) {
      throw InvalidArgument(what + " has vertex " + std::to_string(v[i]) +
                            " twice; its four vertices must differ");
    }
  }
  const auto body = std::upper_bound(bodies_.begin(), bodies_.end(), v[0],
                                     [](Index id, const Body& b) { return id < b.first_vertex; }) -
                    1;
  const auto tets = std::span<const Tet>(tets_).subspan(body->first_tet, body->tet_count);
  const auto triangles =
      std::span<const Triangle>(triangles_).subspan(body->first_triangle, body->triangle_count);
  for (const Index opposite : {v[2], v[3]}) {
    const auto has_triangle = [&](const auto& corners) {
      const auto has = [&](Index vertex) { return std::ranges::count(corners, vertex) > 0; };
      return has(v[0]) && has(v[1]) && has(opposite);
    };
    const auto count = std::ranges::count_if(tets, has_triangle);
    if (count != 1 && std::ranges::none_of(triangles, has_triangle)) {
      throw InvalidArgument(what + ": triangle (" + std::to_string(v[0]) + ", " +
                            std::to_string(v[1]) + ", " + std::to_string(opposite) +
                            ") belongs to " + std::to_string(count) + " tetrahedra of body '" +
                            body->name + "'; it must belong to one, on the surface");
    }
  }
  const auto same = std::ranges::find(hinges_, sorted_ends(v),
                                      [](const Hinge& each) { return sorted_ends(each.vertices); });
  if (same != hinges_.end()) {
    throw InvalidArgument(what + " joins the triangles of hinge " +
                          std::to_string(same - hinges_.begin()) +
                          "; two triangles have one hinge");
  }
  check_hinge(what, hinge, positions_);
  hinges_.push_back(hinge);
  return static_cast<Index>(hinges_.size()) - 1;
}

Index Scene::add_hinges(Index body_index, float rigidity) {
  const Body& where = body(body_index);
  if (where.tet_count == 0 && where.triangle_count == 0) {
    throw InvalidArgument("body '" + where.name +
                          "' has no tetrahedra and no triangles, and so no surface to hinge");
  }
  struct Side {
    Edge edge;       // smaller vertex first
    Index triangle;  // of the surface
    Index opposite;
    bool is_turned;  // the triangle has the larger vertex first
  };
  const auto sheet =
      std::span<const Triangle>(triangles_).subspan(where.first_triangle, where.triangle_count);
  std::vector<Triangle> surface(sheet.begin(), sheet.end());
  for (const BoundaryTriangle& triangle :
       find_boundary(std::span<const Tet>(tets_).subspan(where.first_tet, where.tet_count))) {
    surface.push_back(triangle.vertices);
  }
  std::vector<Side> sides;
  sides.reserve(3 * surface.size());
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Triangle& v = surface[t];
    for (int i = 0; i < 3; ++i) {
      const Index a = v[i], b = v[(i + 1) % 3];
      sides.push_back(
          {{std::min(a, b), std::max(a, b)}, static_cast<Index>(t), v[(i + 2) % 3], a > b});
    }
  }
  std::ranges::sort(sides, {},
                    [](const Side& side) { return std::pair(side.edge, side.triangle); });
  std::vector<std::array<Index, 4>> known;  // those with a hinge already
  for (const Hinge& hinge : hinges_) {
    known.push_back(sorted_ends(hinge.vertices));
  }
  std::ranges::sort(known);
  std::vector<Hinge> added;
  for (auto first = sides.begin(); first != sides.end();) {
    const auto end = std::find_if(first, sides.end(),
                                  [&](const Side& side) { return side.edge != first->edge; });
    if (end - first == 2) {
      const Side& left = first->is_turned ? first[1] : first[0];  // wound along the edge
      const Side& right = first->is_turned ? first[0] : first[1];
      added.push_back({{left.edge[0], left.edge[1], left.opposite, right.opposite}, rigidity});
      const std::string what = "the hinge at edge (" + std::to_string(left.edge[0]) + ", " +
                               std::to_string(left.edge[1]) + ")";
      check_hinge(what, added.back(), positions_);
      if (std::ranges::binary_search(known, sorted_ends(added.back().vertices))) {
        throw InvalidArgument(what + " joins triangles of body '" + where.name +
                              "' that have a hinge already; two triangles have one hinge");
      }
    }
    first = end;
  }
  hinges_.insert(hinges_.end(), added.begin(), added.end());
  return static_cast<Index>(added.size());
}

void Scene::set_gravity(const Eigen::Vector3f& gravity) {
  if (!gravity.allFinite()) {
    throw InvalidArgument("gravity must be finite");
  }
  gravity_ = gravity;
}

bool Scene::is_fixed(Index vertex) const {
  check_id("vertex", vertex, fixed_.size());
  return fixed_[vertex];
}

const Body& Scene::body(Index index) const {
  if (index < 0 || index >= static_cast<Index>(bodies_.size())) {
    throw InvalidArgument("there is no body " + std::to_string(index) + "; the scene has " +
                          std::to_string(bodies_.size()));
  }
  return bodies_[index];
}

BodyId Scene::find_body(const std::string& name) const {
  std::string known;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].name == name) {
      return BodyId(static_cast<Index>(b));
    }
    known += (b == 0 ? "" : ", ") + bodies_[b].name;
  }
  throw InvalidArgument("there is no body named '" + name + "'; the scene has: " + known);
}

}  // namespace pbdsurg
