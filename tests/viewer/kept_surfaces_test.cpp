// SPDX-License-Identifier: Apache-2.0
// Surfaces that stay with the renderer and change.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "apps/viewer/egl_context.h"
#include "apps/viewer/gl_objects.h"
#include "apps/viewer/scene_renderer.h"
#include "tests/viewer/pictures.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::ContainsSubstring;

/// The picture of a renderer that has never seen anything else.
Image fresh_picture(const Surface& surface, const SceneView& view = {}) {
  OffscreenRenderer renderer({.width = kWidth, .height = kHeight});
  renderer.set_surfaces(std::array{surface});
  return renderer.render(view);
}

Surface sheet_at_rest(const pbdsurg::TissueRecord& tissue) {
  Surface surface = sheet(tissue, 0, 0.1f);
  surface.rest_positions = surface.positions;
  surface.inner_look = tissues::artery().look;
  return surface;
}

}  // namespace

// Would catch a run that is sent to the wrong place, stale normals, a buffer that forgets what it
// had when it grows, and a change that only the next one shows.
TEST_CASE("kept surface: after changes it looks as if it had always been so",
          "[property][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = sheet_at_rest(tissues::liver());
  renderer->set_surfaces(std::array{surface});
  CHECK(renderer->render(SceneView{}).rgb == fresh_picture(surface).rgb);
  const auto check_change = [&](const SurfaceChange& change) {
    renderer->update(0, change);
    CHECK(renderer->render(SceneView{}).rgb == fresh_picture(surface).rgb);
  };

  SECTION("moved, then moved again") {
    for (const float bend : {2.0f, -3.0f}) {
      for (Eigen::Vector3f& p : surface.positions) {
        p.z() = bend * p.x() * p.x();
      }
      SurfaceChange change;
      change.positions = surface.positions;
      check_change(change);
    }
  }
  SECTION("burnt, here and there") {
    surface.burn.assign(surface.positions.size(), Eigen::Vector4f::Zero());
    SurfaceChange change;
    for (const pbdsurg::Index first : {307, 315}) {
      SurfaceChange::Burns& run = change.burns.emplace_back();
      run.first = first;
      run.values.assign(5, {0.05f, 0.04f, 0.03f, 0.9f});
      std::copy(run.values.begin(), run.values.end(), surface.burn.begin() + first);
    }
    check_change(change);
    change.burns.pop_back();
    change.burns[0].values.assign(3, Eigen::Vector4f::Zero());
    std::fill_n(surface.burn.begin() + 307, 3, Eigen::Vector4f::Zero());
    check_change(change);
  }
  SECTION("opened, with empty slots, new vertices and many new slots") {
    surface.is_inner.assign(surface.triangles.size(), 0);
    float height = 0.01f;
    for (const int count : {700, 4, 5}) {  // the first two have buffers grow
      SurfaceChange change;
      SurfaceChange::Triangles& hole = change.triangles.emplace_back();
      hole.first = 24 * 24 + 2 * count % 30;
      hole.values.assign(10, {0, 0, 0});
      hole.is_inner.assign(10, 0);
      std::copy(hole.values.begin(), hole.values.end(), surface.triangles.begin() + hole.first);
      SurfaceChange::Triangles& more = change.triangles.emplace_back();
      more.first = static_cast<pbdsurg::Index>(surface.triangles.size());
      for (int i = 0; i < count; ++i) {
        const auto first = static_cast<pbdsurg::Index>(surface.positions.size());
        const float x = 0.0001f * static_cast<float>(i) - 0.03f;
        for (const Eigen::Vector3f& p :
             {Eigen::Vector3f(x, -0.01f, height), {x + 0.01f, 0, 2 * height}, {x, 0.01f, height}}) {
          surface.positions.push_back(p);
          surface.rest_positions.push_back(2 * p);
          change.new_rest_positions.push_back(2 * p);
        }
        more.values.push_back({first, first + 1, first + 2});
        more.is_inner.push_back(i % 2 == 0 ? 1 : 0);
        surface.triangles.push_back(more.values.back());
        surface.is_inner.push_back(more.is_inner.back());
      }
      change.positions = surface.positions;
      check_change(change);
      height += 0.01f;
    }
  }
  SECTION("a vertex that is not finite for a while") {
    const Eigen::Vector3f before = surface.positions[25 * 12 + 12];
    surface.positions[25 * 12 + 12].x() = std::numeric_limits<float>::quiet_NaN();
    SurfaceChange change;
    change.positions = surface.positions;
    check_change(change);
    surface.positions[25 * 12 + 12] = before;
    change.positions = surface.positions;
    check_change(change);
  }
}

