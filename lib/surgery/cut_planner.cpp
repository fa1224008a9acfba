// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/cut_planner.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/surgery/cut_geometry.h"
#include "lib/surgery/cut_neighborhood.h"
#include "lib/surgery/cut_pieces.h"
#include "lib/surgery/cut_surface.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

// A vertex of one of the parts that a vertex is split into.
struct Part {
  Index vertex;
  Index holder;  // the vertex itself, or a copy
  int side;
};

struct PartedFace {
  Triangle vertices;
  std::array<Index, 2> pieces;  // on either side
};

class CutPlanner {
 public:
  CutPlanner(const CutNeighborhood& near, const CutSides& sides, const CutPieces& cut)
      : near_(near),
        geometry_(near, sides, cut.splits),
        split_edges_(cut.split_edges),
        pieces_(cut.pieces),
        vertex_count_(static_cast<Index>(near.positions.size())) {
    edit_.new_vertices = cut.splits;
  }

  CutPlan plan() {
    sort_front();
    part_faces();
    split_vertices();
    write_pieces();
    move_links();
    return {std::move(edit_), remaining_front()};
  }

 private:
  void sort_front() {
    front_ = near_.front.closed_faces;
    for (Triangle& face : front_) {
      std::sort(face.begin(), face.end());
    }
    std::sort(front_.begin(), front_.end());
  }

  [[nodiscard]] bool is_parted(const Triangle& face, const CutPiece& a, const CutPiece& b) const {
    if (a.side * b.side >= 0) {
      return false;
    }
    if (a.tet == b.tet) {
      return true;
    }
    if (!std::ranges::all_of(face,
                             [&](Index v) { return v >= vertex_count_ || near_.is_reached[v]; })) {
      return false;
    }
    const std::array<Vector3d, 3> x{geometry_.position(face[0]), geometry_.position(face[1]),
                                    geometry_.position(face[2])};
    return geometry_.surface_is_at(
        mean(x), std::max(geometry_.longest_edge(a.corners), geometry_.longest_edge(b.corners)));
  }

  // Whether a face, or the one that it is a part of, was parted before and stayed closed. The whole
  // has the vertices themselves and the ends of edges that others split.
  [[nodiscard]] bool is_on_front(const Triangle& face) const {
    if (front_.empty()) {
      return false;
    }
    Triangle whole;
    int count = 0;
    const auto add = [&](Index v) {
      const auto end = whole.begin() + std::min(count, 3);
      if (std::find(whole.begin(), end, v) == end) {
        if (count < 3) {
          whole[count] = v;
        }
        ++count;
      }
    };
    for (const Index v : face) {
      if (v < vertex_count_) {
        add(v);
      } else {
        std::ranges::for_each(split_edges_[v - vertex_count_], add);
      }
    }
    std::sort(whole.begin(), whole.end());
    return count == 3 && std::ranges::binary_search(front_, whole);
  }

  // [vertices, splits included] with pieces on both sides, or on the front: only there faces part
  [[nodiscard]] std::vector<bool> vertices_between() const {
    const std::size_t all = near_.positions.size() + split_edges_.size();
    std::vector<bool> above(all, false), below(all, false);
    for (const CutPiece& piece : pieces_) {
      for (const Index v : piece.corners) {
        above[v] = above[v] || piece.side > 0;
        below[v] = below[v] || piece.side < 0;
      }
    }
    for (std::size_t v = 0; v < all; ++v) {
      above[v] = above[v] && below[v];
    }
    for (const Triangle& face : front_) {
      for (const Index v : face) {
        above[v] = true;
      }
    }
    for (std::size_t e = 0; e < split_edges_.size(); ++e) {
      above[vertex_count_ + e] =
          above[vertex_count_ + e] || (above[split_edges_[e][0]] && above[split_edges_[e][1]]);
    }
    return above;
  }

