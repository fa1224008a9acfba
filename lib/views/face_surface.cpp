// SPDX-License-Identifier: Apache-2.0
#include "lib/views/face_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "pbdsurg/mesh/topology.h"

namespace pbdsurg {
namespace {

struct IsBefore {
  bool operator()(const TetFace& a, const TetFace& b) const noexcept { return is_before(a, b); }
};

bool has_corner(const Tet& tet, Index vertex) {
  return std::ranges::find(tet, vertex) != tet.end();
}

// Of a face, the corner that an edge of it leaves out.
Index third_corner(const Tissue& tissue, const FaceEdge& edge) {
  for (const Index v : corners_of(tissue, edge.face)) {
    if (v != edge.from && v != edge.to) {
      return v;
    }
  }
  return kInvalidIndex;
}

bool runs_along(const Triangle& corners, Index from, Index to) {
  for (int i = 0; i < 3; ++i) {
    if (corners[i] == from && corners[(i + 1) % 3] == to) {
      return true;
    }
  }
  return false;
}

// In [0, 2 pi): how far a face has to turn around its edge, through the outside, to lie on another.
double angle_between(const Tissue& tissue, const FaceEdge& edge, const FaceEdge& other) {
  const auto x = tissue.rest_positions();
  const Eigen::Vector3d axis = (x[edge.to] - x[edge.from]).normalized();
  const auto away = [&](const FaceEdge& each) -> Eigen::Vector3d {
    const Eigen::Vector3d way = x[third_corner(tissue, each)] - x[edge.from];
    return (way - way.dot(axis) * axis).normalized();
  };
  const Eigen::Vector3d own = away(edge), out = axis.cross(own), its = away(other);
  constexpr double kRounding = 1e-9;  // of faces that lie on each other where tissue has parted
  const double angle = std::atan2(its.dot(out), its.dot(own));
  return angle < -kRounding ? angle + 2 * std::numbers::pi : std::max(angle, 0.0);
}

// Across an edge of a bare face: the bare face that runs back along it.
FaceEdge across(const Tissue& tissue, const FaceEdge& edge) {
  FaceEdge best{kInvalidIndex, kInvalidIndex, {}};
  double least = 0;
  for (const Index t : tissue.tets_at(edge.from)) {
    if (!has_corner(tissue.tets()[t], edge.to)) {
      continue;
    }
    for (Index f = 0; f < 4; ++f) {
      const FaceEdge back{edge.to, edge.from, {t, f}};
      if (!runs_along(corners_of(tissue, back.face), back.from, back.to) ||
          !is_bare(tissue, back.face)) {
        continue;
      }
      const double angle = angle_between(tissue, edge, back);
      if (best.from == kInvalidIndex || angle < least) {
        best = back;
        least = angle;
      }
    }
  }
  return best;
}

}  // namespace

Triangle corners_of(const Tissue& tissue, const TetFace& face) {
  const Tet& tet = tissue.tets()[face.tet];
  const auto& places = kTetTriangles[face.face];
  return {tet[places[0]], tet[places[1]], tet[places[2]]};
}

bool is_bare(const Tissue& tissue, const TetFace& face) {
  const Triangle corners = corners_of(tissue, face);
  return std::ranges::none_of(tissue.tets_at(corners[0]), [&](Index t) {
    const Tet& tet = tissue.tets()[t];
    return t != face.tet && has_corner(tet, corners[1]) && has_corner(tet, corners[2]);
  });
}

std::vector<FaceEdge> free_edges(const Tissue& tissue, const std::vector<TetFace>& faces) {
  std::vector<FaceEdge> edges;
  for (const TetFace& face : faces) {
    const Triangle corners = corners_of(tissue, face);
    for (int i = 0; i < 3; ++i) {
      edges.push_back({corners[i], corners[(i + 1) % 3], face});
    }
  }
  const auto ends = [](const FaceEdge& edge) {
    return std::pair(std::min(edge.from, edge.to), std::max(edge.from, edge.to));
  };
  std::ranges::sort(edges, [&](const FaceEdge& a, const FaceEdge& b) {
    return ends(a) != ends(b) ? ends(a) < ends(b) : is_before(a.face, b.face);
  });
  std::vector<FaceEdge> free;
  for (auto first = edges.begin(); first != edges.end();) {
    const auto end = std::find_if(first, edges.end(),
                                  [&](const FaceEdge& edge) { return ends(edge) != ends(*first); });
    const auto is_forward = [](const FaceEdge& edge) { return edge.from < edge.to; };
    const auto forward = std::count_if(first, end, is_forward);
    auto surplus = 2 * forward - (end - first);  // of those that run forward
    for (; first != end; ++first) {
      const int sign = is_forward(*first) ? 1 : -1;
      if (surplus * sign > 0) {
        free.push_back(*first);
        surplus -= sign;
      }
    }
  }
  return free;
}

std::vector<TetFace> closed_surface(const Tissue& tissue, std::vector<TetFace> faces) {
  std::vector<FaceEdge> waiting = free_edges(tissue, faces);
  std::set<TetFace, IsBefore> all(faces.begin(), faces.end());
  while (!waiting.empty()) {
    const FaceEdge next = across(tissue, waiting.back());
    waiting.pop_back();
    if (next.from == kInvalidIndex || !all.insert(next.face).second) {
      continue;
    }
    const Triangle corners = corners_of(tissue, next.face);
    for (int i = 0; i < 3; ++i) {
      if (corners[i] != next.from) {
        waiting.push_back({corners[i], corners[(i + 1) % 3], next.face});
      }
    }
  }
  return {all.begin(), all.end()};
}

double enclosed_volume(const Tissue& tissue, const std::vector<TetFace>& faces) {
  if (faces.empty()) {
    return 0;
  }
  const auto x = tissue.rest_positions();
  const Eigen::Vector3d origin = x[corners_of(tissue, faces.front())[0]];
  double sum = 0;
  for (const TetFace& face : faces) {
    const Triangle corners = corners_of(tissue, face);
    sum += (x[corners[0]] - origin).dot((x[corners[1]] - origin).cross(x[corners[2]] - origin));
  }
  return sum / 6;
}

}  // namespace pbdsurg
