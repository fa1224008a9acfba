// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/surface.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "pbdsurg/heat/heat_field.h"

namespace pbdsurg {

Surface::Surface(const Solver& solver, BodyId body) : live_(shared_surface(solver.tissue(), body)) {
  refresh(solver, nullptr);
}
Surface::~Surface() = default;

std::uint64_t Surface::version() const noexcept {
  return live_->version();
}

void Surface::collect_changes(std::uint64_t since, std::vector<SlotRange>& ranges) const {
  live_->collect_changes(since, ranges);
}

void Surface::refresh(const Solver& solver, const HeatField* heat) {
  const Tissue& tissue = solver.tissue();
  if (seen_count_ != tissue.vertex_count() || seen_renumberings_ != live_->renumberings()) {
    seen_count_ = tissue.vertex_count();
    seen_renumberings_ = live_->renumberings();
    number(tissue);
    mark_changes_.reserve(static_cast<Index>(vertices_.size()));
    mark_changes_.note_all();
  }
  take_triangles();
  positions_.resize(vertices_.size());
  solver.read_positions(vertices_, positions_);
  has_normals_ = false;
  if (heat == nullptr) {
    return;
  }
  const auto warm = heat->active_vertices();
  warm_.insert(warm_.end(), warm.begin(), warm.end());  // what has gone to rest was warm before
  std::erase_if(warm_, [&](Index v) { return v >= tissue.vertex_count(); });
  map_.update(*live_, {heat->peak_temperatures(), heat->survival(), heat->water(), heat->charred()},
              warm_);
  warm_.assign(warm.begin(), warm.end());
  temperatures_.resize(vertices_.size());
  peaks_.resize(vertices_.size());
  marks_.resize(vertices_.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    temperatures_[i] = static_cast<float>(heat->temperatures()[vertices_[i]]);
    const float peak = map_.temperatures()[vertices_[i]];
    const BurnBytes marks = map_.marks()[vertices_[i]];
    if (peaks_[i] != peak || marks_[i] != marks) {
      peaks_[i] = peak;
      marks_[i] = marks;
      mark_changes_.note(static_cast<Index>(i));
    }
  }
}

void Surface::number(const Tissue& tissue) {
  vertices_.clear();
  if (live_->body() != kInvalidIndex) {
    vertices_ = tissue.vertices_of(live_->body());
  }
  rest_.resize(vertices_.size());
  std::ranges::transform(vertices_, rest_.begin(), [&](Index v) {
    return Eigen::Vector3f(tissue.rest_positions()[v].cast<float>());
  });
}

void Surface::take_triangles() {
  triangles_.resize(static_cast<std::size_t>(live_->slot_count()));
  live_->collect_changes(seen_slots_, ranges_);
  seen_slots_ = live_->version();
  for (const SlotRange& range : ranges_) {
    for (Index slot = range.first; slot < range.end; ++slot) {
      const Triangle& triangle = live_->triangles()[slot];
      triangles_[slot] = triangle == LiveSurface::kEmptyTriangle
                             ? Triangle{0, 0, 0}
                             : Triangle{local(triangle[0]), local(triangle[1]), local(triangle[2])};
    }
  }
}

Index Surface::local(Index vertex) const noexcept {
  return static_cast<Index>(std::ranges::lower_bound(vertices_, vertex) - vertices_.begin());
}

std::span<const Eigen::Vector3f> Surface::normals() const {
  if (has_normals_) {
    return normals_;
  }
  normals_.assign(vertices_.size(), Eigen::Vector3f::Zero());
  for (std::size_t slot = 0; slot < triangles_.size(); ++slot) {
    const auto [a, b, c] = triangles_[slot];
    const bool is_back = live_->is_two_sided() && live_->origins()[slot].face == 1;
    if (a == b || is_back) {
      continue;  // empty; and of a body that a compaction left out, not even the vertices are there
    }
    const Eigen::Vector3f area =
        (positions_[b] - positions_[a]).cross(positions_[c] - positions_[a]);
    for (const Index v : {a, b, c}) {
      normals_[v] += area;
    }
  }
  for (Eigen::Vector3f& normal : normals_) {
    normal.normalize();  // which leaves zero as it is
  }
  has_normals_ = true;
  return normals_;
}

}  // namespace pbdsurg
