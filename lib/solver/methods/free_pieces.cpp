// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/free_pieces.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lib/solver/methods/custom_constraints.h"
#include "lib/solver/methods/moving_piece.h"
#include "lib/solver/methods/touch_search.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

// Pieces and, with the ids that follow, vertices without tetrahedra that links, triangles or hinges
// hold: those of strands and sheets. Joined, and whether a part of what was joined is held.
class Joined {
 public:
  Joined(const Tissue& tissue, const LivePieces& pieces) : tissue_(tissue), pieces_(pieces) {
    for_each_joint([&](std::span<const Index> vertices) {
      for (const Index v : vertices) {
        if (tissue.tets_at(v).empty()) {
          loose_.push_back(v);
        }
      }
    });
    std::ranges::sort(loose_);
    loose_.erase(std::unique(loose_.begin(), loose_.end()), loose_.end());
    const auto count = static_cast<std::size_t>(pieces.count());
    parents_.resize(count + loose_.size());
    is_held_.resize(parents_.size());
    for (std::size_t node = 0; node < parents_.size(); ++node) {
      parents_[node] = static_cast<Index>(node);
      is_held_[node] = node < count ? pieces.is_anchored(static_cast<Index>(node))
                                    : !is_free(loose_[node - count]);
    }
    for_each_joint([&](std::span<const Index> vertices) {
      for (const Index v : vertices) {
        join(node_of(vertices[0]), node_of(v));
      }
    });
  }

  [[nodiscard]] Index node_count() const { return static_cast<Index>(parents_.size()); }

  [[nodiscard]] Index root_of(Index node) {
    while (parents_[node] != node) {
      node = parents_[node] = parents_[parents_[node]];
    }
    return node;
  }

  [[nodiscard]] bool is_held(Index root) const { return is_held_[root]; }

  // Calls visit(vertex) for those of a node, of pieces more than once.
  template <class Visit>
  void for_each_vertex(Index node, const Visit& visit) const {
    if (node >= pieces_.count()) {
      visit(loose_[node - pieces_.count()]);
      return;
    }
    for (const Index t : pieces_.tets(node)) {
      std::ranges::for_each(tissue_.tets()[t], visit);
    }
  }

 private:
  template <class Visit>
  void for_each_joint(const Visit& visit) const {
    const std::span<const Link> links = tissue_.links();
    for (Index l = 0; l < static_cast<Index>(links.size()); ++l) {
      if (tissue_.is_link_alive(l)) {
        visit(std::array{links[l].first, links[l].second});
      }
    }
    const std::span<const Triangle> triangles = tissue_.triangles();
    for (Index t = 0; t < static_cast<Index>(triangles.size()); ++t) {
      if (tissue_.is_triangle_alive(t)) {
        visit(triangles[t]);
      }
    }
    const std::span<const Hinge> hinges = tissue_.hinges();
    for (Index h = 0; h < static_cast<Index>(hinges.size()); ++h) {
      if (tissue_.is_hinge_alive(h)) {
        visit(hinges[h].vertices);
      }
    }
  }

  [[nodiscard]] bool is_free(Index vertex) const {
    return !tissue_.is_fixed(vertex) && tissue_.masses()[vertex] > 0;
  }

  [[nodiscard]] Index node_of(Index vertex) const {
    const std::span<const Index> tets = tissue_.tets_at(vertex);
    if (!tets.empty()) {
      return pieces_.piece_of(tets.front());
    }
    const auto found = std::ranges::lower_bound(loose_, vertex);
    return pieces_.count() + static_cast<Index>(found - loose_.begin());
  }

  void join(Index a, Index b) {
    a = root_of(a);
    b = root_of(b);
    parents_[b] = a;
    is_held_[a] = is_held_[a] || is_held_[b];
  }

  const Tissue& tissue_;
  const LivePieces& pieces_;
  std::vector<Index> loose_;  // vertices, ascending
  std::vector<Index> parents_;
  std::vector<bool> is_held_;  // of roots
};

}  // namespace

void FreePieces::follow(const Tissue& tissue, std::unique_ptr<LivePieces> known) {
  pieces_ = known != nullptr ? std::move(known) : std::make_unique<LivePieces>(tissue);
  version_.reset();
}

void FreePieces::refresh(const Tissue& tissue, std::span<const Index> place_of_vertex) {
  if (pieces_ == nullptr || version_ == tissue.version()) {
    return;
  }
  const std::vector<Index> firsts = std::exchange(firsts_, {0});
  const std::vector<Index> places = std::exchange(places_, {});
  collect(tissue, place_of_vertex);
  version_ = tissue.version();
  revision_ += firsts != firsts_ || places != places_ ? 1 : 0;
}

void FreePieces::collect(const Tissue& tissue, std::span<const Index> place_of_vertex) {
  // strands and sheets have no pieces
  bool may_be_free = !tissue.links().empty() || !tissue.triangles().empty();
  for (Index piece = 0; piece < pieces_->count() && !may_be_free; ++piece) {
    may_be_free = pieces_->tet_count(piece) > 0 && !pieces_->is_anchored(piece);
  }
  if (!may_be_free) {
    return;
  }
  struct Member {
    Index root, place;
    auto operator<=>(const Member&) const = default;
  };
  Joined joined(tissue, *pieces_);
  std::vector<Member> members;
  for (Index node = 0; node < joined.node_count(); ++node) {
    const Index root = joined.root_of(node);
    if (!joined.is_held(root)) {
      joined.for_each_vertex(node, [&](Index v) { members.push_back({root, place_of_vertex[v]}); });
    }
  }
  std::ranges::sort(members);
  members.erase(std::unique(members.begin(), members.end()), members.end());
  // roots have ids by how edits went; what a solver does may not depend on that
  std::vector<std::span<const Member>> pieces;
  for (std::size_t first = 0, i = 0; i < members.size(); ++i) {
    if (i + 1 == members.size() || members[i + 1].root != members[i].root) {
      pieces.push_back(std::span<const Member>(members).subspan(first, i + 1 - first));
      first = i + 1;
    }
  }
  std::ranges::sort(pieces, {}, [](const auto& piece) { return piece.front().place; });
  for (const std::span<const Member> piece : pieces) {
    for (const Member& member : piece) {
      places_.push_back(member.place);
    }
    firsts_.push_back(static_cast<Index>(places_.size()));
  }
}

std::size_t FreePieces::memory_bytes() const noexcept {
  return (firsts_.capacity() + places_.capacity()) * sizeof(Index) +
         (pieces_ != nullptr ? pieces_->memory_bytes() : 0);
}

void keep_momentum(const StepContext& step, Index index) {
  const PushedPieces* const groups = has_touches(step)  ? &step.scratch.meeting
                                     : has_custom(step) ? &step.scratch.pushed
                                                        : nullptr;
  const MovingPiece piece(step, index, groups);
  bool is_held = false;
  piece.for_each_hold(
      [&](const VertexHold& hold) { is_held = is_held || hold.kind != HoldKind::touch; });
  if (is_held) {
    return;
  }
  const RigidMove move = piece.momentum().rigid_move();
  piece.for_each_place([&](Index place) {
    if (piece.counts(place)) {
      Particle& p = step.scratch.displacements[place];
      store(p, load(p) - part_of(move, piece.arm(place)));
    }
  });
}

}  // namespace pbdsurg
