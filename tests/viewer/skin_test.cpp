// SPDX-License-Identifier: Apache-2.0
// The shape of the skin, before a green backdrop.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/viewer/pictures.h"

namespace cholecystectomy {
namespace {

constexpr int kSide = 400;

/// One sample a pixel and the finest skin: what is not covered shows.
OffscreenOptions sharp(int subdivision) {
  RenderQuality quality = RenderQuality::quick();
  quality.subdivision = subdivision;
  return {.width = kSide, .height = kSide, .quality = quality};
}

/// A wide green sheet behind the target, across the view.
Surface backdrop(const Camera& camera) {
  Surface surface = sheet(tissues::fat(), 0, 1);
  const Eigen::Vector3f ahead = camera.target - camera.eye;
  const Eigen::Quaternionf turn =
      Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), -ahead.normalized());
  for (Eigen::Vector3f& p : surface.positions) {
    p = camera.eye + 1.6f * ahead + turn * (4 * ahead.norm() * p);
  }
  surface.look.gloss = 0;
  surface.colors.assign(surface.positions.size(), {0, 1, 0, 1});
  return surface;
}

bool is_covered(const Image& image, int x, int y) {
  const Rgb8 color = image.at(x, y);
  return color[1] <= color[0];
}

/// Whether all pixels within two of it are covered, too.
bool is_well_covered(const Image& image, int x, int y) {
  for (int j = y - 2; j <= y + 2; ++j) {
    for (int i = x - 2; i <= x + 2; ++i) {
      if (!is_covered(image, i, j)) {
        return false;
      }
    }
  }
  return true;
}

Surface boundary_of(const pbdsurg::TetMesh& mesh, const std::vector<pbdsurg::Tet>& tets) {
  Surface surface;
  surface.name = "boundary";
  surface.look = tissues::liver().look;
  for (const Eigen::Vector3d& x : mesh.positions()) {
    surface.positions.push_back(x.cast<float>());
  }
  for (const pbdsurg::BoundaryTriangle& triangle : pbdsurg::find_boundary(tets)) {
    surface.triangles.push_back(triangle.vertices);
  }
  return surface;
}

/// Rings around z with a pole at each end.
Surface coarse_sphere(float radius, int rings, int sectors) {
  Surface surface;
  surface.name = "sphere";
  surface.look = tissues::liver().look;
  const float pi = std::acos(-1.0f);
  surface.positions.push_back({0, 0, radius});
  for (int r = 1; r < rings; ++r) {
    for (int s = 0; s < sectors; ++s) {
      const float polar = pi * static_cast<float>(r) / static_cast<float>(rings);
      const float around = 2 * pi * static_cast<float>(s) / static_cast<float>(sectors);
      surface.positions.push_back(radius * Eigen::Vector3f(std::sin(polar) * std::cos(around),
                                                           std::sin(polar) * std::sin(around),
                                                           std::cos(polar)));
    }
  }
  surface.positions.push_back({0, 0, -radius});
  const auto at = [&](int r, int s) { return 1 + (r - 1) * sectors + s % sectors; };
  const int last = static_cast<int>(surface.positions.size()) - 1;
  for (int s = 0; s < sectors; ++s) {
    surface.triangles.push_back({0, at(1, s), at(1, s + 1)});
    for (int r = 1; r + 1 < rings; ++r) {
      surface.triangles.push_back({at(r, s), at(r + 1, s), at(r, s + 1)});
      surface.triangles.push_back({at(r + 1, s), at(r + 1, s + 1), at(r, s + 1)});
    }
    surface.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
  }
  return surface;
}

}  // namespace

