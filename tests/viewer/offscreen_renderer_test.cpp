// SPDX-License-Identifier: Apache-2.0
// Pictures are judged by their structure, never by their exact pixels: drivers differ.
#include "apps/viewer/offscreen_renderer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "tests/viewer/pictures.h"

namespace cholecystectomy {

TEST_CASE("renderer: tissue fills the round picture and its corners are black", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);

  const Image image = renderer->render(one_sheet(tissues::liver()));

  REQUIRE(image.rgb.size() == 3u * kWidth * kHeight);
  for (const auto& [x, y] : {std::pair{0, 0},
                             {kWidth - 1, 0},
                             {0, kHeight - 1},
                             {kWidth - 1, kHeight - 1},
                             {4, kHeight / 2}}) {
    CHECK(image.at(x, y) == Rgb8{0, 0, 0});
  }
  const Eigen::Vector3d liver = mean(image, kWidth / 2, kHeight / 4);
  CHECK(liver.x() > 40);
  CHECK(liver.x() > 1.5 * liver.y());  // red-brown
}

TEST_CASE("renderer: the light sits at the scope, so the middle shines", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);

  const Image image = renderer->render(one_sheet(tissues::liver()));

  const auto brightest = [&](int center_x) {
    int best = 0;
    for (int y = kHeight / 2 - 20; y < kHeight / 2 + 20; ++y) {
      for (int x = center_x - 20; x < center_x + 20; ++x) {
        best = std::max(best, static_cast<int>(image.at(x, y)[1]));
      }
    }
    return best;
  };
  CHECK(brightest(kWidth / 2) > 1.5 * brightest(kWidth / 2 - 75));
  CHECK(brightest(kWidth / 2) > 1.5 * brightest(kWidth / 2 + 75));
}

TEST_CASE("renderer: a pale burn is paler, a dark one darker than healthy tissue",
          "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot snapshot = one_sheet(tissues::liver());
  Surface& surface = snapshot.surfaces[0];
  for (const Eigen::Vector3f& p : surface.positions) {
    surface.burn.emplace_back(p.x() > 0.01f    ? Eigen::Vector4f(0.86f, 0.8f, 0.7f, 1)
                              : p.x() < -0.01f ? Eigen::Vector4f(0.03f, 0.03f, 0.02f, 1)
                                               : Eigen::Vector4f::Zero());
  }

  const Image healthy = renderer->render(one_sheet(tissues::liver()));
  const Image burnt = renderer->render(snapshot);

  const int left = kWidth / 2 - 50, right = kWidth / 2 + 50, row = kHeight / 2 + 30;
  CHECK(mean(burnt, left, row).sum() < 0.5 * mean(healthy, left, row).sum());
  CHECK(mean(burnt, right, row).sum() > 1.3 * mean(healthy, right, row).sum());
}

TEST_CASE("renderer: what is nearer hides what is behind, in any order", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot snapshot;
  snapshot.surfaces = {sheet(tissues::fat(), 0, 0.1f), sheet(tissues::liver(), 0.02f, 0.012f)};
  for (Surface& surface : snapshot.surfaces) {
    surface.look.gloss = 0;  // no highlight over the colours
  }
  if (GENERATE(false, true)) {
    std::swap(snapshot.surfaces[0], snapshot.surfaces[1]);
  }

  const Image image = renderer->render(snapshot);

  const Eigen::Vector3d middle = mean(image, kWidth / 2, kHeight / 2 + 8, 2);
  const Eigen::Vector3d beside = mean(image, kWidth / 2 - 60, kHeight / 2);
  CHECK(middle.y() < 0.6 * middle.x());  // liver
  CHECK(beside.y() > 0.7 * beside.x());  // fat
}

// Would catch a missing blend, a hidden back layer and an ignored colour of a vertex.
TEST_CASE("renderer: through a transparent sheet the tissue behind is seen", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  const auto render_with = [&](float alpha) {
    RenderSnapshot snapshot = one_sheet(tissues::liver());
    Surface membrane = sheet(tissues::membrane(), 0.005f, 0.1f);
    membrane.colors.assign(membrane.positions.size(), Eigen::Vector4f(0.2f, 0.9f, 0.3f, alpha));
    membrane.look.gloss = 0;
    snapshot.surfaces.push_back(membrane);
    return mean(renderer->render(snapshot), kWidth / 2 - 50, kHeight / 2 + 20);
  };

  const Eigen::Vector3d none = render_with(0);
  const Eigen::Vector3d half = render_with(0.5f);
  const Eigen::Vector3d full = render_with(1);

  CHECK(none.x() > none.y());
  CHECK(full.y() > full.x());
  CHECK(half.y() > none.y() + 10);
  CHECK(half.y() < full.y() - 5);
  CHECK(half.x() > full.x() + 5);
}

