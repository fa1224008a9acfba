// SPDX-License-Identifier: Apache-2.0
#include "bench/figure4/picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/topology.h"

#include "apps/viewer/instruments.h"
#include "apps/viewer/tube.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::RenderSnapshot;
using cholecystectomy::Surface;

constexpr double kWarm = kBodyTemperature + 0.25;  // degrees Celsius

std::vector<Eigen::Vector3f> positions_of(const TetMesh& mesh) {
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : mesh.positions()) {
    positions.push_back(x.cast<float>());
  }
  return positions;
}

std::vector<Triangle> triangles_of(const LiveSurface& surface) {
  std::vector<Triangle> triangles;
  std::ranges::copy_if(surface.triangles(), std::back_inserter(triangles),
                       [](const Triangle& t) { return t != LiveSurface::kEmptyTriangle; });
  return triangles;
}

// The texels of a slot's tile within its triangle, every `stride`, as rows of falling length.
template <class Visit>
void visit_texels(Index texels, Index stride, Visit visit) {
  for (Index j = 0; j < texels; j += stride) {
    for (Index i = 0; i + j < texels; i += stride) {
      visit(i, j);
    }
  }
}

// Triangles between these texels, numbered as they were visited from `first` on.
void add_triangles(Index rows, Index first, std::vector<Triangle>& triangles) {
  for (Index row = rows; row > 1; --row) {
    const Index next = first + row;
    for (Index i = 0; i + 1 < row; ++i) {
      triangles.push_back({first + i, first + i + 1, next + i});
      if (i + 2 < row) {
        triangles.push_back({first + i + 1, next + i + 1, next + i});
      }
    }
    first = next;
  }
}

// The surface with a vertex at each texel: positions, normals, triangles; texel k of the result is
// `texel_of[k]` of the texture.
struct TexelMesh {
  Surface surface;
  std::vector<std::size_t> texel_of;
};

TexelMesh make_texel_mesh(const TetMesh& mesh, const Burn& burn) {
  const std::vector<Eigen::Vector3f> positions = positions_of(mesh);
  const auto normals = cholecystectomy::vertex_normals(positions, triangles_of(burn.surface()));
  const Index n = burn.texture().texels();
  const auto temperatures = burn.texture().temperatures();
  TexelMesh result;
  result.surface.name = "gallbladder";
  for (Index slot = 0; slot < burn.surface().slot_count(); ++slot) {
    const Triangle& corners = burn.surface().triangles()[slot];
    if (corners == LiveSurface::kEmptyTriangle) {
      continue;
    }
    const std::size_t tile = static_cast<std::size_t>(slot) * static_cast<std::size_t>(n * n);
    const bool is_warm =
        std::max({temperatures[tile], temperatures[tile + static_cast<std::size_t>(n - 1)],
                  temperatures[tile + static_cast<std::size_t>(n * (n - 1))]}) > kWarm;
    const Index stride = is_warm ? 1 : n - 1;
    const auto first = static_cast<Index>(result.texel_of.size());
    visit_texels(n, stride, [&](Index i, Index j) {
      const float u = static_cast<float>(i) / static_cast<float>(n - 1);
      const float v = static_cast<float>(j) / static_cast<float>(n - 1);
      const auto between = [&](const std::vector<Eigen::Vector3f>& values) -> Eigen::Vector3f {
        return (1 - u - v) * values[corners[0]] + u * values[corners[1]] + v * values[corners[2]];
      };
      result.surface.positions.push_back(between(positions));
      result.surface.normals.push_back(between(normals).normalized());
      result.texel_of.push_back(tile + static_cast<std::size_t>(i + n * j));
    });
    add_triangles((n - 1) / stride + 1, first, result.surface.triangles);
  }
  return result;
}

// Its foot lies on the tissue, its shaft leaves to the upper right of the picture.
Eigen::Isometry3f hook_pose(const Viewpoint& view) {
  const Eigen::Vector3f right = view.normal.cross(Eigen::Vector3f::UnitZ()).normalized();
  const Eigen::Vector3f up = right.cross(view.normal);
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.linear().col(2) = (0.55F * view.normal - 0.7F * right + 0.45F * up).normalized();
  pose.linear().col(1) = view.normal.cross(pose.linear().col(2)).normalized();
  pose.linear().col(0) = pose.linear().col(1).cross(pose.linear().col(2));
  pose.translation() = view.tip + 0.0004F * view.normal;
  return pose;
}

}  // namespace

Viewpoint choose_viewpoint(const TetMesh& gallbladder) {
  const Eigen::AlignedBox3d box = bounding_box(gallbladder);
  const Eigen::Vector3d aim(box.min().x() + 0.4 * box.sizes().x(), box.center().y(),
                            box.center().z());
  const Eigen::Vector3d from = aim + box.sizes().x() * Eigen::Vector3d(0, -0.6, -1);
  std::vector<Triangle> triangles;
  for (const BoundaryTriangle& triangle : find_boundary(gallbladder.tets())) {
    triangles.push_back(triangle.vertices);
  }
  const auto normals = cholecystectomy::vertex_normals(positions_of(gallbladder), triangles);
  const auto nearest = std::ranges::min_element(
      gallbladder.positions(),
      [&](const auto& a, const auto& b) { return (a - from).norm() < (b - from).norm(); });
  return {nearest->cast<float>(),
          normals[static_cast<std::size_t>(nearest - gallbladder.positions().begin())]};
}

RenderSnapshot draw_burn(const TetMesh& gallbladder, const Burn& burn, const Viewpoint& view,
                         bool is_close, const TexelColor& color_of) {
  TexelMesh mesh = make_texel_mesh(gallbladder, burn);
  for (const std::size_t texel : mesh.texel_of) {
    const Color color =
        color_of(burn.texture().temperatures()[texel], burn_marks(burn.texture().marks()[texel]));
    mesh.surface.colors.emplace_back(color.red, color.green, color.blue, 1);
  }
  RenderSnapshot snapshot;
  snapshot.style = cholecystectomy::Style::figure;
  snapshot.surfaces.push_back(std::move(mesh.surface));
  snapshot.tools.push_back(cholecystectomy::draw_hook(hook_pose(view)));
  cholecystectomy::Camera& camera = snapshot.camera;
  camera.target = is_close ? view.tip : bounding_box(gallbladder).center().cast<float>();
  camera.eye = camera.target + (is_close ? 0.06F : 0.22F) * view.normal;
  camera.up = -Eigen::Vector3f::UnitZ();
  camera.vertical_field_of_view = is_close ? 0.3F : 0.33F;
  camera.light_offset = {-0.02F, 0.03F, 0};
  return snapshot;
}

double surface_above(const TetMesh& gallbladder, const Burn& burn, double temperature) {
  const TexelMesh mesh = make_texel_mesh(gallbladder, burn);
  const auto& positions = mesh.surface.positions;
  double area = 0;
  for (const auto& [a, b, c] : mesh.surface.triangles) {
    const auto at = [&](Index v) { return burn.texture().temperatures()[mesh.texel_of[v]]; };
    if (at(a) + at(b) + at(c) >= 3 * temperature) {
      area += 0.5F * (positions[b] - positions[a]).cross(positions[c] - positions[a]).norm();
    }
  }
  return area;
}

}  // namespace pbdsurg::bench