  // Finds pieces' neighbours across faces that stay closed, and the vertices of faces that part.
  void part_faces() {
    const std::vector<bool> is_between = vertices_between();
    struct Face {
      Triangle vertices;  // ascending
      Index piece;
      int corner;  // the opposite one
    };
    std::vector<Face> faces;
    for (Index p = 0; p < static_cast<Index>(pieces_.size()); ++p) {
      for (int i = 0; i < 4; ++i) {
        Triangle vertices;
        for (int k = 0; k < 3; ++k) {
          vertices[k] = pieces_[p].corners[kTetTriangles[i][k]];
        }
        std::sort(vertices.begin(), vertices.end());
        if (std::ranges::any_of(vertices, [&](Index v) { return is_between[v]; })) {
          faces.push_back({vertices, p, i});
        }
      }
    }
    std::stable_sort(faces.begin(), faces.end(),
                     [](const Face& a, const Face& b) { return a.vertices < b.vertices; });
    neighbors_.assign(pieces_.size(), {kInvalidIndex, kInvalidIndex, kInvalidIndex, kInvalidIndex});
    for (std::size_t f = 0; f + 1 < faces.size(); ++f) {
      const Face &a = faces[f], &b = faces[f + 1];
      if (a.vertices != b.vertices) {
        continue;
      }
      if (is_parted(a.vertices, pieces_[a.piece], pieces_[b.piece]) || is_on_front(a.vertices)) {
        parted_faces_.push_back({a.vertices, {a.piece, b.piece}});
        parted_vertices_.insert(parted_vertices_.end(), a.vertices.begin(), a.vertices.end());
      } else {
        neighbors_[a.piece][a.corner] = b.piece;
        neighbors_[b.piece][b.corner] = a.piece;
      }
    }
    std::sort(parted_vertices_.begin(), parted_vertices_.end());
    parted_vertices_.erase(std::unique(parted_vertices_.begin(), parted_vertices_.end()),
                           parted_vertices_.end());
  }

  [[nodiscard]] Index corner_of(Index piece, Index v) const {
    const Tet& corners = pieces_[piece].corners;
    return static_cast<Index>(std::ranges::find(corners, v) - corners.begin());
  }

  // What hangs together around a vertex keeps one vertex; `holders_` has who holds each corner.
  void split_vertices() {
    std::vector<Tet> corners;
    for (const CutPiece& piece : pieces_) {
      corners.push_back(piece.corners);
    }
    holders_ = corners;
    const Index all = vertex_count_ + static_cast<Index>(split_edges_.size());
    const IndexLists vertex_pieces = find_vertex_tets(all, corners);
    std::vector<bool> is_taken(4 * pieces_.size(), false);  // corners
    std::vector<Index> open;
    for (const Index v : parted_vertices_) {
      Index holder = v;
      for (const Index start : vertex_pieces[v]) {
        if (is_taken[4 * start + corner_of(start, v)]) {
          continue;
        }
        parts_.push_back({v, holder, 0});
        is_taken[4 * start + corner_of(start, v)] = true;
        open.assign(1, start);
        while (!open.empty()) {
          const Index piece = open.back();
          open.pop_back();
          const Index own = corner_of(piece, v);
          holders_[piece][own] = holder;
          if (parts_.back().side == 0) {
            parts_.back().side = pieces_[piece].side;
          }
          for (Index i = 0; i < 4; ++i) {
            const Index next = neighbors_[piece][i];
            if (i != own && next != kInvalidIndex && !is_taken[4 * next + corner_of(next, v)]) {
              is_taken[4 * next + corner_of(next, v)] = true;
              open.push_back(next);
            }
          }
        }
        holder = vertex_count_ + static_cast<Index>(edit_.new_vertices.size());
        edit_.new_vertices.push_back(copy_of(v));
      }
      edit_.new_vertices.pop_back();  // there is no further part
    }
  }

  [[nodiscard]] NewVertex copy_of(Index v) const {
    return v < vertex_count_ ? NewVertex{v, v, 0} : edit_.new_vertices[v - vertex_count_];
  }