TEST_CASE("renderer: a sheet seen from behind is lit as well", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot turned = one_sheet(tissues::fat());
  for (pbdsurg::Triangle& triangle : turned.surfaces[0].triangles) {
    std::swap(triangle[0], triangle[1]);
  }

  const Eigen::Vector3d front = mean(renderer->render(one_sheet(tissues::fat())), kWidth / 2, 60);
  const Eigen::Vector3d back = mean(renderer->render(turned), kWidth / 2, 60);

  CHECK(back.sum() > 0.7 * front.sum());
}

TEST_CASE("renderer: tools, strands and smoke change the picture where they are",
          "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  const Image plain = renderer->render(one_sheet(tissues::liver()));
  RenderSnapshot snapshot = one_sheet(tissues::liver());
  snapshot.tools = {{"hook",
                     {{{{-0.04f, 0.02f, 0.02f}, {0.04f, 0.02f, 0.02f}},
                       {0.004f, 0.004f},
                       ToolFinish::insulation}}}};
  snapshot.strands = {{{-0.04f, -0.02f, 0.02f}, {0.04f, -0.02f, 0.02f}, {1, 1, 1, 1}, 0.006f}};
  snapshot.smoke = {{{-0.02f, 0, 0.03f}, 0.012f, 0.9f}};

  const Image image = renderer->render(snapshot);

  // 0.02 m at 0.08 m from the eye, at 90 pixels per tan(0.55), is 37 pixels from the middle
  const int tool_row = kHeight / 2 - 37, strand_row = kHeight / 2 + 37;
  CHECK(mean(image, kWidth / 2 + 30, tool_row, 2).x() <
        0.7 * mean(plain, kWidth / 2 + 30, tool_row, 2).x());
  CHECK(mean(image, kWidth / 2 + 30, strand_row, 2).z() >
        1.5 * mean(plain, kWidth / 2 + 30, strand_row, 2).z());
  const int smoke_column = kWidth / 2 - 42;
  CHECK(mean(image, smoke_column, kHeight / 2, 6).z() >
        1.2 * mean(plain, smoke_column, kHeight / 2, 6).z());
}

TEST_CASE("renderer: an empty snapshot is a dark picture", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);

  const Image image = renderer->render(RenderSnapshot{});

  CHECK(*std::max_element(image.rgb.begin(), image.rgb.end()) < 48);
}

// Would catch one bad vertex that spoils the normals, the depth range or the whole picture.
TEST_CASE("renderer: a figure shows colours as given, on white to its corners", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot snapshot = one_sheet(tissues::liver());
  snapshot.style = Style::figure;
  snapshot.surfaces[0] = sheet(tissues::liver(), 0, 0.02f);
  snapshot.surfaces[0].colors.assign(snapshot.surfaces[0].positions.size(), {0.2f, 0.8f, 0.4f, 1});
  const Image image = renderer->render(snapshot);
  const Eigen::Vector3d middle = mean(image, kWidth / 2, kHeight / 2);
  CHECK((middle - 255 * Eigen::Vector3d(0.2, 0.8, 0.4)).norm() < 8);
  for (const int x : {0, kWidth - 1}) {
    for (const int y : {0, kHeight - 1}) {
      CHECK(image.at(x, y) == Rgb8{255, 255, 255});
    }
  }
}

TEST_CASE("renderer: a vertex that is not finite costs its triangles only", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  RenderSnapshot snapshot = one_sheet(tissues::fat());
  const Image whole = renderer->render(snapshot);
  snapshot.surfaces[0].positions[0].x() = std::numeric_limits<float>::quiet_NaN();  // unseen corner

  CHECK(renderer->render(snapshot).rgb == whole.rgb);
  snapshot.surfaces[0].positions[25 * 12 + 12].y() = std::numeric_limits<float>::infinity();
  const Image holed = renderer->render(snapshot);
  CHECK(mean(holed, kWidth / 2, kHeight / 2, 2).sum() < 60);
  CHECK(mean(holed, kWidth / 2 - 60, kHeight / 2).sum() > 150);
}

TEST_CASE("renderer: the same snapshot gives the same bytes, on a new renderer too",
          "[property][opengl]") {
  REQUIRE_RENDERER(renderer);
  const Image first = renderer->render(one_sheet(tissues::gallbladder_wall()));

  CHECK(renderer->render(RenderSnapshot{}).rgb != first.rgb);
  CHECK(renderer->render(one_sheet(tissues::gallbladder_wall())).rgb == first.rgb);
  OffscreenRenderer other({.width = kWidth, .height = kHeight});
  OffscreenRenderer moved = std::move(other);
  CHECK(moved.render(one_sheet(tissues::gallbladder_wall())).rgb == first.rgb);
  CHECK(renderer->render(one_sheet(tissues::gallbladder_wall())).rgb == first.rgb);
  CHECK_FALSE(renderer->device_name().empty());
}

TEST_CASE("renderer: a size out of range is refused", "[unit]") {
  CHECK_THROWS_AS(OffscreenRenderer({.width = 0, .height = 100}), pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(OffscreenRenderer({.width = 100, .height = 1 << 20}), pbdsurg::InvalidArgument);
}

}  // namespace cholecystectomy
