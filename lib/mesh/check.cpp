// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/check.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "pbdsurg/mesh/quality.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/findings.h"
#include "lib/mesh/point_check.h"
#include "lib/mesh/repeated_elements.h"
#include "lib/mesh/surface_check.h"
#include "lib/mesh/surface_crossing.h"
#include "lib/mesh/tet_check.h"
#include "lib/mesh/welding.h"

namespace pbdsurg {
namespace {

constexpr Index kManyVertexTets = 60;  // the valence bounds the number of colours from below

/// Area of zero to rounding, judged against the longest side and the distance from the origin.
bool is_flat_triangle(std::span<const Eigen::Vector3d> points, const Triangle& triangle) {
  const Eigen::Vector3d& a = points[triangle[0]];
  const Eigen::Vector3d ab = points[triangle[1]] - a;
  const Eigen::Vector3d ac = points[triangle[2]] - a;
  const double longest = std::sqrt(std::max(ab.squaredNorm(), ac.squaredNorm()));
  const double farthest = a.cwiseAbs().maxCoeff();
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return !(ab.cross(ac).norm() > 4 * kEpsilon * longest * (farthest + longest));
}

class Examination {
 public:
  explicit Examination(const MeshData& mesh) : mesh_(mesh) {}

  MeshReport run() {
    report_.tets = static_cast<Index>(mesh_.tets.size());
    report_.triangles = static_cast<Index>(mesh_.triangles.size());
    if (find_points_in_use() && all_finite()) {
      report_.checked.emplace_back("ids and coordinates");
      find_repeated_points_in_use();
      find_repeated_elements();
      if (mesh_.tets.empty()) {
        examine_surface();
      } else {
        examine_tets();
      }
      describe_repeated_points();
      say_what_is_not_checked();
    } else {
      report_.not_checked.emplace_back("anything that needs sound ids and coordinates");
    }
    std::stable_sort(report_.findings.begin(), report_.findings.end(),
                     [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
    return std::move(report_);
  }

 private:
  template <class Element>
  std::vector<Index> mark_used(const std::vector<Element>& elements) {
    std::vector<Index> bad;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      for (const Index v : elements[e]) {
        if (v < 0 || static_cast<std::size_t>(v) >= mesh_.points.size()) {
          bad.push_back(static_cast<Index>(e));
          break;
        }
        used_[v] = true;
      }
    }
    return bad;
  }

  bool find_points_in_use() {
    used_.assign(mesh_.points.size(), false);
    const std::vector<Index> bad_triangles = mark_used(mesh_.triangles);
    if (!mesh_.tets.empty()) {
      used_.assign(mesh_.points.size(), false);
    }
    const std::vector<Index> bad_tets = mark_used(mesh_.tets);
    for (std::size_t v = 0; v < used_.size(); ++v) {
      if (used_[v]) {
        in_use_.push_back(static_cast<Index>(v));
      } else {
        unused_.push_back(static_cast<Index>(v));
      }
    }
    report_.vertices = static_cast<Index>(in_use_.size());
    report_.unreferenced = static_cast<Index>(unused_.size());
    add_finding(report_, Severity::error, "tets that refer to points that do not exist", bad_tets);
    add_finding(report_, Severity::error, "triangles that refer to points that do not exist",
                bad_triangles);
    if (mesh_.tets.empty() && mesh_.triangles.empty()) {
      add_finding(report_, Severity::error, "the mesh has neither tets nor triangles");
    }
    add_finding(report_, Severity::note, "points that no element uses", unused_);
    return bad_tets.empty() && bad_triangles.empty();
  }

  bool all_finite() {
    std::vector<Index> bad;
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      if (!mesh_.points[v].allFinite()) {
        bad.push_back(static_cast<Index>(v));
      }
    }
    add_finding(report_, Severity::error, "points that are not finite", bad);
    return bad.empty();
  }

  void find_repeated_points_in_use() {
    if (in_use_.empty()) {
      return;
    }
    Eigen::Vector3d low = mesh_.points[in_use_.front()];
    Eigen::Vector3d high = low;
    for (const Index v : in_use_) {
      low = low.cwiseMin(mesh_.points[v]);
      high = high.cwiseMax(mesh_.points[v]);
    }
    const double diagonal = (high - low).norm();
    repeated_ = find_repeated_points(mesh_.points, in_use_,
                                     std::isfinite(diagonal) ? kNearPoints * diagonal : 0);
    report_.duplicate_points = static_cast<Index>(repeated_.exact.size());
    report_.near_points = static_cast<Index>(repeated_.near.size());
    report_.checked.emplace_back("repeated points, triangles and tets");
  }

