// SPDX-License-Identifier: Apache-2.0
// Figure 8 of Pan et al. 2020: the organ with each constraint in its colour.
#include <cstdio>
#include <filesystem>
#include <list>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#include "apps/viewer/tube.h"
#include "bench/support/program.h"
#include "bench/support/sample.h"
#include "bench/support/table_files.h"
#include "bench/table1/colorings.h"
#include "bench/table1/palette.h"

namespace pbdsurg::bench {
namespace {

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

// Edges as lines, tetrahedra shrunken and cut open, for each of four colourings.
// @param pictures  gets a row for each: its place in the figure, file and caption
void draw(const Sample& sample, cholecystectomy::OffscreenRenderer& renderer,
          const std::filesystem::path& folder, Json& pictures) {
  const std::string figure = std::string("figure8_") + name_of(sample.kind);
  int row = 0;
  for (const ColoringOptions& options :
       {ColoringOptions{}, ColoringOptions{.algorithm = ColoringAlgorithm::luby},
        ColoringOptions{.algorithm = ColoringAlgorithm::random_disc},
        ColoringOptions{
            .algorithm = ColoringAlgorithm::random_disc, .repair = true, .balance = true}}) {
    const std::string algorithm = name_of(options.algorithm);
    const auto add = [&](int column, const std::string& constraints, const Coloring& coloring,
                         const RenderSnapshot& snapshot) {
      const std::string file = figure + "_" + algorithm + (options.repair ? "_repair" : "") +
                               (options.balance ? "_balance" : "") + "_" + constraints + ".png";
      write_png(folder / file, renderer.render(snapshot));
      pictures.push_back({{"figure", figure},
                          {"row", row},
                          {"column", column},
                          {"picture", file},
                          {"caption", algorithm + (options.repair ? " + repair" : "") +
                                          (options.balance ? " + balance" : "") + ": " +
                                          constraints + " constraints in " +
                                          std::to_string(coloring.color_count) + " colours"}});
    };
    const Coloring edges = color_validly(sample.edge_constraints(), options);
    add(0, "distance", edges, draw_edges(sample, edges));
    const Coloring tets = color_validly(sample.tet_constraints(), options);
    add(1, "volume", tets, draw_tets(sample, tets));
    ++row;
  }
}

void run(const std::filesystem::path& out, bool is_quick) {
  try {
    cholecystectomy::OffscreenRenderer renderer({.width = 1200, .height = 540});
    std::vector<std::string> notes;
    const std::list<Sample> samples =
        is_quick ? make_samples({1}, {Table2Kind::hollow}, notes)
                 : make_samples({2}, {Table2Kind::hollow, Table2Kind::surface_filled}, notes);
    for (const std::string& note : notes) {
      std::printf("%s\n", note.c_str());
    }
    Json pictures = Json::array();
    for (const Sample& sample : samples) {
      draw(sample, renderer, out, pictures);
    }
    const std::filesystem::path path = out / "figure8_pictures.csv";
    write_text(path, to_csv(pictures));
    std::printf("wrote %zu pictures and %s\n", pictures.size(), path.c_str());
  } catch (const BackendUnavailable& error) {
    std::printf("no pictures: %s\n", error.what());
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Figure 8: the organ with each constraint in its colour.", "figure8");
  std::filesystem::path out = "out/tables";
  bool is_quick = false;
  app.add_flag("--quick", is_quick, "the smallest mesh alone: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, out,
                                     [&] { pbdsurg::bench::run(out, is_quick); });
}
