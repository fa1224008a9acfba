// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Line plots as pictures, for reports: no font file, no plotting program.

#include <string>
#include <vector>

#include "apps/viewer/image.h"

namespace cholecystectomy {

/// One curve. A point that is not finite, or beyond 1e300, breaks the line.
struct PlotSeries {
  std::string label;
  std::vector<double> x;  ///< [point_count] in the unit named by the plot's x label
  std::vector<double> y;  ///< [point_count]
};

/// Labels are printable ASCII; anything else is drawn as '?'.
struct Plot {
  std::string title;
  std::string x_label;  ///< with its unit, for example "time [s]"
  std::string y_label;
  std::vector<PlotSeries> series;
  int width = 960;   ///< pixels
  int height = 540;  ///< pixels
};

/// Draws the curves over axes with round tick values that enclose all points.
/// @throws pbdsurg::InvalidArgument  if x and y of a series differ in length, or the picture is
///         smaller than 240 x 160 or larger than 8192 pixels along a side
[[nodiscard]] Image plot_lines(const Plot& plot);

}  // namespace cholecystectomy