// The far side of a closed surface is not drawn, so that the backdrop shows through any gap. Would
// catch neighbours that do not agree on an edge, a lost or emptied slot, and a side that is taken
// for the other.
TEST_CASE("skin: no hole opens after a thousand random removals", "[property][opengl]") {
  std::optional<OffscreenRenderer> flat = make_renderer(sharp(1));
  std::optional<OffscreenRenderer> curved = make_renderer(sharp(3));
  if (!flat || !curved) {
    SUCCEED("no OpenGL context");
    return;
  }
  static const pbdsurg::CholecystectomyAnatomy anatomy = pbdsurg::make_cholecystectomy_anatomy();
  const pbdsurg::Organ organ = GENERATE(pbdsurg::Organ::gallbladder, pbdsurg::Organ::liver);
  const pbdsurg::TetMesh& mesh = anatomy.organs.at(organ);
  std::vector<pbdsurg::Tet> tets(mesh.tets().begin(), mesh.tets().end());
  for (std::uint64_t i = 0; i < 1000; ++i) {
    std::swap(tets[pbdsurg::random_bits(5, i) % tets.size()], tets.back());
    tets.pop_back();
  }
  const Surface surface = boundary_of(mesh, tets);
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : surface.positions) {
    box.extend(p);
  }

  for (const Eigen::Vector3f& direction : {Eigen::Vector3f(1, 0.1f, 0.2f),
                                           {-1, 0.3f, 0.1f},
                                           {0.1f, 1, 0.2f},
                                           {0.3f, -1, 0.1f},
                                           {0.2f, 0.1f, 1},
                                           {0.1f, 0.3f, -1}}) {
    SceneView view;
    view.camera.target = box.center();
    view.camera.eye = box.center() + 0.9f * box.diagonal().norm() * direction.normalized();
    view.camera.up = {0.3f, 0.5f, 0.8f};
    view.camera.vertical_field_of_view = 0.35f;  // so near that triangles are split
    const std::array surfaces{surface, backdrop(view.camera)};
    flat->set_surfaces(surfaces);
    curved->set_surfaces(surfaces);
    const Image expected = flat->render(view);
    const Image image = curved->render(view);

    int inside = 0, bare = 0, changed = 0;
    for (int y = 2; y + 2 < kSide; ++y) {
      for (int x = 2; x + 2 < kSide; ++x) {
        const double middle = (kSide - 1) / 2.0;
        if (std::hypot(x - middle, y - middle) < 0.56 * kSide && is_well_covered(expected, x, y)) {
          ++inside;
          bare += is_covered(image, x, y) ? 0 : 1;
          changed += image.at(x, y) == expected.at(x, y) ? 0 : 1;
        }
      }
    }
    CHECK(inside > 0.03 * kSide * kSide);
    CHECK(changed > 0.15 * inside);  // else the skin is flat
    CHECK(bare == 0);
  }
}

// Would catch flat parts, bulges and points between parts that are not on the curve.
TEST_CASE("skin: a coarse sphere looks rounder than its triangles", "[unit][opengl]") {
  std::optional<OffscreenRenderer> flat = make_renderer(sharp(1));
  std::optional<OffscreenRenderer> curved = make_renderer(sharp(4));
  if (!flat || !curved) {
    SUCCEED("no OpenGL context");
    return;
  }
  const auto range_of_radius = [](OffscreenRenderer& renderer) {
    SceneView view;
    renderer.set_surfaces(std::array{coarse_sphere(0.035f, 6, 8), backdrop(view.camera)});
    const Image image = renderer.render(view);
    double least = kSide, most = 0;
    for (int degree = 0; degree < 360; degree += 3) {
      const double angle = degree * std::acos(-1.0) / 180;
      double radius = 0;
      while (radius < kSide / 2 - 2 &&
             is_covered(image, static_cast<int>(kSide / 2 + radius * std::cos(angle)),
                        static_cast<int>(kSide / 2 + radius * std::sin(angle)))) {
        radius += 0.25;
      }
      least = std::min(least, radius);
      most = std::max(most, radius);
    }
    CHECK(least > 0.2 * kSide);
    return most - least;
  };

  const double coarse = range_of_radius(*flat);
  const double fine = range_of_radius(*curved);

  CHECK(coarse > 6);  // pixels: a cosine of 22.5 degrees of about 115
  CHECK(fine < 0.4 * coarse);
}

TEST_CASE("skin: of what is closed the inside is seen from inside", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = coarse_sphere(0.2f, 12, 16);  // around the eye
  renderer->set_surfaces(std::array{surface});
  CHECK(mean(renderer->render(SceneView{}), kWidth / 2 + 30, kHeight / 2).x() > 40);
  for (pbdsurg::Triangle& triangle : surface.triangles) {
    std::swap(triangle[0], triangle[1]);
  }
  renderer->set_surfaces(std::array{surface});
  CHECK(mean(renderer->render(SceneView{}), kWidth / 2 + 30, kHeight / 2).x() > 40);
}

// Would catch fronts and backs that are mixed up for a surface that is wound inwards.
TEST_CASE("skin: a closed surface that is wound inwards shows its near side", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = coarse_sphere(0.03f, 12, 16);
  renderer->set_surfaces(std::array{surface});
  const Image outwards = renderer->render(SceneView{});
  for (pbdsurg::Triangle& triangle : surface.triangles) {
    std::swap(triangle[1], triangle[2]);
  }
  renderer->set_surfaces(std::array{surface});
  const Image inwards = renderer->render(SceneView{});

  for (const int x : {kWidth / 2, kWidth / 2 + 25}) {
    CHECK((mean(outwards, x, kHeight / 2 + 10) - mean(inwards, x, kHeight / 2 + 10)).norm() < 15);
  }
}

}  // namespace cholecystectomy
