// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/surface_data.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

using pbdsurg::Index;

float linear_of_srgb(float value) {
  const float v = std::clamp(value, 0.0f, 1.0f);
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

[[noreturn]] void refuse(const Surface& surface, const std::string& reason) {
  throw pbdsurg::InvalidArgument("surface '" + surface.name + "'" + reason);
}

void check_length(const Surface& surface, const char* array, std::size_t length,
                  std::size_t expected, const char* one, const char* many) {
  if (length != 0 && length != expected) {
    refuse(surface, " has " + std::to_string(expected) + ' ' + many + " and " +
                        std::to_string(length) + " entries of " + array +
                        "; expected none or one per " + one);
  }
}

void check_triangles(const Surface& surface, std::span<const pbdsurg::Triangle> triangles,
                     std::size_t first, std::size_t vertex_count) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const Index v : triangles[t]) {
      if (v < 0 || static_cast<std::size_t>(v) >= vertex_count) {
        refuse(surface, ": triangle " + std::to_string(first + t) + " refers to vertex " +
                            std::to_string(v) + "; ids must be in [0, " +
                            std::to_string(vertex_count) + ")");
      }
    }
  }
}

void check_look(const Surface& surface, const pbdsurg::TissueLook& look) {
  if (!(look.detail_size > 0) || !std::isfinite(look.detail_size)) {
    refuse(surface, ": the detail size is " + std::to_string(look.detail_size) +
                        " m; it must be positive and finite");
  }
}

void check_first(const Surface& surface, const char* run, Index first, std::size_t end) {
  if (first < 0 || static_cast<std::size_t>(first) > end) {
    refuse(surface, ": a run of " + std::string(run) + " starts at " + std::to_string(first) +
                        "; it must start in [0, " + std::to_string(end) + "]");
  }
}

std::size_t count_after(const Surface& surface, const SurfaceChange& change) {
  return change.positions.empty() ? surface.positions.size() : change.positions.size();
}

// A surface without rest positions has its texture stick to where it is; one that has no vertices
// yet may get them.
bool has_rest(const Surface& surface) {
  return !surface.rest_positions.empty() || surface.positions.empty();
}

template <class T>
void replace(std::vector<T>& values, Index first, const std::vector<T>& run) {
  const std::size_t at = static_cast<std::size_t>(first);
  values.resize(std::max(values.size(), at + run.size()));
  std::copy(run.begin(), run.end(), values.begin() + static_cast<std::ptrdiff_t>(at));
}

}  // namespace

Eigen::Vector4f linear_of_srgb(const Eigen::Vector3f& color, float alpha) {
  return {linear_of_srgb(color.x()), linear_of_srgb(color.y()), linear_of_srgb(color.z()),
          std::clamp(alpha, 0.0f, 1.0f)};
}

DrawMaterial material_of(const pbdsurg::TissueLook& look, bool insulation) {
  return {linear_of_srgb(look.color, look.opacity),
          linear_of_srgb(look.mottle, 1),
          {look.gloss, look.detail_size, look.relief, insulation ? 1.0f : 0.0f},
          {look.lobules, look.vessels, 0, 0}};
}

float wetness_at(const Surface& surface, std::size_t v) {
  return surface.wetness.empty() || !std::isfinite(surface.wetness[v])
             ? 0.0f
             : std::clamp(surface.wetness[v], 0.0f, 1.0f);
}

Eigen::Vector4f burn_at(const Surface& surface, std::size_t v) {
  if (surface.burn.empty() || !surface.burn[v].allFinite() || !(surface.burn[v].w() > 0)) {
    return Eigen::Vector4f::Zero();
  }
  Eigen::Vector4f layer = linear_of_srgb(surface.burn[v].head<3>(), surface.burn[v].w());
  layer.head<3>() *= layer.w();
  return layer;
}

Eigen::Vector4f color_at(const Surface& surface, std::size_t v) {
  return surface.colors.empty() || !surface.colors[v].allFinite()
             ? kMaterialColor
             : linear_of_srgb(surface.colors[v].head<3>(), surface.colors[v].w());
}

bool is_translucent(const Surface& surface) {
  const bool has_inner = std::any_of(surface.is_inner.begin(), surface.is_inner.end(),
                                     [](std::uint8_t inner) { return inner != 0; });
  return surface.look.opacity < 1 || (has_inner && surface.inner_look.opacity < 1) ||
         std::any_of(surface.colors.begin(), surface.colors.end(),
                     [](const Eigen::Vector4f& c) { return c.allFinite() && c.w() < 1; });
}

