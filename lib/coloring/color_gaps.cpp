// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/color_gaps.h"

#include <algorithm>
#include <vector>

namespace pbdsurg {

void close_color_gaps(Coloring& coloring) {
  Index highest = kOverflowColor;
  for (const Index color : coloring.color_of) {
    highest = std::max(highest, color);
  }
  std::vector<Index> number(static_cast<std::size_t>(highest) + 1, 0);
  for (const Index color : coloring.color_of) {
    if (color != kOverflowColor) {
      number[color] = 1;
    }
  }
  coloring.color_count = 0;
  for (Index& entry : number) {
    entry = entry != 0 ? coloring.color_count++ : kInvalidIndex;
  }
  if (coloring.color_count == highest + 1) {
    return;
  }
  for (Index& color : coloring.color_of) {
    color = color == kOverflowColor ? kOverflowColor : number[color];
  }
}

}  // namespace pbdsurg