  // What a vertex was split into. Two searches, for clang 14 takes no subrange of this library.
  [[nodiscard]] std::span<const Part> parts_of(Index vertex) const {
    return {std::ranges::lower_bound(parts_, vertex, {}, &Part::vertex),
            std::ranges::upper_bound(parts_, vertex, {}, &Part::vertex)};
  }

  // Vertices of parted faces, of this cut and the ones before, that were not split, and parted
  // faces that have no others, as they are after the edit.
  [[nodiscard]] CutFront remaining_front() const {
    CutFront front;
    std::ranges::set_union(parted_vertices_, sorted_front_vertices(),
                           std::back_inserter(front.vertices));
    std::erase_if(front.vertices, [&](Index v) { return parts_of(v).size() > 1; });
    for (const PartedFace& face : parted_faces_) {
      Triangle held;
      bool is_closed = true;
      for (int i = 0; i < 3; ++i) {
        const auto [a, b] = face.pieces;
        held[i] = holders_[a][corner_of(a, face.vertices[i])];
        is_closed &= held[i] == holders_[b][corner_of(b, face.vertices[i])];
      }
      if (is_closed) {
        front.closed_faces.push_back(held);
      }
    }
    return front;
  }

  [[nodiscard]] std::vector<Index> sorted_front_vertices() const {
    std::vector<Index> vertices = near_.front.vertices;
    std::sort(vertices.begin(), vertices.end());
    return vertices;
  }

  void write_pieces() {
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const CutPiece& piece = pieces_[p];
      if (piece.is_child) {
        edit_.new_tets.push_back({piece.tet, holders_[p]});
        continue;
      }
      for (int i = 0; i < 4; ++i) {
        if (holders_[p][i] != piece.corners[i]) {
          edit_.corner_moves.push_back({piece.tet, piece.corners[i], holders_[p][i]});
        }
      }
    }
  }

  void move_links() {
    for (Index l = 0; l < static_cast<Index>(near_.links.size()); ++l) {
      const Link& link = near_.links[l];
      for (const Index end : {link.first, link.second}) {
        const std::span<const Part> parts = parts_of(end);
        if (parts.size() < 2) {
          continue;
        }
        const Vector3d middle =
            0.5 * (geometry_.position(link.first) + geometry_.position(link.second));
        const int side = sign_of(geometry_.height(middle));
        const auto part = std::ranges::find(parts, side, &Part::side);
        if (part != parts.end() && part->holder != end) {
          edit_.link_moves.push_back({l, end, part->holder});
        }
      }
    }
  }

  const CutNeighborhood& near_;
  CutGeometry geometry_;
  const std::vector<Edge>& split_edges_;
  const std::vector<CutPiece>& pieces_;
  Index vertex_count_;
  TopologyEdit edit_;

  std::vector<std::array<Index, 4>> neighbors_;  // [pieces_] across from each corner
  std::vector<Triangle> front_;                  // as it was, each face ascending, sorted
  std::vector<PartedFace> parted_faces_;
  std::vector<Index> parted_vertices_;  // of parted faces, ascending
  std::vector<Tet> holders_;            // [pieces_] corners after the cut
  std::vector<Part> parts_;             // by vertex
};

}  // namespace

CutPlan plan_cut(const CutTissue& tissue, const CutSurface& surface, const CutOptions& options) {
  if (!(options.snap >= 0.01F && options.snap <= 0.4F)) {
    throw InvalidArgument("the cut's snap is " + std::to_string(options.snap) +
                          "; it must be in [0.01, 0.4]");
  }
  if (surface.triangles.empty()) {  // a blade that rests
    return {{}, options.front};
  }
  const CutSides sides(surface);
  const CutNeighborhood near = find_neighborhood(tissue, sides.bounds(), options.front);
  const CutPieces pieces = make_cut_pieces(near, sides, options);
  return with_solver_ids(CutPlanner(near, sides, pieces).plan(), near,
                         static_cast<Index>(tissue.positions.size()));
}

}  // namespace pbdsurg