  void describe_repeated_points() {
    add_finding(report_, Severity::warning, "points exactly at the place of an earlier one",
                repeated_.exact);
    add_finding(report_, Severity::warning,
                "points within a millionth of the mesh's diagonal of an earlier one",
                repeated_.near);
    report_.welded_open_edges = report_.open_edges;
    report_.welded_components = report_.components;
    if (!repeated_.exact.empty() || !repeated_.near.empty()) {
      Welding welding(mesh_.points.size());
      welding.join(repeated_.exact);
      welding.join(repeated_.near);
      if (mesh_.tets.empty()) {
        describe_welding(welding(mesh_.triangles), mesh_.triangles, "triangles");
      } else {
        describe_welding(welding(mesh_.tets), mesh_.tets, "tets");
      }
    }
  }

  static std::vector<Triangle> boundary_of(const std::vector<Triangle>& triangles) {
    return triangles;
  }
  static std::vector<Triangle> boundary_of(const std::vector<Tet>& tets) {
    std::vector<Triangle> boundary;
    for (const BoundaryTriangle& triangle : find_boundary(tets)) {
      boundary.push_back(triangle.vertices);
    }
    return boundary;
  }

  /// What would be another number if the repeated points were one point each.
  template <class Element>
  void describe_welding(std::vector<Element> welded, std::vector<Element> stored,
                        const std::string& elements) {
    // as in report_.components, those that use a vertex twice count
    report_.welded_components =
        find_components(point_count(), std::span<const Element>(welded)).count;
    const auto flat_before = std::erase_if(stored, repeats_vertex<Element>);
    const auto flat_after = std::erase_if(welded, repeats_vertex<Element>);
    const std::vector<Triangle> boundary = boundary_of(welded);
    const SurfaceDefects defects = find_surface_defects(point_count(), boundary);
    report_.welded_open_edges = static_cast<Index>(defects.open_edges.size());

    std::string effects;
    const auto add_change = [&](const std::string& what, auto before, auto after) {
      if (static_cast<Index>(before) != static_cast<Index>(after)) {
        effects += (effects.empty() ? "" : ", ") + what + " " + std::to_string(before) + " -> " +
                   std::to_string(after);
      }
    };
    add_change("parts", report_.components, report_.welded_components);
    add_change("open edges", report_.open_edges, report_.welded_open_edges);
    add_change("edges with three or more triangles", report_.overshared_edges,
               static_cast<Index>(defects.overshared_edges.size()));
    if (!mesh_.tets.empty()) {
      add_change("boundary triangles", report_.boundary_triangles,
                 static_cast<Index>(boundary.size()));
    }
    add_change(elements + " that use a vertex twice", flat_before, flat_after);
    add_change(elements + " that repeat another", find_repeated(stored).size(),
               find_repeated(welded).size());
    add_finding(report_, Severity::note,
                "welding the repeated points would change " +
                    (effects.empty() ? "nothing but their number" : effects));
  }

  void say_what_is_not_checked() {
    if (mesh_.tets.empty()) {
      report_.not_checked.emplace_back("whether parts are too thin to be filled");
    } else {
      report_.not_checked.emplace_back("overlaps of tets whose boundary does not cross itself");
      if (!mesh_.triangles.empty()) {
        report_.not_checked.emplace_back("triangles stored beside the tets, but for repeated ones");
      }
    }
    report_.not_checked.emplace_back("whether one part lies inside another");
  }

  void find_repeated_elements() {
    const auto tets = find_repeated(mesh_.tets);
    const auto triangles = find_repeated(mesh_.triangles);
    report_.duplicate_tets = static_cast<Index>(tets.size());
    report_.duplicate_triangles = static_cast<Index>(triangles.size());
    add_finding(report_, Severity::error, "tets that repeat an earlier one", tets);
    // beside tetrahedra, stored triangles are not simulated
    add_finding(report_, mesh_.tets.empty() ? Severity::warning : Severity::note,
                "triangles that repeat an earlier one", triangles);
  }

