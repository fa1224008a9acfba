// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes and measures for tests that look at pictures. Pictures are judged by their structure,
/// never by their exact pixels: drivers differ.

#include <optional>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/offscreen_renderer.h"
#include "tests/support/catch.h"
#include "tests/support/skip.h"

namespace cholecystectomy {

namespace tissues = pbdsurg::tissues;

inline constexpr int kWidth = 240;
inline constexpr int kHeight = 180;

/// None where the machine offers no OpenGL.
inline std::optional<OffscreenRenderer> make_renderer(const OffscreenOptions& options) {
  try {
    return std::make_optional<OffscreenRenderer>(options);
  } catch (const pbdsurg::BackendUnavailable& error) {
    pbdsurg::testing::skip(error.what());
    return std::nullopt;
  }
}

/// A renderer for all tests, or none.
inline OffscreenRenderer* shared_renderer() {
  static std::optional<OffscreenRenderer> renderer =
      make_renderer({.width = kWidth, .height = kHeight});
  return renderer.has_value() ? &*renderer : nullptr;
}

#define REQUIRE_RENDERER(name)                       \
  OffscreenRenderer* const name = shared_renderer(); \
  if (name == nullptr) {                             \
    SUCCEED("no OpenGL context");                    \
    return;                                          \
  }

/// A square sheet of tissue across the view of the default camera, facing it.
inline Surface sheet(const pbdsurg::TissueRecord& tissue, float z, float half_side) {
  constexpr int kCells = 24;
  Surface surface;
  surface.name = "sheet";
  surface.look = tissue.look;
  for (int y = 0; y <= kCells; ++y) {
    for (int x = 0; x <= kCells; ++x) {
      surface.positions.push_back({half_side * (2.0f * static_cast<float>(x) / kCells - 1),
                                   half_side * (2.0f * static_cast<float>(y) / kCells - 1), z});
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const pbdsurg::Index a = y * (kCells + 1) + x;
      const pbdsurg::Index c = a + kCells + 1;
      surface.triangles.push_back({a, a + 1, c});
      surface.triangles.push_back({a + 1, c + 1, c});
    }
  }
  return surface;
}

/// Mean colour of a square around a pixel.
inline Eigen::Vector3d mean(const Image& image, int center_x, int center_y, int half = 5) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int y = center_y - half; y <= center_y + half; ++y) {
    for (int x = center_x - half; x <= center_x + half; ++x) {
      const Rgb8 color = image.at(x, y);
      sum += Eigen::Vector3d(color[0], color[1], color[2]);
    }
  }
  return sum / ((2 * half + 1) * (2 * half + 1));
}

inline RenderSnapshot one_sheet(const pbdsurg::TissueRecord& tissue) {
  RenderSnapshot snapshot;
  snapshot.surfaces = {sheet(tissue, 0, 0.1f)};
  return snapshot;
}

}  // namespace cholecystectomy
