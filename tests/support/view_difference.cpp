// SPDX-License-Identifier: Apache-2.0
// What follows edits beside the solver: surfaces, pieces, strands, heat.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/views/live_boundary.h"

#include "tests/support/model_difference.h"

namespace pbdsurg::testing {
namespace {

std::string mismatch(const char* what, std::size_t id) {
  return std::string(what) + " (" + std::to_string(id) + ")";
}

// A triangle from its smallest vertex on, which keeps its winding.
Triangle from_smallest(Triangle triangle) {
  std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
  return triangle;
}

// Sorted, with the tetrahedron that each bounds.
using Surface = std::vector<std::pair<Triangle, Index>>;

// Both sides.
Surface find_sides(const LiveModel& model, Index sheet) {
  Surface sides;
  for (std::size_t t = 0; t < model.triangles.size(); ++t) {
    if (model.triangle_alive[t] && model.triangle_bodies[t] == sheet) {
      const auto& [a, b, c] = model.triangles[t];
      sides.emplace_back(from_smallest({a, b, c}), static_cast<Index>(t));
      sides.emplace_back(from_smallest({a, c, b}), static_cast<Index>(t));
    }
  }
  std::ranges::sort(sides);
  return sides;
}

Surface find_surface(const LiveModel& model, Index body) {
  struct Face {
    Triangle sorted;
    Triangle vertices;
    Index tet;
  };
  std::vector<Face> faces;
  for (std::size_t t = 0; t < model.tets.size(); ++t) {
    if (model.tet_alive[t] && model.tet_bodies[t] == body) {
      const Tet& tet = model.tets[t];
      for (const auto& [a, b, c] : kTetTriangles) {
        const Triangle triangle{tet[a], tet[b], tet[c]};
        faces.push_back({triangle, from_smallest(triangle), static_cast<Index>(t)});
        std::ranges::sort(faces.back().sorted);
      }
    }
  }
  std::ranges::sort(faces, {}, &Face::sorted);
  Surface surface;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i].sorted == faces[i + 1].sorted) {
      ++i;  // within
    } else {
      surface.emplace_back(faces[i].vertices, faces[i].tet);
    }
  }
  std::ranges::sort(surface);
  return surface;
}

}  // namespace

std::string difference(const LiveModel& model, const LiveSurface& surface, const Solver& solver,
                       Index body) {
  Surface shown, found;
  for (std::size_t slot = 0; slot < surface.triangles().size(); ++slot) {
    if (surface.origins()[slot].tet != kInvalidIndex) {
      shown.emplace_back(from_smallest(surface.triangles()[slot]), surface.origins()[slot].tet);
    } else if (surface.triangles()[slot] != LiveSurface::kEmptyTriangle) {
      return mismatch("triangle in an empty slot", slot);
    }
  }
  for (const BoundaryTriangle& triangle : find_live_boundary(solver.tissue(), body)) {
    found.emplace_back(from_smallest(triangle.vertices), triangle.tet);
  }
  std::ranges::sort(shown);
  std::ranges::sort(found);
  if (solver.tissue().body(body).thickness > 0) {
    return shown == find_sides(model, body)
               ? ""
               : mismatch("live surface of sheet", static_cast<std::size_t>(body));
  }
  const Surface expected = find_surface(model, body);
  if (shown != expected) {
    return mismatch("live surface of body", static_cast<std::size_t>(body));
  }
  return found == expected ? "" : mismatch("boundary of body", static_cast<std::size_t>(body));
}

std::string difference(const LiveModel& model, const LivePieces& pieces) {
  std::vector<Tet> live;
  std::vector<Index> ids;
  for (std::size_t t = 0; t < model.tets.size(); ++t) {
    if (model.tet_alive[t]) {
      live.push_back(model.tets[t]);
      ids.push_back(static_cast<Index>(t));
    } else if (pieces.piece_of(static_cast<Index>(t)) != kInvalidIndex) {
      return mismatch("piece of a tet that is gone", t);
    }
  }
  const Components components = find_components(model.vertex_count(), live);
  std::map<Index, Index> piece_of, component_of;
  std::map<Index, std::vector<Index>> tets;  // by piece
  for (std::size_t i = 0; i < live.size(); ++i) {
    const Index component = components.of_vertex[live[i][0]];
    const Index piece = pieces.piece_of(ids[i]);
    if (piece_of.try_emplace(component, piece).first->second != piece ||
        component_of.try_emplace(piece, component).first->second != component ||
        pieces.body(piece) != model.tet_bodies[ids[i]]) {
      return mismatch("piece of tet", static_cast<std::size_t>(ids[i]));
    }
    tets[piece].push_back(ids[i]);
  }
  for (Index piece = 0; piece < pieces.count(); ++piece) {
    const std::vector<Index>& expected = tets[piece];
    const bool is_anchored = std::ranges::any_of(expected, [&](Index t) {
      return std::ranges::any_of(model.tets[t], [&](Index v) { return model.is_fixed[v]; });
    });
    if (pieces.tets(piece) != expected || pieces.is_anchored(piece) != is_anchored) {
      return mismatch("piece", static_cast<std::size_t>(piece));
    }
  }
  return {};
}

std::string difference(const LiveModel& model, const ConnectiveTissue& tissue,
                       const Solver& solver) {
  std::vector<int> losses(tissue.strands().size());
  for (const StrandEvent& event : tissue.events()) {
    ++losses[event.strand];
    if (solver.tissue().is_link_alive(event.link)) {
      return mismatch("strand that parted at a link which is there", losses.size());
    }
  }
  for (std::size_t s = 0; s < losses.size(); ++s) {
    const Strand& strand = tissue.strands()[s];
    bool is_whole = true;
    for (Index l = strand.first_link; l < strand.first_link + strand.link_count; ++l) {
      is_whole = is_whole && model.link_alive[l] &&
                 solver.tissue().has_tissue(model.links[l].first) &&
                 solver.tissue().has_tissue(model.links[l].second);
    }
    if (tissue.is_whole(static_cast<Index>(s)) != is_whole || losses[s] != (is_whole ? 0 : 1)) {
      return mismatch("strand", s);
    }
  }
  return {};
}

std::string difference(const LiveModel& model, const HeatField& field,
                       const ThermalProperties& tissue) {
  constexpr double kTimeStep = 0.02;  // s
  constexpr double kPower = 0.05;     // W
  const ThermalMesh& mesh = field.mesh();
  std::vector<Tet> live;
  for (std::size_t t = 0; t < model.tets.size(); ++t) {
    if (model.tet_alive[t] && mesh.tissue_of_element(static_cast<Index>(t)) != kInvalidIndex) {
      live.push_back(model.tets[t]);
    }
  }
  HeatField expected(TetMesh(model.points, live), tissue);
  HeatField actual = field;
  const std::vector<HeatSource> sources{{live.empty() ? 0 : live.front()[0], kPower},
                                        {live.empty() ? 0 : live.back()[3], kPower}};
  for (int i = 0; i < 3; ++i) {
    expected.step(kTimeStep, sources);
    actual.step(kTimeStep, sources);
  }
  // positions of new vertices are rounded otherwise here, and solutions have a tolerance
  const auto is_near = [](double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(b); };
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (!is_near(actual.capacity(v), expected.capacity(v)) ||
        !is_near(actual.temperatures()[v], expected.temperatures()[v])) {
      return mismatch("temperature at vertex", static_cast<std::size_t>(v));
    }
  }
  return is_near(actual.ledger().in, expected.ledger().in) ? "" : "heat delivered";
}

}  // namespace pbdsurg::testing
