// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/tissue_surface.h"

#include <algorithm>

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
  }
  for (const std::unique_ptr<Surface>& surface : surfaces_) {
    const LiveSurface& live = surface->live;
    if (surface->seen_version == live.version()) {
      continue;
    }
    live.collect_changes(surface->seen_version, ranges_);
    surface->seen_version = live.version();
    ++revision_;
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
  return count;
}

std::size_t TissueSurface::memory_bytes() const noexcept {
  std::size_t bytes = ranges_.capacity() * sizeof(SlotRange);
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
