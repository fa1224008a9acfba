// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/tissue_surface.h"

#include <utility>

namespace pbdsurg {

void TissueSurface::begin(const Tissue& tissue) {
  if (has_begun_) {
    return;
  }
  has_begun_ = true;
  refresh(tissue);
}

void TissueSurface::refresh(const Tissue& tissue) {
  const auto bodies = static_cast<Index>(has_begun_ ? tissue.bodies().size() : 0);
  for (auto body = static_cast<Index>(surfaces_.size()); body < bodies; ++body) {
    surfaces_.push_back(std::make_unique<Surface>(tissue, body));
    surfaces_.back()->revision = ++revision_;
  }
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    const LiveSurface& live = surface->live;
    if (surface->seen_version == live.version()) {
      continue;
    }
    live.collect_changes(surface->seen_version, ranges_);
    surface->seen_version = live.version();
    surface->revision = ++revision_;
    surface->triangles.resize(static_cast<std::size_t>(live.slot_count()));
    for (const SlotRange& range : ranges_) {
      for (Index slot = range.first; slot < range.end; ++slot) {
        const bool is_empty = live.origins()[slot].tet == kInvalidIndex;
        std::ranges::transform(
            live.triangles()[slot], surface->triangles[slot].begin(),
            [&](Index v) { return is_empty ? kInvalidIndex : place_of_vertex_[v]; });
      }
    }
  }
  refresh_links(tissue);
}

void TissueSurface::refresh_links(const Tissue& tissue) {
  if (!has_begun_ || links_version_ == tissue.version()) {
    return;
  }
  std::vector<PlaceTriangle> links;
  for (Index body = 0; body < static_cast<Index>(tissue.bodies().size()); ++body) {
    if (has_particles(tissue.body(body))) {
      const std::vector<PlaceTriangle> own = links_of(tissue, body);
      links.insert(links.end(), own.begin(), own.end());
    }
  }
  if (links != links_) {
    links_ = std::move(links);
    ++revision_;
  }
  links_version_ = tissue.version();
}

std::vector<TissueSurface::PlaceTriangle> TissueSurface::links_of(const Tissue& tissue,
                                                                  Index body) const {
  std::vector<PlaceTriangle> links;
  for (const Index v : tissue.vertices_of(body)) {
    for (const Index l : tissue.links_at(v)) {
      const Link& link = tissue.links()[l];
      if (link.first == v && tissue.body_of_vertex(link.second) == body) {
        const auto [a, b] = std::minmax(place_of_vertex_[v], place_of_vertex_[link.second]);
        links.push_back({a, b, b});
      }
    }
  }
  std::ranges::sort(links);  // two may join the same
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return links;
}

Index TissueSurface::triangle_count() const noexcept {
  Index count = 0;
  for_each_triangle([&](const PlaceTriangle&) { ++count; });
  return count;
}

std::size_t TissueSurface::slot_count() const noexcept {
  std::size_t count = 0;
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    count += surface->triangles.size();
  }
  return count + links_.size();
}

std::size_t TissueSurface::memory_bytes() const noexcept {
  std::size_t bytes =
      ranges_.capacity() * sizeof(SlotRange) + links_.capacity() * sizeof(PlaceTriangle);
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    bytes += sizeof(Surface) + surface->triangles.capacity() * sizeof(PlaceTriangle);
  }
  return bytes;
}

void TissueSurface::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  if (!has_begun_) {
    return;
  }
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    surface->live.follow(tissue, change);
    surface->follows_last_edit = true;
  }
}

void TissueSurface::undo(const Tissue& tissue, const TissueChange& change) noexcept {
  if (!has_begun_) {
    return;
  }
  // those of bodies that go, and those that refresh() makes anew
  const std::size_t bodies = tissue.bodies().size();
  while (!surfaces_.empty() &&
         (surfaces_.size() > bodies || !surfaces_.back()->follows_last_edit)) {
    surfaces_.pop_back();
    ++revision_;
  }
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    surface->live.undo(tissue, change);
  }
}

}  // namespace pbdsurg
