// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/draw_list.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "apps/viewer/tube.h"

namespace cholecystectomy {
namespace {

const Eigen::Vector4f kMaterialColor(0, 0, 0, -1);

float linear_of_srgb(float value) {
  const float v = std::clamp(value, 0.0f, 1.0f);
  return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
}

Eigen::Vector4f linear_of_srgb(const Eigen::Vector3f& color, float alpha) {
  return {linear_of_srgb(color.x()), linear_of_srgb(color.y()), linear_of_srgb(color.z()),
          std::clamp(alpha, 0.0f, 1.0f)};
}

void check_length(const Surface& surface, const char* array, std::size_t length) {
  if (length != 0 && length != surface.positions.size()) {
    throw pbdsurg::InvalidArgument("surface '" + surface.name + "' has " +
                                   std::to_string(surface.positions.size()) + " vertices and " +
                                   std::to_string(length) + " entries of " + array +
                                   "; expected none or one per vertex");
  }
}

void check(const Surface& surface) {
  check_length(surface, "normals", surface.normals.size());
  check_length(surface, "rest_positions", surface.rest_positions.size());
  check_length(surface, "burn", surface.burn.size());
  check_length(surface, "wetness", surface.wetness.size());
  check_length(surface, "colors", surface.colors.size());
  const pbdsurg::Index count = static_cast<pbdsurg::Index>(surface.positions.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const pbdsurg::Index v : surface.triangles[t]) {
      if (v < 0 || v >= count) {
        throw pbdsurg::InvalidArgument(
            "surface '" + surface.name + "': triangle " + std::to_string(t) + " refers to vertex " +
            std::to_string(v) + "; ids must be in [0, " + std::to_string(count) + ")");
      }
    }
  }
}

/// Absent or not finite is dry.
float wetness_at(const Surface& surface, std::size_t v) {
  return surface.wetness.empty() || !std::isfinite(surface.wetness[v])
             ? 0.0f
             : std::clamp(surface.wetness[v], 0.0f, 1.0f);
}

/// Absent or not finite is unburnt.
Eigen::Vector4f burn_at(const Surface& surface, std::size_t v) {
  if (surface.burn.empty() || !surface.burn[v].allFinite()) {
    return Eigen::Vector4f::Zero();
  }
  Eigen::Vector4f layer = linear_of_srgb(surface.burn[v].head<3>(), surface.burn[v].w());
  layer.head<3>() *= layer.w();
  return layer;
}

/// Triangles with their distance from the eye.
struct TriangleList {
  struct Entry {
    float distance;  ///< squared, to the middle
    std::array<std::uint32_t, 3> vertices;
  };
  std::vector<Entry> entries;

  /// Indices by distance. The sort is stable: ties keep the order of the snapshot.
  template <class Order>
  [[nodiscard]] std::vector<std::uint32_t> sorted(Order order) {
    std::stable_sort(entries.begin(), entries.end(), [order](const Entry& a, const Entry& b) {
      return order(a.distance, b.distance);
    });
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * entries.size());
    for (const Entry& entry : entries) {
      indices.insert(indices.end(), entry.vertices.begin(), entry.vertices.end());
    }
    return indices;
  }
};

class Builder {
 public:
  explicit Builder(const RenderSnapshot& snapshot) : eye_(snapshot.camera.eye) {
    for (const Surface& surface : snapshot.surfaces) {
      add(surface);
    }
    for (const Tool& tool : snapshot.tools) {
      for (const ToolPart& part : tool.parts) {
        add(part);
      }
    }
    add(snapshot.strands);
    add(snapshot.smoke, snapshot.camera);
    // nearest first, so that hidden tissue fails the depth test before it is shaded
    list_.tissue = tissue_.sorted(std::less<>());
    list_.tools = tools_.sorted(std::less<>());
    list_.blended = blended_.sorted(std::greater<>());
    list_.smoke = smoke_.sorted(std::greater<>());
    float farthest = 0;
    for (const DrawVertex& vertex : list_.vertices) {
      if (vertex.position.allFinite()) {
        farthest = std::max(farthest, (vertex.position - eye_).squaredNorm());
      }
    }
    list_.farthest = std::sqrt(farthest);
  }

  DrawList take() { return std::move(list_); }