  // --- tetrahedra ---

  void examine_tets() {
    std::vector<Tet> proper;  // topology makes sense for four different vertices only
    std::vector<Index> twice;
    for (std::size_t t = 0; t < mesh_.tets.size(); ++t) {
      if (repeats_vertex(mesh_.tets[t])) {
        twice.push_back(static_cast<Index>(t));
      } else {
        proper.push_back(mesh_.tets[t]);
      }
    }
    add_finding(report_, Severity::error, "tets that use a vertex twice", twice);
    measure_tets(mesh_, twice.size(), report_);

    const std::vector<Edge> edges = find_edges(proper);
    report_.edges = static_cast<Index>(edges.size());
    measure_edges(edges);
    count_faces(proper, report_);
    examine_boundary(boundary_of(proper));
    report_.checked.emplace_back("volumes, angles and faces of tets");
    set_euler();
    const Components parts = find_components(point_count(), std::span<const Tet>(mesh_.tets));
    report_.components = parts.count;
    describe_components();
    const std::vector<Index> counts = count_vertex_tets(point_count(), mesh_.tets);
    report_.max_vertex_tets = *std::max_element(counts.begin(), counts.end());
    if (report_.max_vertex_tets > kManyVertexTets) {
      const auto at = std::max_element(counts.begin(), counts.end()) - counts.begin();
      add_finding(report_, Severity::note,
                  std::to_string(report_.max_vertex_tets) + " tets meet at vertex " +
                      std::to_string(at) + "; so many need as many colours at least");
    }
  }

  // --- boundary and surfaces ---

  void examine_surface() {
    std::vector<Triangle> proper;
    std::vector<Index> flat;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Triangle& triangle = mesh_.triangles[t];
      const bool twice = repeats_vertex(triangle);
      if (twice || is_flat_triangle(mesh_.points, triangle)) {
        flat.push_back(static_cast<Index>(t));
      }
      if (!twice) {
        proper.push_back(triangle);
      }
    }
    report_.flat_triangles = static_cast<Index>(flat.size());
    add_finding(report_, Severity::warning, "triangles without area", flat);
    report_.faces = static_cast<Index>(proper.size());
    const SurfaceDefects defects = examine_boundary(proper);
    report_.boundary_triangles = report_.triangles;
    report_.edges = defects.edge_count;
    set_euler();
    report_.badly_wound_edges = static_cast<Index>(defects.badly_wound_edges.size());
    add_finding(report_, Severity::warning,
                "edges that both of their triangles run in one direction (badly wound)",
                defects.badly_wound_edges);
    report_.components =
        find_components(point_count(), std::span<const Triangle>(mesh_.triangles)).count;
    if (!mesh_.triangles.empty()) {
      describe_components();
      add_finding(report_, Severity::note,
                  "the mesh is a surface; to simulate it, fill it with tets");
      measure_enclosed_volume();
    }
  }

  void measure_enclosed_volume() {
    if (!report_.closed) {
      return;
    }
    // from a point of the surface, which keeps the cones short
    const Eigen::Vector3d apex = mesh_.points[mesh_.triangles.front()[0]];
    double sum = 0;
    for (const Triangle& t : mesh_.triangles) {
      const Eigen::Vector3d a = mesh_.points[t[0]] - apex;
      const Eigen::Vector3d b = mesh_.points[t[1]] - apex;
      sum += a.cross(b).dot(mesh_.points[t[2]] - apex) / 6;
    }
    report_.volume = std::abs(sum);
    report_.inside_out = sum < 0 && report_.badly_wound_edges == 0;
    if (report_.inside_out) {
      add_finding(report_, Severity::warning,
                  "the surface is inside out: its normals point inwards");
    }
  }