void check(const Surface& surface) {
  const std::size_t count = surface.positions.size();
  check_length(surface, "normals", surface.normals.size(), count, "vertex", "vertices");
  check_length(surface, "rest_positions", surface.rest_positions.size(), count, "vertex",
               "vertices");
  check_length(surface, "burn", surface.burn.size(), count, "vertex", "vertices");
  check_length(surface, "wetness", surface.wetness.size(), count, "vertex", "vertices");
  check_length(surface, "colors", surface.colors.size(), count, "vertex", "vertices");
  check_length(surface, "is_inner", surface.is_inner.size(), surface.triangles.size(), "triangle",
               "triangles");
  check_triangles(surface, surface.triangles, 0, count);
  check_look(surface, surface.look);
  check_look(surface, surface.inner_look);
}

void check(const Surface& surface, const SurfaceChange& change) {
  const std::size_t before = surface.positions.size();
  const std::size_t count = count_after(surface, change);
  if (count < before) {
    refuse(surface, " has " + std::to_string(before) + " vertices and a change has positions of " +
                        std::to_string(count) + "; vertices only come");
  }
  if (change.new_rest_positions.size() != (has_rest(surface) ? count - before : 0) &&
      !(before == 0 && change.new_rest_positions.empty())) {
    refuse(surface, " gets " + std::to_string(count - before) + " new vertices and " +
                        std::to_string(change.new_rest_positions.size()) +
                        " new rest positions; expected one per new vertex where it has rest "
                        "positions, else none");
  }
  std::size_t end = surface.triangles.size();
  for (const SurfaceChange::Triangles& run : change.triangles) {
    check_first(surface, "triangles", run.first, end);
    const std::size_t first = static_cast<std::size_t>(run.first);
    if (!run.is_inner.empty() && run.is_inner.size() != run.values.size()) {
      refuse(surface, ": the run of triangles from " + std::to_string(run.first) + " has " +
                          std::to_string(run.values.size()) + " triangles and " +
                          std::to_string(run.is_inner.size()) + " entries of is_inner");
    }
    check_triangles(surface, run.values, first, count);
    end = std::max(end, first + run.values.size());
  }
  for (const SurfaceChange::Burns& run : change.burns) {
    check_first(surface, "burns", run.first, count);
    if (static_cast<std::size_t>(run.first) + run.values.size() > count) {
      refuse(surface, ": a run of " + std::to_string(run.values.size()) + " burns from vertex " +
                          std::to_string(run.first) + " reaches beyond its " +
                          std::to_string(count) + " vertices");
    }
  }
}

void apply(const SurfaceChange& change, Surface& surface) {
  const std::size_t count = count_after(surface, change);
  if (!change.positions.empty() || !change.triangles.empty()) {
    surface.normals.clear();
  }
  if (!change.positions.empty()) {
    surface.positions.assign(change.positions.begin(), change.positions.end());
  }
  surface.rest_positions.insert(surface.rest_positions.end(), change.new_rest_positions.begin(),
                                change.new_rest_positions.end());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  if (!surface.colors.empty()) {
    surface.colors.resize(count, Eigen::Vector4f::Constant(nan));  // the material's
  }
  if (!surface.wetness.empty()) {
    surface.wetness.resize(count, 0);
  }
  if (!surface.burn.empty() || !change.burns.empty()) {
    surface.burn.resize(count, Eigen::Vector4f::Zero());
  }
  for (const SurfaceChange::Burns& run : change.burns) {
    replace(surface.burn, run.first, run.values);
  }
  surface.is_inner.resize(surface.triangles.size(), 0);
  for (const SurfaceChange::Triangles& run : change.triangles) {
    replace(surface.triangles, run.first, run.values);
    surface.is_inner.resize(surface.triangles.size(), 0);
    const auto inner = surface.is_inner.begin() + run.first;
    if (run.is_inner.empty()) {
      std::fill_n(inner, run.values.size(), std::uint8_t{0});
    } else {
      std::copy(run.is_inner.begin(), run.is_inner.end(), inner);
    }
  }
}

}  // namespace cholecystectomy
