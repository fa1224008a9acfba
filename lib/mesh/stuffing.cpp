// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/stuffing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tet_mesh.h"

#include "lib/base/describe.h"
#include "lib/mesh/lattice.h"
#include "lib/mesh/tet_shape.h"

// Four steps. Every lattice point inside, or next to one inside, becomes a node. Edges between
// inside and outside get a cut point. A node with a cut point close by moves there and counts as on
// the surface, which makes all its cut points vanish. Each lattice tetrahedron then keeps its inner
// part, by one of a few stencils; a face shared by two of them is split the same way in both.

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

enum class Side : signed char { inside, on_surface, outside };

// How close to a node, in parts of the edge, a cut point draws the node to itself.
constexpr double kLongWarp = 0.24999;
constexpr double kShortWarp = 0.41189;

struct Node {
  Site site;
  Vector3d position;
  Index address;
  Index cut_list = kInvalidIndex;  // into Stuffing::cuts_of_node_, for nodes with cut edges
  Side side;
};

class Stuffing {
 public:
  Stuffing(const ImplicitShape& shape, double spacing, const Vector3d& shift,
           std::int64_t max_cells)
      : shape_(shape), spacing_(spacing), lattice_(shape, spacing, shift, max_cells) {}

  StuffedMesh run() {
    collect_nodes();
    find_cuts();
    warp();
    emit_tets();
    return compacted();
  }

 private:
  using CutList = std::array<Index, kDirectionCount>;  // a cut point for each direction, or none

  // Cut points are numbered after the nodes.
  struct Corner {
    Index point;
    const Node* node;
  };

  void collect_nodes() {
    node_at_.assign(static_cast<std::size_t>(lattice_.site_count()), kInvalidIndex);
    for (Index address = 0; address < lattice_.site_count(); ++address) {
      const Site site = lattice_.site_at(address);
      const bool inside = lattice_.value(address) < 0;
      bool is_node = inside;
      for (const Site& direction : kDirections) {
        const Index neighbor = lattice_.address(site + direction);
        if (neighbor == kInvalidIndex) {
          if (inside) {
            report_escape(site);
          }
        } else if (lattice_.value(neighbor) < 0) {
          is_node = true;
        }
      }
      if (is_node) {
        node_at_[address] = static_cast<Index>(nodes_.size());
        nodes_.push_back({site, lattice_.position(site), address, kInvalidIndex,
                          inside ? Side::inside : Side::outside});
      }
    }
  }

  // An inside point whose neighbour is not even stored: a promise of the shape is broken.
  [[noreturn]] void report_escape(const Site& site) const {
    const Vector3d point = lattice_.position(site);
    if (!shape_.bounds().contains(point)) {
      throw InvalidArgument("the shape reaches past its bounds: it is negative at " +
                            describe(point) + ", and its box runs from " +
                            describe(shape_.bounds().min()) + " to " +
                            describe(shape_.bounds().max()));
    }
    throw InvalidArgument("the value of the shape changes too fast near " + describe(point) +
                          "; it must change by at most 1.3 m per metre");
  }

  [[nodiscard]] Node* neighbor(const Node& node, int direction) {
    const Index address = lattice_.address(node.site + kDirections[direction]);
    const Index id = address == kInvalidIndex ? kInvalidIndex : node_at_[address];
    return id == kInvalidIndex ? nullptr : &nodes_[id];
  }

  CutList& cut_list(Node& node) {
    if (node.cut_list == kInvalidIndex) {
      node.cut_list = static_cast<Index>(cuts_of_node_.size());
      cuts_of_node_.emplace_back().fill(kInvalidIndex);
    }
    return cuts_of_node_[node.cut_list];
  }

  void find_cuts() {
    for (Node& node : nodes_) {
      if (node.side != Side::inside) {
        continue;
      }
      for (int direction = 0; direction < kDirectionCount; ++direction) {
        Node& other = *neighbor(node, direction);  // an inside node has all its neighbours
        if (other.side == Side::inside) {
          continue;
        }
        const auto cut = static_cast<Index>(cuts_.size());
        cuts_.push_back(find_cut(node, other));
        cut_list(node)[direction] = cut;
        cut_list(other)[direction ^ 1] = cut;
      }
    }
  }

  // Where the value changes sign between an inside and an outside node: regula falsi, with the
  // weight of an end that stays halved (Illinois).
  [[nodiscard]] Vector3d find_cut(const Node& inside, const Node& outside) const {
    double low = 0, high = 1;
    double low_value = lattice_.value(inside.address);
    double high_value = lattice_.value(outside.address);
    double t = 0.5;
    int last_side = 0;
    for (int step = 0; step < 6; ++step) {
      t = low + (high - low) * low_value / (low_value - high_value);
      const double value = shape_((1 - t) * inside.position + t * outside.position);
      if (!(std::abs(value) >= 1e-4 * spacing_)) {
        break;
      }
      const int side = value < 0 ? -1 : 1;
      if (side < 0) {
        low = t;
        low_value = value;
        high_value *= side == last_side ? 0.5 : 1.0;
      } else {
        high = t;
        high_value = value;
        low_value *= side == last_side ? 0.5 : 1.0;
      }
      last_side = side;
    }
    t = std::clamp(t, 0.002, 0.998);
    return (1 - t) * inside.position + t * outside.position;
  }

