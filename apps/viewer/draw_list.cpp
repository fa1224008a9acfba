// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/draw_list.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "apps/viewer/tube.h"

namespace cholecystectomy {
namespace {

/// Triangles with their distance from the eye.
struct TriangleList {
  struct Entry {
    float distance;  ///< squared, to the middle
    std::array<std::uint32_t, 3> vertices;
  };
  std::vector<Entry> entries;

  /// Indices, farthest first. The sort is stable: ties keep the order of the view.
  [[nodiscard]] std::vector<std::uint32_t> sorted() {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.distance > b.distance; });
    return in_order();
  }

  [[nodiscard]] std::vector<std::uint32_t> in_order() const {
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
  Builder(const SceneView& view, std::span<const Surface* const> surfaces) : eye_(view.camera.eye) {
    for (const Surface* surface : surfaces) {
      add(*surface);
    }
    for (const Surface& sheet : view.sheets) {
      check(sheet);
      add(sheet);
    }
    for (const Tool& tool : view.tools) {
      for (const ToolPart& part : tool.parts) {
        add(part);
      }
    }
    add(view.strands);
    add(view.smoke, view.camera);
    list_.tissue = tissue_.in_order();
    list_.tools = tools_.in_order();
    list_.blended = blended_.sorted();
    list_.smoke = smoke_.sorted();
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

  std::int32_t add_material(const DrawMaterial& material) {
    list_.materials.push_back(material);
    return static_cast<std::int32_t>(list_.materials.size()) - 1;
  }

  [[nodiscard]] std::uint32_t next_vertex() const {
    return static_cast<std::uint32_t>(list_.vertices.size());
  }

  /// All vertices with one look, then its triangles.
  void add(const Surface& surface, const std::vector<Eigen::Vector3f>& normals, bool inner) {
    const std::int32_t material =
        add_material(material_of(inner ? surface.inner_look : surface.look));
    const std::uint32_t first = next_vertex();
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      const Eigen::Vector3f& rest =
          surface.rest_positions.empty() ? surface.positions[v] : surface.rest_positions[v];
      list_.vertices.push_back(
          {surface.positions[v], normals[v], rest.allFinite() ? rest : Eigen::Vector3f::Zero(),
           color_at(surface, v), burn_at(surface, v), wetness_at(surface, v), material});
    }
    const float opacity = list_.materials.back().color.w();
    const auto alpha = [&](std::uint32_t v) {
      const float replaced = list_.vertices[v].color.w();
      return replaced >= 0 ? replaced : opacity;
    };
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const pbdsurg::Triangle& triangle = surface.triangles[t];
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0] ||
          inner != (!surface.is_inner.empty() && surface.is_inner[t] != 0)) {
        continue;
      }
      const std::uint32_t a = first + static_cast<std::uint32_t>(triangle[0]);
      const std::uint32_t b = first + static_cast<std::uint32_t>(triangle[1]);
      const std::uint32_t c = first + static_cast<std::uint32_t>(triangle[2]);
      add_triangle(a, b, c, std::min({alpha(a), alpha(b), alpha(c)}) < 1 ? blended_ : tissue_);
    }
  }

  void add(const Surface& surface) {
    const std::vector<Eigen::Vector3f> normals =
        surface.normals.empty() ? vertex_normals(surface.positions, surface.triangles)
                                : surface.normals;
    add(surface, normals, false);
    if (std::any_of(surface.is_inner.begin(), surface.is_inner.end(),
                    [](std::uint8_t inner) { return inner != 0; })) {
      add(surface, normals, true);
    }
  }

  void add(const ToolPart& part) {
    const TriangleMesh tube = sweep_tube(part.points, part.radii);
    const std::int32_t material =
        add_material(material_of({}, part.finish == ToolFinish::insulation));
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
    const std::int32_t material = add_material(material_of(look));
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
    const std::int32_t material = add_material(material_of({}));
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

DrawList make_draw_list(const SceneView& view, std::span<const Surface* const> surfaces) {
  return Builder(view, surfaces).take();
}

}  // namespace cholecystectomy