 private:
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, TriangleList& triangles) {
    const Eigen::Vector3f middle =
        (list_.vertices[a].position + list_.vertices[b].position + list_.vertices[c].position) / 3;
    if (middle.allFinite()) {
      triangles.entries.push_back({(middle - eye_).squaredNorm(), {a, b, c}});
    }
  }

  std::int32_t add_material(const pbdsurg::TissueLook& look, bool insulation = false) {
    DrawMaterial material;
    material.color = linear_of_srgb(look.color, look.opacity);
    material.mottle = linear_of_srgb(look.mottle, 1);
    material.surface = {look.gloss, look.detail_size, look.relief, insulation ? 1.0f : 0.0f};
    material.pattern = {look.lobules, look.vessels, 0, 0};
    list_.materials.push_back(material);
    return static_cast<std::int32_t>(list_.materials.size()) - 1;
  }

  [[nodiscard]] std::uint32_t next_vertex() const {
    return static_cast<std::uint32_t>(list_.vertices.size());
  }

  void add(const Surface& surface) {
    check(surface);
    if (!(surface.look.detail_size > 0) || !std::isfinite(surface.look.detail_size)) {
      throw pbdsurg::InvalidArgument("surface '" + surface.name + "': the detail size is " +
                                     std::to_string(surface.look.detail_size) +
                                     " m; it must be positive and finite");
    }
    const std::int32_t material = add_material(surface.look);
    const std::uint32_t first = next_vertex();
    const std::vector<Eigen::Vector3f> normals =
        surface.normals.empty() ? vertex_normals(surface.positions, surface.triangles)
                                : surface.normals;
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      const Eigen::Vector3f& rest =
          surface.rest_positions.empty() ? surface.positions[v] : surface.rest_positions[v];
      const bool colored = !surface.colors.empty() && surface.colors[v].allFinite();
      list_.vertices.push_back(
          {surface.positions[v], normals[v], rest.allFinite() ? rest : Eigen::Vector3f::Zero(),
           colored ? linear_of_srgb(surface.colors[v].head<3>(), surface.colors[v].w())
                   : kMaterialColor,
           burn_at(surface, v), wetness_at(surface, v), material});
    }
    const float opacity = list_.materials.back().color.w();
    const auto alpha = [&](std::uint32_t v) {
      const float replaced = list_.vertices[v].color.w();
      return replaced >= 0 ? replaced : opacity;
    };
    for (const pbdsurg::Triangle& triangle : surface.triangles) {
      const std::uint32_t a = first + static_cast<std::uint32_t>(triangle[0]);
      const std::uint32_t b = first + static_cast<std::uint32_t>(triangle[1]);
      const std::uint32_t c = first + static_cast<std::uint32_t>(triangle[2]);
      add_triangle(a, b, c, std::min({alpha(a), alpha(b), alpha(c)}) < 1 ? blended_ : tissue_);
    }
  }

  void add(const ToolPart& part) {
    const TriangleMesh tube = sweep_tube(part.points, part.radii);
    const std::int32_t material = add_material({}, part.finish == ToolFinish::insulation);
    const std::uint32_t first = next_vertex();
    const std::vector<Eigen::Vector3f> normals = vertex_normals(tube.positions, tube.triangles);
    for (std::size_t v = 0; v < tube.positions.size(); ++v) {
      list_.vertices.push_back({tube.positions[v], normals[v], tube.positions[v], kMaterialColor,
                                Eigen::Vector4f::Zero(), 0, material});
    }
    for (const pbdsurg::Triangle& triangle : tube.triangles) {
      add_triangle(first + static_cast<std::uint32_t>(triangle[0]),
                   first + static_cast<std::uint32_t>(triangle[1]),
                   first + static_cast<std::uint32_t>(triangle[2]), tools_);
    }
  }

  void add_quad(std::uint32_t first, TriangleList& triangles) {
    add_triangle(first, first + 1, first + 2, triangles);
    add_triangle(first, first + 2, first + 3, triangles);
  }

  /// Ribbons that face the eye, with the normals of a rounded fibre.
  void add(const std::vector<Strand>& strands) {
    if (strands.empty()) {
      return;
    }
    pbdsurg::TissueLook look;
    look.gloss = 0.8f;
    look.detail_size = 0.002f;
    look.relief = 0.2f;
    look.mottle = look.color;
    const std::int32_t material = add_material(look);
    for (const Strand& strand : strands) {
      const Eigen::Vector3f to_eye = eye_ - (strand.from + strand.to) / 2;
      const Eigen::Vector3f across = (strand.to - strand.from).cross(to_eye);
      // zero for a strand without length or along the line of sight: nothing to see
      if (!(across.squaredNorm() > 0) || !across.allFinite() || !strand.color.allFinite()) {
        continue;
      }
      const Eigen::Vector3f side = across.normalized();
      const Eigen::Vector3f front = side.cross(strand.to - strand.from).normalized();
      const Eigen::Vector4f color = linear_of_srgb(strand.color.head<3>(), strand.color.w());
      const std::uint32_t first = next_vertex();
      const std::array<std::pair<const Eigen::Vector3f*, float>, 4> corners{
          {{&strand.from, -0.5f}, {&strand.from, 0.5f}, {&strand.to, 0.5f}, {&strand.to, -0.5f}}};
      for (const auto& [end, offset] : corners) {
        const Eigen::Vector3f position = *end + offset * strand.thickness * side;
        list_.vertices.push_back({position, (front + 2 * offset * side).normalized(), position,
                                  color, Eigen::Vector4f::Zero(), 0, material});
      }
      add_quad(first, color.w() < 1 ? blended_ : tissue_);
    }
  }

  void add(const std::vector<SmokePuff>& smoke, const Camera& camera) {
    if (smoke.empty()) {
      return;
    }
    const std::int32_t material = add_material({});
    for (std::size_t i = 0; i < smoke.size(); ++i) {
      const Eigen::Vector3f to_eye = (eye_ - smoke[i].center).normalized();
      const Eigen::Vector3f right = camera.up.cross(to_eye).normalized();
      const Eigen::Vector3f up = to_eye.cross(right);
      const Eigen::Vector4f color =
          linear_of_srgb(Eigen::Vector3f(0.86f, 0.85f, 0.84f), smoke[i].opacity);
      const std::uint32_t first = next_vertex();
      for (const auto& [x, y] : {std::pair{-1.f, -1.f}, {1.f, -1.f}, {1.f, 1.f}, {-1.f, 1.f}}) {
        list_.vertices.push_back({smoke[i].center + smoke[i].radius * (x * right + y * up), to_eye,
                                  Eigen::Vector3f(x, y, static_cast<float>(i)), color,
                                  Eigen::Vector4f::Zero(), smoke[i].radius, material});
      }
      add_quad(first, smoke_);
    }
  }

  Eigen::Vector3f eye_;
  DrawList list_;
  TriangleList tissue_;
  TriangleList tools_;
  TriangleList blended_;
  TriangleList smoke_;
};

}  // namespace

DrawList make_draw_list(const RenderSnapshot& snapshot) {
  return Builder(snapshot).take();
}

}  // namespace cholecystectomy