  void warp() {
    for (Node& node : nodes_) {
      if (node.cut_list == kInvalidIndex) {
        continue;
      }
      CutList& list = cuts_of_node_[node.cut_list];
      Index nearest = kInvalidIndex;
      double nearest_distance = std::numeric_limits<double>::infinity();
      for (int direction = 0; direction < kDirectionCount; ++direction) {
        if (list[direction] == kInvalidIndex) {
          continue;
        }
        const double reach = direction < kLongDirectionCount
                                 ? kLongWarp * spacing_
                                 : kShortWarp * std::numbers::sqrt3 / 2 * spacing_;
        const double distance = (cuts_[list[direction]] - node.position).norm();
        if (distance < reach && distance < nearest_distance) {
          nearest = list[direction];
          nearest_distance = distance;
        }
      }
      if (nearest == kInvalidIndex) {
        continue;
      }
      node.position = cuts_[nearest];
      node.side = Side::on_surface;
      for (int direction = 0; direction < kDirectionCount; ++direction) {
        if (list[direction] != kInvalidIndex) {
          const Node& other = *neighbor(node, direction);
          cuts_of_node_[other.cut_list][direction ^ 1] = kInvalidIndex;
        }
      }
      list.fill(kInvalidIndex);
    }
  }

  // Two neighbouring centres and an edge of the face between their cells: 12 tetrahedra a cell.
  void emit_tets() {
    for (const Node& node : nodes_) {
      if ((node.site.x() & 1) == 0) {
        continue;
      }
      for (int axis = 0; axis < 3; ++axis) {
        const Node* next = neighbor(node, 2 * axis);
        if (next == nullptr) {
          continue;
        }
        Site b = Site::Zero(), c = Site::Zero();
        b[(axis + 1) % 3] = 1;
        c[(axis + 2) % 3] = 1;
        const Site middle = node.site + kDirections[2 * axis] / 2;
        const std::array<Site, 4> ring{middle + b + c, middle - b + c, middle - b - c,
                                       middle + b - c};
        for (int i = 0; i < 4; ++i) {
          const Node* first = node_at(ring[i]);
          const Node* second = node_at(ring[(i + 1) % 4]);
          if (first != nullptr && second != nullptr) {
            emit_stencil({&node, next, first, second});
          }
        }
      }
    }
  }

  [[nodiscard]] const Node* node_at(const Site& site) const {
    const Index address = lattice_.address(site);
    const Index id = address == kInvalidIndex ? kInvalidIndex : node_at_[address];
    return id == kInvalidIndex ? nullptr : &nodes_[id];
  }

  // Inside nodes first, then those on the surface, then those outside.
  void emit_stencil(std::array<const Node*, 4> corner) {
    std::stable_sort(corner.begin(), corner.end(),
                     [](const Node* a, const Node* b) { return a->side < b->side; });
    const auto inside = std::count_if(corner.begin(), corner.end(),
                                      [](const Node* n) { return n->side == Side::inside; });
    const auto outside = std::count_if(corner.begin(), corner.end(),
                                       [](const Node* n) { return n->side == Side::outside; });
    const auto& [p, q, r, s] = corner;
    if (inside == 0) {
      if (outside == 0) {
        emit_if_buried({id(p), id(q), id(r), id(s)});
      }
    } else if (outside == 0) {
      emit({id(p), id(q), id(r), id(s)});
    } else if (inside == 1) {
      Tet tet{id(p), id(q), id(r), id(s)};
      for (int i = 1; i < 4; ++i) {
        if (corner[i]->side == Side::outside) {
          tet[i] = cut(p, corner[i]);
        }
      }
      emit(tet);
    } else if (inside == 2 && outside == 1) {
      // a pyramid: the quad p, q and their cut points towards s, with its tip at r
      const Index cut_p = cut(p, s), cut_q = cut(q, s);
      if (diagonal_starts_at_first(p, q, s)) {
        emit({id(p), id(q), cut_q, id(r)});
        emit({id(p), cut_q, cut_p, id(r)});
      } else {
        emit({id(p), id(q), cut_p, id(r)});
        emit({id(q), cut_q, cut_p, id(r)});
      }
    } else if (inside == 3) {
      emit_prism({id(p), id(q), id(r)}, {cut(p, s), cut(q, s), cut(r, s)},
                 diagonal_starts_at_first(p, q, s), diagonal_starts_at_first(p, r, s),
                 diagonal_starts_at_first(q, r, s));
    } else {
      // a wedge along the edge p q; the quad of its four cut points is on the surface, where no
      // neighbour minds how it is split
      const std::array<Index, 3> at_p{id(p), cut(p, r), cut(p, s)};
      const std::array<Index, 3> at_q{id(q), cut(q, r), cut(q, s)};
      const bool towards_r = diagonal_starts_at_first(p, q, r);
      const bool towards_s = diagonal_starts_at_first(p, q, s);
      bool shorter = (point(at_p[1]) - point(at_q[2])).squaredNorm() <=
                     (point(at_q[1]) - point(at_p[2])).squaredNorm();
      if (is_cyclic(towards_r, towards_s, shorter)) {
        shorter = !shorter;
      }
      emit_prism(at_p, at_q, towards_r, towards_s, shorter);
    }
  }

