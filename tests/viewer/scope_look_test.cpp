// SPDX-License-Identifier: Apache-2.0
// What the scope does to a picture, and how tissue looks through it.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/viewer/pictures.h"

namespace cholecystectomy {
namespace {

const double kPi = std::acos(-1.0);

/// At an angle and a distance from the middle, in radii of the round picture.
Rgb8 at_polar(const Image& image, double angle, double radius) {
  const double pixels = radius * 0.6 * image.height;
  return image.at(static_cast<int>(image.width / 2.0 + pixels * std::cos(angle)),
                  static_cast<int>(image.height / 2.0 + pixels * std::sin(angle)));
}

}  // namespace

// Would catch a mask that is an ellipse, hard-edged, or lets light out, in either quality.
TEST_CASE("scope: the picture is round with a smooth edge", "[unit][opengl]") {
  const RenderQuality quality = GENERATE(RenderQuality::full(), RenderQuality::quick());
  std::optional<OffscreenRenderer> renderer =
      make_renderer({.width = 400, .height = 240, .quality = quality});
  if (!renderer) {
    SUCCEED("no OpenGL context");
    return;
  }
  SceneView view;
  view.haze = 1;  // light everywhere
  const Image image = renderer->render(view);

  int dimmed = 0;
  for (int degree = -40; degree <= 40; ++degree) {  // above and below, the picture ends first
    for (const double side : {0.0, kPi}) {
      const double angle = side + degree * kPi / 180;
      CHECK(at_polar(image, angle, 1.02) == Rgb8{0, 0, 0});
      const Rgb8 inside = at_polar(image, angle, 0.95);
      CHECK(inside[0] > 60);
      const Rgb8 edge = at_polar(image, angle, 0.988);
      dimmed += edge[0] > 0.1 * inside[0] && edge[0] < 0.9 * inside[0] ? 1 : 0;
    }
  }
  CHECK(dimmed > 100);
}

// Would catch no vignette, one off the middle, and one that depends on the direction.
TEST_CASE("scope: light falls off from the middle, alike in all directions", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  SceneView view;
  view.haze = 1;
  const Image image = renderer->render(view);

  int before = at_polar(image, 0, 0.05)[0];
  for (const double radius : {0.3, 0.5, 0.7, 0.9}) {
    const int here = at_polar(image, 0, radius)[0];
    CHECK(here < before);
    before = here;
    for (int degree = 0; degree < 360; degree += 30) {
      if (radius < 0.8 || std::abs(std::sin(degree * kPi / 180)) < 0.6) {
        CHECK(std::abs(at_polar(image, degree * kPi / 180, radius)[0] - here) <= 3);
      }
    }
  }
}

// Would catch a lamp that stays where it is in the world, or hangs on one of its axes.
TEST_CASE("scope: the lamp comes along, so that what it mirrors stays near the middle",
          "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  for (const Eigen::Vector3f& axis : {Eigen::Vector3f(1, 0, 0), {0, 1, 0}, {1, -2, 2}}) {
    for (const float angle : {0.0f, 1.0f, 2.5f}) {
      const Eigen::Isometry3f motion = Eigen::Translation3f(0.2f * angle, -0.1f, 0.1f) *
                                       Eigen::AngleAxisf(angle, axis.normalized());
      RenderSnapshot snapshot = one_sheet(tissues::liver());
      for (Eigen::Vector3f& p : snapshot.surfaces[0].positions) {
        p = motion * p;
      }
      snapshot.camera.eye = motion * snapshot.camera.eye;
      snapshot.camera.target = motion * snapshot.camera.target;
      snapshot.camera.up = motion.linear() * snapshot.camera.up;
      const Image image = renderer->render(snapshot);
      double most = 0;
      Eigen::Vector2d brightest(0, 0);  // pixels from the middle
      for (int y = 2; y + 2 < kHeight; y += 2) {
        for (int x = 2; x + 2 < kWidth; x += 2) {
          const double green = mean(image, x, y, 2).y();
          if (green > most) {
            most = green;
            brightest = Eigen::Vector2d(x - kWidth / 2, y - kHeight / 2);
          }
        }
      }
      CAPTURE(axis.transpose(), angle, brightest.transpose());
      CHECK(most > 100);
      CHECK(brightest.norm() < 0.12 * kHeight);
    }
  }
}

