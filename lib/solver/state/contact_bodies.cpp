// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/contact_bodies.h"

#include <algorithm>
#include <cmath>
#include <numeric>
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

// Whether a link is part of a body of particles: what it joins may meet.
bool is_within_particles(const Tissue& tissue, const Link& link) {
  const Index body = tissue.body_of_vertex(link.first);
  return has_particles(tissue.body(body)) && tissue.body_of_vertex(link.second) == body;
}

// Sorts by a place, and those that share one, which are few, among themselves.
template <class T, class PlaceOf>
void sort_by_place(std::vector<T>& list, std::size_t place_count, const PlaceOf& place_of) {
  std::vector<std::size_t> first(place_count + 1, 0);
  for (const T& each : list) {
    ++first[static_cast<std::size_t>(place_of(each)) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::size_t> end(first.begin(), first.end() - 1);
  std::vector<T> sorted(list.size());
  for (const T& each : list) {
    sorted[end[static_cast<std::size_t>(place_of(each))]++] = each;
  }
  for (std::size_t place = 0; place < place_count; ++place) {
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first[place]),
              sorted.begin() + static_cast<std::ptrdiff_t>(end[place]));
  }
  list = std::move(sorted);
}

void add_surface(const TissueSurface& surface, ContactBodies::Body& body) {
  for (const PlaceTriangle& slot : surface.slots(body.body)) {
    if (slot[0] == kInvalidIndex) {
      continue;
    }
    const PlaceTriangle triangle = turned(slot);
    if (body.is_two_sided && triangle[1] > triangle[2]) {
      continue;  // the other side has it too
    }
    body.triangles.push_back(triangle);
  }
}

void add_particles(const Tissue& tissue, const TissueSurface& surface,
                   std::span<const Index> place_of_vertex, ContactBodies::Body& body) {
  for (const Index v : tissue.vertices_of(body.body)) {
    if (tissue.has_tissue(v)) {
      body.places.push_back(place_of_vertex[v]);
    }
  }
  body.triangles = surface.links_of(tissue, body.body);
}

// Whether a surface is bent outwards at an edge, by 18 degrees or more; or has no two sides there.
bool is_sharp(const ContactBodies::Edge& edge, std::span<const Vec3<float>> positions) {
  constexpr float kFlat = 0.95F;  // the cosine
  if (std::ranges::find(edge.opposite, kInvalidIndex) != edge.opposite.end()) {
    return true;
  }
  const Vec3<float> start = positions[edge.ends[0]], along = positions[edge.ends[1]] - start;
  const Vec3<float> one = positions[edge.opposite[0]] - start,
                    other = positions[edge.opposite[1]] - start;
  const Vec3<float> first = cross(along, one), second = cross(other, along);
  return dot(first, other) < 0 &&
         dot(first, second) < kFlat * std::sqrt(dot(first, first)) * std::sqrt(dot(second, second));
}

// What the triangles at an edge say of it. Where more than two of a sheet are joined all ways lean
// over some of them, and none tells; where a solid touches itself in an edge there is no outside,
// and no edge.
ContactBodies::Edge joined(std::span<const ContactBodies::Edge> parts, bool is_two_sided) {
  ContactBodies::Edge edge{parts[0].ends, {kInvalidIndex, kInvalidIndex}};
  if (parts.size() > 2) {
    if (!is_two_sided) {
      edge.ends.fill(kInvalidIndex);
    }
    return edge;
  }
  for (const ContactBodies::Edge& part : parts) {
    for (int k = 0; k < 2; ++k) {
      if (part.opposite[k] != kInvalidIndex) {  // sheets need not be wound alike
        edge.opposite[edge.opposite[k] == kInvalidIndex ? k : 1 - k] = part.opposite[k];
      }
    }
  }
  return edge;
}

