// SPDX-License-Identifier: Apache-2.0
// What parts of the operation do to a picture.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "apps/cholecystectomy/scope.h"
#include "apps/cholecystectomy/smoke.h"
#include "tests/play/session_fixture.h"
#include "tests/viewer/pictures.h"

namespace cholecystectomy {
namespace {

/// Which of red, green and blue is the largest.
int label_at(const Image& image, int x, int y) {
  const Rgb8 color = image.at(x, y);
  return static_cast<int>(std::max_element(color.begin(), color.end()) - color.begin());
}

int brightness(const Image& image, int x, int y) {
  const Rgb8 color = image.at(x, y);
  return color[0] + color[1] + color[2];
}

/// The largest step between neighbouring pixels across an edge at x, y.
int steepness(const Image& image, int x, int y, int dx, int dy) {
  constexpr int kReach = 4;  // pixels: triangles of a figure are flat, the skin is not
  int most = 0;
  for (int i = -kReach; i < kReach; ++i) {
    most = std::max(most, std::abs(brightness(image, x + i * dx, y + i * dy) -
                                   brightness(image, x + (i + 1) * dx, y + (i + 1) * dy)));
  }
  return most;
}

double difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    sum += std::abs(a.rgb[i] - b.rgb[i]);
  }
  return sum / static_cast<double>(a.rgb.size());
}

}  // namespace

// Would catch sheets that are not drawn, that leave the edge of an organ bare, and opaque ones.
TEST_CASE("operation: the membrane softens the edge between liver and gallbladder",
          "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  PlayedSession play;
  play.go(0, play.farthest(Organ::gallbladder, {-1, 0, -0.7F}), 40);
  play.hands[0].set_jaw(0);
  play.step(20);
  play.go(0, play.hands[0].tip() + Eigen::Vector3f(-0.012F, -0.006F, -0.012F), 40);
  play.step(20);
  const SceneState state = play.whole();
  REQUIRE(state.grasper.is_holding);
  std::vector<Surface> labels = state.whole;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Eigen::Vector4f color(0, 0, 0, 1);
    color[i == static_cast<std::size_t>(Organ::liver)         ? 0
          : i == static_cast<std::size_t>(Organ::gallbladder) ? 1
                                                              : 2] = 1;
    labels[i].colors.assign(labels[i].positions.size(), color);
  }

  SceneView view;
  view.camera = Scope::looking_at({0.003F, -0.192F, -0.138F}, {0.035F, 0, 0.003F}).camera();
  view.style = Style::figure;
  renderer->set_surfaces(labels);
  const Image label = renderer->render(view);
  view.style = Style::scope;
  renderer->set_surfaces(state.whole);
  const Image bare = renderer->render(view);
  view.sheets = state.sheets;
  const Image joined = renderer->render(view);

  int edges = 0, steepness_bare = 0, steepness_joined = 0;
  const int margin = kHeight / 8;
  for (int y = margin; y < kHeight - margin; ++y) {
    for (int x = kWidth / 2 - 3 * margin; x < kWidth / 2 + 3 * margin; ++x) {
      for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}}) {
        if (label_at(label, x, y) + label_at(label, x + dx, y + dy) == 1) {
          ++edges;
          steepness_bare += steepness(bare, x, y, dx, dy);
          steepness_joined += steepness(joined, x, y, dx, dy);
        }
      }
    }
  }
  REQUIRE(edges > 60);
  CAPTURE(edges, steepness_bare / edges, steepness_joined / edges);
  CHECK(steepness_bare > 100 * edges);
  CHECK(steepness_joined < 0.6 * steepness_bare);
  CHECK(steepness_joined > 0.1 * steepness_bare);
}

// Would catch smoke that is not drawn, that stays, or that goes all at once.
TEST_CASE("operation: the smoke of a burn clears from the picture", "[unit][opengl]") {
  REQUIRE_RENDERER(renderer);
  renderer->set_surfaces(one_sheet(tissues::liver()).surfaces);
  const Image clear = renderer->render(SceneView{});
  Smoke smoke = Smoke::of_scene();
  const auto advance = [&](double seconds, double power) {
    for (double time = 0; time < seconds; time += 10e-3) {
      smoke.advance(10e-3, {0, 0, 0.01F}, power, Smoke::kSuction);
    }
  };
  const auto clouded = [&] {
    SceneView view;
    view.smoke.assign(smoke.puffs().begin(), smoke.puffs().end());
    view.haze = smoke.haze();
    return difference(renderer->render(view), clear);
  };

  advance(2, 35);
  std::vector<double> left{clouded()};
  for (const double seconds : {1.0, 2.0, 5.0, 10.0}) {
    advance(seconds, 0);
    left.push_back(clouded());
  }
  CHECK(left.front() > 5);
  for (std::size_t i = 1; i < left.size(); ++i) {
    CAPTURE(i, left[i - 1], left[i]);
    CHECK(left[i] < 0.9 * left[i - 1]);
    CHECK(left[i] > 0.1 * left[i - 1]);
  }
  advance(60, 0);
  CHECK(clouded() < 0.05 * left.front());
}

}  // namespace cholecystectomy
