// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/figure8.h"

#include "pbdsurg/mesh/topology.h"

#include "apps/viewer/montage.h"
#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#include "apps/viewer/tube.h"
#include "bench/table1/colorings.h"
#include "bench/table1/palette.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::CaptionedImage;
using cholecystectomy::Image;
using cholecystectomy::RenderSnapshot;
using cholecystectomy::Surface;

constexpr float kLineWidth = 0.2F;  // of the mean length of edges on the surface
constexpr float kShrink = 0.84F;    // of a tetrahedron around its middle

std::vector<Eigen::Vector4f> colors_of(const Coloring& coloring) {
  const std::vector<Eigen::Vector3f> palette = distinct_colors(coloring.color_count);
  std::vector<Eigen::Vector4f> colors;
  for (const Index color : coloring.color_of) {
    colors.push_back(palette[color].homogeneous());
  }
  return colors;
}

// The organ lies along x; seen from its side and a little from above.
RenderSnapshot empty_figure(const TetMesh& mesh) {
  const Eigen::AlignedBox3f box = bounding_box(mesh).cast<float>();
  RenderSnapshot figure;
  figure.style = cholecystectomy::Style::figure;
  figure.camera.target = box.center();
  figure.camera.eye = box.center() + 3.6F * box.sizes().x() * Eigen::Vector3f(0.1F, -1, 0.35F);
  figure.camera.up = {0, 0, 1};
  figure.camera.vertical_field_of_view = 0.127F;
  figure.camera.light_offset = {-0.1F, 0.15F, 0};
  return figure;
}

// A pale organ just under its edges hides those behind.
RenderSnapshot draw_edges(const Sample& sample, const Coloring& coloring) {
  Surface ground;
  ground.name = "ground";
  for (const Eigen::Vector3d& x : sample.mesh.positions()) {
    ground.positions.push_back(x.cast<float>());
  }
  const std::vector<Eigen::Vector3f> ends = ground.positions;
  float length = 0;
  for (const BoundaryTriangle& triangle : find_boundary(sample.mesh.tets())) {
    ground.triangles.push_back(triangle.vertices);
    length += (ends[triangle.vertices[0]] - ends[triangle.vertices[1]]).norm();
  }
  const float width = kLineWidth * length / static_cast<float>(ground.triangles.size());
  const auto normals = cholecystectomy::vertex_normals(ends, ground.triangles);
  for (std::size_t v = 0; v < ends.size(); ++v) {
    ground.positions[v] -= width * normals[v];
  }
  ground.colors.assign(ends.size(), {0.96F, 0.96F, 0.94F, 1});

  RenderSnapshot figure = empty_figure(sample.mesh);
  figure.surfaces.push_back(std::move(ground));
  const std::vector<Eigen::Vector4f> colors = colors_of(coloring);
  for (std::size_t e = 0; e < sample.edges.size(); ++e) {
    const auto [a, b] = sample.edges[e];
    figure.strands.push_back({ends[a], ends[b], colors[e], width});
  }
  return figure;
}

// Flat sides: each triangle has its own corners.
RenderSnapshot draw_tets(const Sample& sample, const Coloring& coloring) {
  RenderSnapshot figure = empty_figure(sample.mesh);
  const auto positions = sample.mesh.positions();
  const auto tets = sample.mesh.tets();
  const std::vector<Eigen::Vector4f> colors = colors_of(coloring);
  const double cut = bounding_box(sample.mesh).center().y();
  Surface surface;
  surface.name = "tetrahedra";
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const auto& [a, b, c, d] = tets[t];
    const Eigen::Vector3d middle = (positions[a] + positions[b] + positions[c] + positions[d]) / 4;
    if (middle.y() < cut) {
      continue;
    }
    for (const std::array<int, 3>& triangle : kTetTriangles) {
      const auto first = static_cast<Index>(surface.positions.size());
      for (const int corner : triangle) {
        const Eigen::Vector3f offset = (positions[tets[t][corner]] - middle).cast<float>();
        surface.positions.push_back(middle.cast<float>() + kShrink * offset);
        surface.colors.push_back(colors[t]);
      }
      surface.triangles.push_back({first, first + 1, first + 2});
    }
  }
  figure.surfaces.push_back(std::move(surface));
  return figure;
}

}  // namespace

std::filesystem::path draw_figure8(const Sample& sample, const std::filesystem::path& folder) {
  cholecystectomy::OffscreenRenderer renderer({.width = 1200, .height = 540});
  const std::string figure = std::string("figure8_") + name_of(sample.kind);
  std::vector<CaptionedImage> pictures;
  for (const ColoringOptions& options :
       {ColoringOptions{}, ColoringOptions{.algorithm = ColoringAlgorithm::luby},
        ColoringOptions{.algorithm = ColoringAlgorithm::random_disc},
        ColoringOptions{
            .algorithm = ColoringAlgorithm::random_disc, .repair = true, .balance = true}}) {
    const auto add = [&](const char* constraints, const Coloring& coloring,
                         const RenderSnapshot& snapshot) {
      const Image image = renderer.render(snapshot);
      const std::string algorithm = name_of(options.algorithm);
      const std::string file = figure + "_" + algorithm + (options.repair ? "_repair" : "") +
                               (options.balance ? "_balance" : "") + "_" + constraints + ".png";
      write_png(folder / file, image);
      pictures.push_back({algorithm + (options.repair ? " + repair" : "") +
                              (options.balance ? " + balance" : "") + ", " + constraints + ": " +
                              std::to_string(coloring.color_count) + " colours",
                          image});
    };
    const Coloring edges = color_validly(sample.edge_constraints(), options);
    add("distance", edges, draw_edges(sample, edges));
    const Coloring tets = color_validly(sample.tet_constraints(), options);
    add("volume", tets, draw_tets(sample, tets));
  }
  const std::filesystem::path path = folder / (figure + ".png");
  write_png(path, cholecystectomy::make_montage(pictures, 2));
  return path;
}

}  // namespace pbdsurg::bench