// Would catch a surface that is lost, or kept with what belonged to the old size or quality.
TEST_CASE("kept surface: it outlives another size and quality of the picture", "[unit][opengl]") {
  REQUIRE_RENDERER(unused);
  EglContext context;
  const std::array surfaces{sheet_at_rest(tissues::fat())};
  const auto read = [](SceneRenderer& scene, int width, int height) {
    const GlRenderbuffer pixels;
    const GlFramebuffer framebuffer;
    glBindRenderbuffer(GL_RENDERBUFFER, pixels.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, pixels.name());
    scene.draw(SceneView{}, framebuffer.name());
    std::vector<unsigned char> rgba(static_cast<std::size_t>(4 * width * height));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer.name());
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    CHECK(glGetError() == GL_NO_ERROR);
    return rgba;
  };
  SceneRenderer changed(200, 160);
  changed.set_surfaces(surfaces);
  const auto full = read(changed, 200, 160);
  changed.resize(120, 90);
  changed.set_quality(RenderQuality::quick());
  SceneRenderer quick(120, 90, RenderQuality::quick());
  quick.set_surfaces(surfaces);

  CHECK(read(changed, 120, 90) == read(quick, 120, 90));
  changed.set_quality(RenderQuality::full());
  changed.resize(200, 160);
  CHECK(read(changed, 200, 160) == full);
  CHECK_THROWS_AS(changed.set_quality({.subdivision = 0}), pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(changed.set_quality({.samples = 0}), pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(changed.set_quality({.shadow_size = -1}), pbdsurg::InvalidArgument);
  CHECK(read(changed, 200, 160) == full);
}

// Would catch a rule that is not checked, and a good run before a bad one that has been applied.
TEST_CASE("kept surface: a change that does not fit is refused by name and changes nothing",
          "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = sheet_at_rest(tissues::liver());
  Surface plain = sheet(tissues::liver(), -0.01f, 0.1f);
  plain.name = "plain";
  renderer->set_surfaces(std::array{surface, plain});
  const Image before = renderer->render(SceneView{});
  const std::size_t count = surface.positions.size();
  const std::size_t slots = surface.triangles.size();
  const auto end = static_cast<pbdsurg::Index>(slots);

  struct Case {
    std::string reason;
    std::function<void(SurfaceChange&)> spoil;
  };
  const std::vector<Case> cases{
      {"vertices only come", [](SurfaceChange& c) { c.positions.resize(5); }},
      {"new rest positions",
       [&](SurfaceChange& c) { c.positions.assign(count + 1, Eigen::Vector3f::Zero()); }},
      {"new rest positions",
       [](SurfaceChange& c) { c.new_rest_positions.assign(2, Eigen::Vector3f::Zero()); }},
      {"starts at -1",
       [](SurfaceChange& c) {
         c.triangles.push_back({-1, {{0, 1, 2}}, {0}});
       }},
      {"starts at " + std::to_string(slots + 1),
       [&](SurfaceChange& c) {
         c.triangles.push_back({end + 1, {{0, 1, 2}}, {0}});
       }},
      {"triangle 8 refers to vertex 625",
       [](SurfaceChange& c) {
         c.triangles.push_back({7, {{0, 1, 2}, {0, 1, 625}}, {0, 0}});
       }},
      {"entries of is_inner",
       [](SurfaceChange& c) {
         c.triangles.push_back({7, {{0, 1, 2}, {0, 1, 3}}, {1}});
       }},
      {"starts at 626",
       [](SurfaceChange& c) {
         c.burns.push_back({626, {}});
       }},
      {"beyond its 625 vertices", [](SurfaceChange& c) {
         c.burns.push_back({624, std::vector<Eigen::Vector4f>(2, {0, 0, 0, 1})});
       }}};
  for (const Case& bad : cases) {
    SurfaceChange change;
    change.positions.assign(count, Eigen::Vector3f::Zero());
    change.triangles.push_back({0, {{0, 0, 0}}, {0}});
    change.burns.push_back({0, std::vector<Eigen::Vector4f>(300, {0, 0, 0, 1})});
    bad.spoil(change);
    CHECK_THROWS_WITH(renderer->update(0, change),
                      ContainsSubstring("'sheet'") && ContainsSubstring(bad.reason));
  }
  SurfaceChange grown;
  grown.positions.assign(plain.positions.size() + 1, Eigen::Vector3f::Zero());
  grown.new_rest_positions.assign(1, Eigen::Vector3f::Zero());
  CHECK_THROWS_WITH(renderer->update(1, grown), ContainsSubstring("'plain'"));
  CHECK_THROWS_AS(renderer->update(2, SurfaceChange{}), pbdsurg::InvalidArgument);
  plain.burn.resize(3);
  CHECK_THROWS_AS(renderer->set_surfaces(std::array{plain}), pbdsurg::InvalidArgument);

  CHECK(renderer->render(SceneView{}).rgb == before.rgb);
}

// Would catch a burn that stays in place, or texture that swims, while tissue moves below it.
TEST_CASE("kept surface: burn and texture move and turn with the tissue", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = sheet_at_rest(tissues::gallbladder_wall());
  surface.look.gloss = 0;
  surface.look.relief = 0;
  for (const Eigen::Vector3f& p : surface.positions) {
    const bool is_burnt = (p - Eigen::Vector3f(0.03f, 0.02f, 0)).norm() < 0.016f;
    surface.burn.push_back(is_burnt ? Eigen::Vector4f(0.03f, 0.03f, 0.02f, 1)
                                    : Eigen::Vector4f(Eigen::Vector4f::Zero()));
  }
  SceneView view;
  view.camera.light_offset.setZero();  // alike in all directions
  renderer->set_surfaces(std::array{surface});
  // 0.01 m at 0.1 m from the eye, at 90 pixels per tan(0.55), are 14.7 pixels
  const auto at = [](const Image& image, float x, float y) {
    return mean(image, static_cast<int>(std::lround(119.5f + 1470 * x)),
                static_cast<int>(std::lround(89.5f - 1470 * y)), 2)
        .sum();
  };
  const Image before = renderer->render(view);
  SurfaceChange turn;
  turn.positions = surface.positions;
  for (Eigen::Vector3f& p : turn.positions) {
    p = Eigen::Vector3f(-p.y(), p.x(), p.z());  // a quarter, counter-clockwise
  }
  renderer->update(0, turn);
  const Image after = renderer->render(view);

  CHECK(at(before, 0.03f, 0.02f) < 0.5 * at(before, -0.03f, 0.02f));
  CHECK(at(before, 0.03f, 0.02f) < 0.5 * at(before, -0.02f, 0.03f));
  CHECK(at(after, -0.02f, 0.03f) < 0.5 * at(after, 0.03f, 0.02f));
  double kept = 0, swum = 0;
  for (float x = -0.04f; x < 0.041f; x += 0.002f) {
    kept += std::abs(at(before, x, -0.02f) - at(after, 0.02f, x));
    swum += std::abs(at(before, x, -0.02f) - at(after, x, -0.02f));
  }
  CHECK(kept < 0.5 * swum);
}

// Would catch a shadow that is lost because the lamp is within the box of what throws it, and a
// backdrop that throws one.
TEST_CASE("kept surface: what reaches around the lamp throws a shadow", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  const auto brightness = [&](bool casts_shadow) {
    Surface around = sheet(tissues::fat(), 0.05f, 0.006f);
    const Surface behind = sheet(tissues::fat(), 0.2f, 0.05f);
    const auto count = static_cast<pbdsurg::Index>(around.positions.size());
    for (Eigen::Vector3f& p : around.positions) {
      p.x() += 0.012f;
    }
    around.positions.insert(around.positions.end(), behind.positions.begin(),
                            behind.positions.end());
    for (const auto& [a, b, c] : behind.triangles) {
      around.triangles.push_back({a + count, b + count, c + count});
    }
    around.casts_shadow = casts_shadow;
    renderer->set_surfaces(std::array{sheet(tissues::liver(), 0, 0.1f), around});
    const Image image = renderer->render(SceneView{});
    double sum = 0;
    for (const std::uint8_t value : image.rgb) {
      sum += value;
    }
    return sum / static_cast<double>(image.rgb.size());
  };
  CHECK(brightness(true) < 0.995 * brightness(false));
}

// Would catch light of few bits where colours are to be read as given.
TEST_CASE("kept surface: a figure's colours have all levels of a picture", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  Surface surface = sheet(tissues::liver(), 0, 0.1f);
  for (const Eigen::Vector3f& p : surface.positions) {
    surface.colors.emplace_back(0, 0, 0.4f + p.x(), 1);
  }
  renderer->set_surfaces(std::array{surface});
  SceneView view;
  view.style = Style::figure;
  const Image image = renderer->render(view);
  std::set<int> levels;
  for (int x = 0; x < image.width; ++x) {
    levels.insert(image.at(x, image.height / 2)[2]);
  }
  CHECK(static_cast<int>(levels.size()) > *levels.rbegin() - *levels.begin() - 3);
}

}  // namespace cholecystectomy