  SurfaceDefects examine_boundary(const std::vector<Triangle>& boundary) {
    SurfaceDefects defects = find_surface_defects(point_count(), boundary);
    report_.boundary_triangles = static_cast<Index>(boundary.size());
    report_.shells = defects.shell_count;
    report_.open_edges = static_cast<Index>(defects.open_edges.size());
    report_.overshared_edges = static_cast<Index>(defects.overshared_edges.size());
    report_.pinched_vertices = static_cast<Index>(defects.pinched_vertices.size());
    report_.closed =
        !boundary.empty() && defects.open_edges.empty() && defects.overshared_edges.empty();
    add_finding(report_, Severity::warning, "open edges of the surface (one triangle only)",
                defects.open_edges);
    add_finding(report_, Severity::warning, "edges of the surface with three or more triangles",
                defects.overshared_edges);
    add_finding(report_, Severity::warning, "pinched vertices, where the surface touches itself",
                defects.pinched_vertices);
    report_.checked.emplace_back("edges and vertices of the surface");
    find_self_crossings(boundary);

    std::vector<bool> on_boundary(mesh_.points.size(), false);
    std::vector<Edge> edges;
    for (const Triangle& t : boundary) {
      report_.area += (mesh_.points[t[1]] - mesh_.points[t[0]])
                          .cross(mesh_.points[t[2]] - mesh_.points[t[0]])
                          .norm() /
                      2;
      for (std::size_t i = 0; i < 3; ++i) {
        on_boundary[t[i]] = true;
        edges.push_back({t[i], t[(i + 1) % 3]});
      }
    }
    report_.boundary_vertices =
        static_cast<Index>(std::count(on_boundary.begin(), on_boundary.end(), true));
    if (mesh_.tets.empty()) {
      measure_edges(edges);
    }
    return defects;
  }

  void find_self_crossings(const std::vector<Triangle>& boundary) {
    Welding places(mesh_.points.size());
    places.join(repeated_.exact);
    const SurfaceCrossings crossings = find_surface_crossings(mesh_.points, places(boundary));
    report_.self_crossings = static_cast<Index>(crossings.pairs.size());
    std::vector<std::pair<Triangle, Triangle>> pairs;
    for (const auto& [a, b] : crossings.pairs) {
      pairs.emplace_back(boundary[a], boundary[b]);
    }
    add_finding(
        report_, Severity::warning,
        "pairs of triangles that cross, fold onto each other or touch without a common corner",
        pairs);
    if (crossings.complete) {
      report_.checked.push_back("self-crossings of the surface's " +
                                std::to_string(boundary.size()) + " triangles");
    } else if (crossings.pairs.size() >= kMostCrossings) {
      report_.not_checked.push_back("more self-crossings: the search ends with " +
                                    std::to_string(kMostCrossings));
    } else {
      report_.not_checked.emplace_back("more self-crossings: too many triangles lie in one place");
    }
  }

  void measure_edges(const std::vector<Edge>& edges) {
    if (edges.empty()) {
      return;
    }
    const std::vector<double> lengths = edge_lengths(mesh_.points, edges);
    const auto [shortest, longest] = std::minmax_element(lengths.begin(), lengths.end());
    report_.shortest_edge = *shortest;
    report_.longest_edge = *longest;
  }

  void set_euler() {
    report_.euler = report_.vertices - report_.edges + report_.faces - report_.tets;
  }

  void describe_components() {
    if (report_.components > 1) {
      add_finding(
          report_, Severity::note,
          "the mesh has " + std::to_string(report_.components) + " parts without common vertices");
    }
    if (report_.shells > report_.components) {
      add_finding(report_, Severity::note,
                  "the boundary has " + std::to_string(report_.shells) + " closed shells for " +
                      std::to_string(report_.components) +
                      (report_.components == 1 ? " part" : " parts") +
                      ": the mesh is hollow, or touches itself");
    }
  }

  [[nodiscard]] Index point_count() const { return static_cast<Index>(mesh_.points.size()); }

  const MeshData& mesh_;
  MeshReport report_;
  std::vector<bool> used_;
  std::vector<Index> in_use_;
  std::vector<Index> unused_;
  RepeatedPoints repeated_;
};

}  // namespace

const char* name_of(Severity severity) {
  switch (severity) {
    case Severity::note:
      return "note";
    case Severity::warning:
      return "warning";
    case Severity::error:
      return "error";
  }
  return "";
}

bool MeshReport::has_errors() const {
  return !findings.empty() && findings.front().severity == Severity::error;
}

MeshReport check_mesh(const MeshData& mesh) {
  return Examination(mesh).run();
}

}  // namespace pbdsurg
