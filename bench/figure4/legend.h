// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the colours of a picture mean.

#include <functional>
#include <string>
#include <vector>

#include "pbdsurg/heat/tissue_color.h"

#include "apps/viewer/image.h"

namespace pbdsurg::bench {

/// A bar from `low` at the bottom to `high` at the top.
struct Legend {
  struct Tick {
    double value;
    std::string label;  ///< printable ASCII
  };

  std::string title;  ///< printable ASCII
  double low, high;
  std::function<Color(double)> color_of;
  std::vector<Tick> ticks;
};

[[nodiscard]] cholecystectomy::Image draw_legend(const Legend& legend, int width, int height);

}  // namespace pbdsurg::bench
