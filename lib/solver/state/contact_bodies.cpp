// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/contact_bodies.h"

#include <algorithm>
#include <utility>

#include "lib/solver/state/tissue_surface.h"

namespace pbdsurg {
namespace {

using PlaceTriangle = ContactBodies::PlaceTriangle;

std::pair<Index, Index> ids_of(const ContactPair& pair) {
  return {pair.first, pair.second};
}

// The smallest place first, wound as before.
PlaceTriangle turned(PlaceTriangle triangle) {
  std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
  return triangle;
}

bool has(const PlaceTriangle& triangle, Index place) {
  return std::ranges::find(triangle, place) != triangle.end();
}

}  // namespace

void ContactBodies::set(const ContactPair& pair) {
  const auto at = std::ranges::lower_bound(pairs_, ids_of(pair), {}, ids_of);
  if (at != pairs_.end() && ids_of(*at) == ids_of(pair)) {
    *at = pair;
  } else {
    pairs_.insert(at, pair);
  }
  version_.reset();
}

void ContactBodies::remove(Index first, Index second) {
  std::erase_if(pairs_,
                [&](const ContactPair& pair) { return ids_of(pair) == std::pair(first, second); });
  version_.reset();
}

void ContactBodies::replace(std::vector<ContactPair> pairs) {
  pairs_ = std::move(pairs);
  std::ranges::sort(pairs_, {}, ids_of);
  version_.reset();
}

void ContactBodies::drop_bodies_from(Index body) {
  std::erase_if(pairs_, [&](const ContactPair& pair) { return pair.second >= body; });
  version_.reset();
}

const ContactBodies::Body& ContactBodies::body(Index of_tissue) const noexcept {
  return *std::ranges::lower_bound(bodies_, of_tissue, {}, &Body::body);
}

void ContactBodies::refresh(const Tissue& tissue, const TissueSurface& surface,
                            std::span<const Index> place_of_vertex) {
  if (version_ == tissue.version() || (pairs_.empty() && bodies_.empty())) {
    return;
  }
  list(tissue, surface, place_of_vertex);
  mark_joined(tissue, place_of_vertex);
  list_neighbors();
  version_ = tissue.version();
  ++revision_;
}

void ContactBodies::list(const Tissue& tissue, const TissueSurface& surface,
                         std::span<const Index> place_of_vertex) {
  bodies_.clear();
  for (const ContactPair& pair : pairs_) {
    for (const Index body : {pair.first, pair.second}) {
      bodies_.push_back({body, surface.is_two_sided(body)});
    }
  }
  std::ranges::sort(bodies_, {}, &Body::body);
  const auto same = [](const Body& a, const Body& b) { return a.body == b.body; };
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end(), same), bodies_.end());
  vertex_count_ = 0;
  for (Body& each : bodies_) {
    each.meets_itself = std::ranges::any_of(pairs_, [&](const ContactPair& pair) {
      return pair.first == each.body && pair.second == each.body;
    });
    for (const PlaceTriangle& slot : surface.slots(each.body)) {
      if (slot[0] == kInvalidIndex) {
        continue;
      }
      const PlaceTriangle triangle = turned(slot);
      if (each.is_two_sided && triangle[1] > triangle[2]) {
        continue;  // the other side has it too
      }
      each.triangles.push_back(triangle);
      each.places.insert(each.places.end(), triangle.begin(), triangle.end());
    }
    std::ranges::sort(each.places);
    each.places.erase(std::unique(each.places.begin(), each.places.end()), each.places.end());
    each.first_vertex = vertex_count_;
    vertex_count_ += static_cast<Index>(each.places.size());
  }
  rest_.clear();
  if (std::ranges::any_of(bodies_, &Body::meets_itself)) {
    rest_.resize(place_of_vertex.size());
    for (std::size_t v = 0; v < place_of_vertex.size(); ++v) {
      const Eigen::Vector3f x = tissue.rest_positions()[v].cast<float>();
      rest_[place_of_vertex[v]] = {x.x(), x.y(), x.z()};
    }
  }
}

void ContactBodies::mark_joined(const Tissue& tissue, std::span<const Index> place_of_vertex) {
  const std::size_t count = place_of_vertex.size();
  is_joined_.assign(count, false);
  std::vector<bool> is_end(count, false);
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    if (tissue.is_link_alive(l)) {
      is_end[place_of_vertex[tissue.links()[l].first]] = true;
      is_end[place_of_vertex[tissue.links()[l].second]] = true;
    }
  }
  for (const Body& each : bodies_) {
    for (const PlaceTriangle& triangle : each.triangles) {
      if (std::ranges::any_of(triangle, [&](Index place) { return is_end[place]; })) {
        std::ranges::for_each(triangle, [&](Index place) { is_joined_[place] = true; });
      }
    }
  }
}

void ContactBodies::list_neighbors() {
  std::vector<std::pair<Index, Index>> pairs;
  for (const Body& each : bodies_) {
    for (const PlaceTriangle& t : each.triangles) {
      for (int k = 0; k < 3 && each.meets_itself; ++k) {
        pairs.emplace_back(t[k], t[(k + 1) % 3]);
        pairs.emplace_back(t[(k + 1) % 3], t[k]);
      }
    }
  }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  first_neighbors_.assign(rest_.size() + 1, 0);
  neighbors_.clear();
  for (const auto& [place, neighbor] : pairs) {
    ++first_neighbors_[place + 1];
    neighbors_.push_back(neighbor);
  }
  for (std::size_t place = 0; place < rest_.size(); ++place) {
    first_neighbors_[place + 1] += first_neighbors_[place];
  }
}

bool ContactBodies::may_meet(Index place, Index vertex_body, const PlaceTriangle& triangle,
                             const Body& body, float near) const {
  const auto is_joined = [&](Index corner) { return is_joined_[corner]; };
  if (is_joined_[place] && std::ranges::any_of(triangle, is_joined)) {
    return false;
  }
  if (vertex_body != body.body) {
    return true;
  }
  if (has(triangle, place)) {
    return false;
  }
  for (Index n = first_neighbors_[place]; n < first_neighbors_[place + 1]; ++n) {
    if (has(triangle, neighbors_[n])) {
      return false;
    }
  }
  return std::ranges::all_of(triangle, [&](Index corner) {
    const Vec3<float> d = rest_[corner] - rest_[place];
    return dot(d, d) > near * near;
  });
}

std::size_t ContactBodies::memory_bytes() const noexcept {
  std::size_t bytes = pairs_.capacity() * sizeof(ContactPair) + (is_joined_.capacity() / 8) +
                      rest_.capacity() * sizeof(Vec3<float>) +
                      (first_neighbors_.capacity() + neighbors_.capacity()) * sizeof(Index);
  for (const Body& each : bodies_) {
    bytes += sizeof(Body) + each.places.capacity() * sizeof(Index) +
             each.triangles.capacity() * sizeof(PlaceTriangle);
  }
  return bytes;
}

}  // namespace pbdsurg