std::vector<ContactBodies::Edge> edges_of(std::span<const PlaceTriangle> triangles,
                                          bool is_two_sided, std::size_t place_count) {
  std::vector<ContactBodies::Edge> edges;
  for (const PlaceTriangle& t : triangles) {
    if (t[1] == t[2]) {
      edges.push_back({{t[0], t[1]}, {kInvalidIndex, kInvalidIndex}});
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const Index a = t[k], b = t[(k + 1) % 3], opposite = t[(k + 2) % 3];
      edges.push_back(a < b ? ContactBodies::Edge{{a, b}, {opposite, kInvalidIndex}}
                            : ContactBodies::Edge{{b, a}, {kInvalidIndex, opposite}});
    }
  }
  sort_by_place(edges, place_count, [](const ContactBodies::Edge& edge) { return edge.ends[0]; });
  std::size_t count = 0;
  for (auto first = edges.begin(); first != edges.end();) {
    const auto end = std::find_if(
        first, edges.end(), [&](const ContactBodies::Edge& e) { return e.ends != first->ends; });
    edges[count++] = joined({first, end}, is_two_sided);
    first = end;
  }
  edges.erase(edges.begin() + static_cast<std::ptrdiff_t>(count), edges.end());
  std::erase_if(edges, [](const ContactBodies::Edge& e) { return e.ends[0] == kInvalidIndex; });
  return edges;
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
  std::vector<Body> before = std::exchange(bodies_, {});
  if (!version_) {
    before.clear();  // which body meets itself may have changed
  }
  for (const ContactPair& pair : pairs_) {
    for (const Index body : {pair.first, pair.second}) {
      bodies_.push_back({body, surface.is_two_sided(body) || has_particles(tissue.body(body))});
    }
  }
  std::ranges::sort(bodies_, {}, &Body::body);
  const auto same = [](const Body& a, const Body& b) { return a.body == b.body; };
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end(), same), bodies_.end());
  rest_.resize(place_of_vertex.size());
  for (std::size_t v = 0; v < place_of_vertex.size(); ++v) {
    const Eigen::Vector3f x = tissue.rest_positions()[v].cast<float>();
    rest_[place_of_vertex[v]] = {x.x(), x.y(), x.z()};
  }
  vertex_count_ = 0;
  for (Body& each : bodies_) {
    const auto known = std::ranges::find(before, each.body, &Body::body);
    const bool is_known = known != before.end() && !has_particles(tissue.body(each.body)) &&
                          known->surface == surface.revision_of(each.body);
    if (is_known) {
      each = std::move(*known);
    } else {
      list_body(tissue, surface, place_of_vertex, each);
    }
    each.first_vertex = vertex_count_;
    vertex_count_ += static_cast<Index>(each.places.size());
  }
}

void ContactBodies::list_body(const Tissue& tissue, const TissueSurface& surface,
                              std::span<const Index> place_of_vertex, Body& body) {
  body.meets_itself = std::ranges::any_of(pairs_, [&](const ContactPair& pair) {
    return pair.first == body.body && pair.second == body.body;
  });
  if (has_particles(tissue.body(body.body))) {
    add_particles(tissue, surface, place_of_vertex, body);
  } else {
    add_surface(surface, body);
  }
  sort_by_place(body.triangles, rest_.size(), [](const PlaceTriangle& t) { return t[0]; });
  std::vector<bool> is_here(rest_.size(), false);
  for (const Index place : body.places) {  // particles need have no link
    is_here[place] = true;
  }
  for (const PlaceTriangle& triangle : body.triangles) {
    std::ranges::for_each(triangle, [&](Index place) { is_here[place] = true; });
  }
  body.places.clear();
  for (Index place = 0; place < static_cast<Index>(is_here.size()); ++place) {
    if (is_here[place]) {
      body.places.push_back(place);
    }
  }
  body.edges = edges_of(body.triangles, body.is_two_sided, rest_.size());
  if (!body.is_two_sided) {
    std::erase_if(body.edges, [&](const Edge& edge) { return !is_sharp(edge, rest_); });
  }
  body.surface = surface.revision_of(body.body);
  body.revision = ++last_body_;
}

void ContactBodies::mark_joined(const Tissue& tissue, std::span<const Index> place_of_vertex) {
  const std::size_t count = place_of_vertex.size();
  is_joined_.assign(count, 0);
  std::vector<bool> is_end(count, false);
  for (Index l = 0; l < static_cast<Index>(tissue.links().size()); ++l) {
    if (tissue.is_link_alive(l) && !is_within_particles(tissue, tissue.links()[l])) {
      is_end[place_of_vertex[tissue.links()[l].first]] = true;
      is_end[place_of_vertex[tissue.links()[l].second]] = true;
    }
  }
  for (const Body& each : bodies_) {
    for (const Index place : each.places) {  // particles need have no link
      is_joined_[place] = is_end[place] ? 1 : 0;
    }
    for (const PlaceTriangle& triangle : each.triangles) {
      if (std::ranges::any_of(triangle, [&](Index place) { return is_end[place]; })) {
        std::ranges::for_each(triangle, [&](Index place) { is_joined_[place] = 1; });
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

std::size_t ContactBodies::memory_bytes() const noexcept {
  std::size_t bytes = pairs_.capacity() * sizeof(ContactPair) + is_joined_.capacity() +
                      rest_.capacity() * sizeof(Vec3<float>) +
                      (first_neighbors_.capacity() + neighbors_.capacity()) * sizeof(Index);
  for (const Body& each : bodies_) {
    bytes += sizeof(Body) + each.places.capacity() * sizeof(Index) +
             each.triangles.capacity() * sizeof(PlaceTriangle) +
             each.edges.capacity() * sizeof(Edge);
  }
  return bytes;
}

}  // namespace pbdsurg