// Would catch haze that does nothing, colours, or takes as much from what is near as from what is
// far.
TEST_CASE("scope: haze greys and hides, what is far more", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  const auto render_with = [&](float haze) {
    RenderSnapshot snapshot = one_sheet(tissues::liver());
    snapshot.surfaces.push_back(sheet(tissues::liver(), 0.05f, 0.012f));
    snapshot.haze = haze;
    return renderer->render(snapshot);
  };
  const Image clear = render_with(0), thin = render_with(0.3f), thick = render_with(0.95f);
  const auto redness = [](const Image& image, int x, int y) {
    const Eigen::Vector3d color = mean(image, x, y);
    return (color.x() - color.z()) / color.x();
  };
  const int far_x = kWidth / 2 - 60, y = kHeight / 2 + 8;

  CHECK(redness(thin, far_x, y) < 0.9 * redness(clear, far_x, y));
  CHECK(redness(thick, far_x, y) < 0.3 * redness(thin, far_x, y));
  CHECK(redness(thick, kWidth / 2 + 8, y) > 1.5 * redness(thick, far_x, y));
  const Eigen::Vector3d hidden = mean(thick, far_x, y);
  CHECK(hidden.x() - hidden.z() < 0.15 * hidden.x());  // grey-white
  CHECK(hidden.x() > 100);
}

// Would catch a film on char, also where fluid lies on it.
TEST_CASE("scope: healthy tissue shines where the lamp is mirrored, char does not",
          "[unit][opengl]") {
  const RenderQuality quality = GENERATE(RenderQuality::full(), RenderQuality::quick());
  std::optional<OffscreenRenderer> renderer =
      make_renderer({.width = kWidth, .height = kHeight, .quality = quality});
  if (!renderer) {
    SUCCEED("no OpenGL context");
    return;
  }
  const auto brightest = [](const Image& image, int center_x) {
    int best = 0;
    for (int y = kHeight / 2 - 20; y < kHeight / 2 + 20; ++y) {
      for (int x = center_x - 20; x < center_x + 20; ++x) {
        best = std::max(best, static_cast<int>(image.at(x, y)[1]));
      }
    }
    return best;
  };
  RenderSnapshot snapshot = one_sheet(tissues::liver());
  Surface& surface = snapshot.surfaces[0];
  const Image healthy = renderer->render(snapshot);
  surface.wetness.assign(surface.positions.size(), 1);
  surface.burn.assign(surface.positions.size(), {0.03f, 0.025f, 0.02f, 1});
  const Image charred = renderer->render(snapshot);

  CHECK(brightest(healthy, kWidth / 2) > 120);
  CHECK(brightest(healthy, kWidth / 2) > 1.5 * brightest(healthy, kWidth / 2 - 75));
  CHECK(brightest(charred, kWidth / 2) < 0.5 * brightest(healthy, kWidth / 2));
  CHECK(brightest(charred, kWidth / 2) < 1.6 * brightest(charred, kWidth / 2 - 45));
}

TEST_CASE("scope: what is open to the inside looks other than skin", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot snapshot = one_sheet(tissues::fat());
  Surface& surface = snapshot.surfaces[0];
  surface.inner_look = tissues::liver().look;
  for (const pbdsurg::Triangle& triangle : surface.triangles) {
    surface.is_inner.push_back(surface.positions[triangle[0]].x() > 0 ? 1 : 0);
  }
  const Image image = renderer->render(snapshot);
  const auto redness = [&](int x) {
    const Eigen::Vector3d color = mean(image, x, kHeight / 2 + 30);
    return color.x() / color.y();
  };

  CHECK(redness(kWidth / 2 - 50) < 1.5);
  CHECK(redness(kWidth / 2 + 50) > 1.6);
}

// Would catch a shader without one of its variants, and a cheap one that shows another tissue.
TEST_CASE("scope: a quick picture shows what a full one does", "[unit][opengl]") {
  REQUIRE_RENDERER(full);
  std::optional<OffscreenRenderer> quick =
      make_renderer({.width = kWidth, .height = kHeight, .quality = RenderQuality::quick()});
  REQUIRE(quick.has_value());
  for (const pbdsurg::TissueRecord& tissue : tissues::all()) {
    if (tissue.look.opacity < 1) {
      continue;
    }
    const Image expected = full->render(one_sheet(tissue));
    const Image image = quick->render(one_sheet(tissue));
    for (const int x : {kWidth / 2 - 60, kWidth / 2 + 60}) {
      CAPTURE(tissue.name);
      CHECK((mean(image, x, kHeight / 2, 20) - mean(expected, x, kHeight / 2, 20)).norm() < 25);
    }
  }
}

}  // namespace cholecystectomy