  // The face of p and q inside and r outside leaves a quad p, q, cut q-r, cut p-r. Its diagonal
  // starts at p or at q, by the face alone, so that both tetrahedra at the face agree.
  [[nodiscard]] static bool diagonal_starts_at_first(const Node* p, const Node* q, const Node* r) {
    const auto is_long = [](const Node* a, const Node* b) {
      return ((a->site.x() ^ b->site.x()) & 1) == 0;
    };
    if (!is_long(p, q)) {
      return is_long(q, r);  // end at the cut point of the long edge
    }
    return ((p->site.array() > r->site.array()).count() & 1) == 0;
  }

  // Whether three diagonals on the sides of a prism, each given by whether it starts at the corner
  // of lower number, run in a circle, which leaves no way to split the prism.
  [[nodiscard]] static bool is_cyclic(bool first01, bool first02, bool first12) {
    return first01 == first12 && first01 != first02;
  }

  // A prism of triangles a and b. The diagonals order its corners, and the tetrahedra follow.
  void emit_prism(const std::array<Index, 3>& a, const std::array<Index, 3>& b, bool first01,
                  bool first02, bool first12) {
    std::array<int, 3> rank{};
    ++rank[first01 ? 1 : 0];
    ++rank[first02 ? 2 : 0];
    ++rank[first12 ? 2 : 1];
    std::array<int, 3> order{};
    for (int i = 0; i < 3; ++i) {
      order[rank[i]] = i;
    }
    const auto& [i, j, k] = order;
    emit({a[i], a[j], a[k], b[k]});
    emit({a[i], a[j], b[j], b[k]});
    emit({a[i], b[i], b[j], b[k]});
  }

  // Four nodes on the surface say nothing about what lies between them.
  void emit_if_buried(const Tet& tet) {
    const std::array<Vector3d, 4> x{point(tet[0]), point(tet[1]), point(tet[2]), point(tet[3])};
    const Vector3d middle = 0.25 * (x[0] + x[1] + x[2] + x[3]);
    if (!(shape_(middle) < -0.02 * spacing_)) {
      return;
    }
    const std::array<Tet, 1> whole{{{0, 1, 2, 3}}};
    const DihedralRange range = dihedral_range(x, whole);
    constexpr double kDegree = std::numbers::pi / 180;
    if (range.min >= 10 * kDegree && range.max <= 165 * kDegree) {
      emit(tet);
    }
  }

  void emit(const Tet& tet) { tets_.push_back(tet); }

  [[nodiscard]] Index id(const Node* node) const { return node_at_[node->address]; }

  [[nodiscard]] Index cut(const Node* inside, const Node* outside) const {
    const Site step = outside->site - inside->site;
    const auto direction = std::find(kDirections.begin(), kDirections.end(), step);
    return static_cast<Index>(nodes_.size()) +
           cuts_of_node_[inside->cut_list][direction - kDirections.begin()];
  }

  [[nodiscard]] const Vector3d& point(Index id) const {
    const auto node_count = static_cast<Index>(nodes_.size());
    return id < node_count ? nodes_[id].position : cuts_[id - node_count];
  }

  // Keeps the points in use, in the order in which the tetrahedra come to them.
  StuffedMesh compacted() {
    StuffedMesh mesh;
    std::vector<Index> new_id(nodes_.size() + cuts_.size(), kInvalidIndex);
    for (Tet& tet : tets_) {
      for (Index& v : tet) {
        if (new_id[v] == kInvalidIndex) {
          new_id[v] = static_cast<Index>(mesh.points.size());
          mesh.points.push_back(point(v));
        }
        v = new_id[v];
      }
    }
    mesh.tets = std::move(tets_);
    orient_tets(mesh.points, mesh.tets);
    return mesh;
  }

  const ImplicitShape& shape_;
  double spacing_;
  Lattice lattice_;
  std::vector<Index> node_at_;  // [site_count] node of each stored site
  std::vector<Node> nodes_;
  std::vector<CutList> cuts_of_node_;
  std::vector<Vector3d> cuts_;
  std::vector<Tet> tets_;
};

}  // namespace

StuffedMesh stuff(const ImplicitShape& shape, double spacing, const Vector3d& shift,
                  std::int64_t max_cells) {
  return Stuffing(shape, spacing, shift, max_cells).run();
}

}  // namespace pbdsurg
