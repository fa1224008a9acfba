// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/surface_map.h"

#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

void check_fields(const LiveSurface& surface, const SurfaceFields& fields,
                  std::span<const Index> changed, std::span<const SlotRange> slots) {
  const std::size_t size = fields.temperatures.size();
  for (const std::size_t other :
       {fields.survival.size(), fields.water.size(), fields.charred.size()}) {
    if (other != size) {
      throw InvalidArgument("a field of " + std::to_string(other) + " vertices is beside one of " +
                            std::to_string(size));
    }
  }
  const auto check_vertex = [&](Index v) {
    if (v < 0 || static_cast<std::size_t>(v) >= size) {
      throw InvalidArgument("vertex " + std::to_string(v) + " is not in fields of " +
                            std::to_string(size) + " vertices");
    }
  };
  for (const Index v : changed) {
    check_vertex(v);
  }
  for (const auto [first, end] : slots) {
    for (Index slot = first; slot < end; ++slot) {
      for (const Index v : surface.triangles()[slot]) {
        check_vertex(v);
      }
    }
  }
}

}  // namespace

void SurfaceMap::update(const LiveSurface& surface, const SurfaceFields& fields,
                        std::span<const Index> changed) {
  begin(surface, fields, changed);
  for (const Index v : changed) {
    take(fields, v);
  }
}

void SurfaceMap::update(const LiveSurface& surface, const SurfaceFields& fields) {
  begin(surface, fields, {});
  for (Index v = 0; v < static_cast<Index>(temperatures_.size()); ++v) {
    take(fields, v);
  }
}

// Follows the surface.
void SurfaceMap::begin(const LiveSurface& surface, const SurfaceFields& fields,
                       std::span<const Index> changed) {
  if (temperatures_.empty()) {  // as at first, or moved from
    seen_surface_ = 0;
  }
  surface.collect_changes(seen_surface_, ranges_);
  check_fields(surface, fields, changed, ranges_);
  seen_surface_ = surface.version();
  const std::size_t vertex_count = fields.temperatures.size();
  temperatures_.resize(vertex_count);
  marks_.resize(vertex_count);
  has_surfaced_.resize(vertex_count);
  changes_.reserve(static_cast<Index>(vertex_count));
  for (const auto [first, end] : ranges_) {
    for (Index slot = first; slot < end; ++slot) {
      if (surface.triangles()[slot] == LiveSurface::kEmptyTriangle) {
        continue;
      }
      for (const Index v : surface.triangles()[slot]) {
        has_surfaced_[v] = 1;
        take(fields, v);
      }
    }
  }
}

void SurfaceMap::take(const SurfaceFields& fields, Index vertex) {
  if (has_surfaced_[vertex] == 0) {
    return;
  }
  const auto temperature =
      std::round(static_cast<float>(fields.temperatures[vertex]) / kTemperatureStep) *
      kTemperatureStep;
  const BurnMarks marks =
      burn_marks(fields.survival[vertex], fields.water[vertex], fields.charred[vertex]);
  const BurnBytes bytes{to_byte(marks.white), to_byte(marks.brown), to_byte(marks.charred)};
  if (temperature != temperatures_[vertex] || bytes != marks_[vertex]) {
    temperatures_[vertex] = temperature;
    marks_[vertex] = bytes;
    changes_.note(vertex);
  }
}

}  // namespace pbdsurg
