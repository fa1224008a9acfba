// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/lattice.h"

#include <algorithm>

namespace cholecystectomy {

Lattice make_lattice(int subdivision, int most) {
  const int point_count = (subdivision + 1) * (subdivision + 2) / 2;
  Lattice lattice;
  lattice.triangle_count = std::min(most, 65536 / point_count);
  // Row j has subdivision + 1 - j points and starts after those of the rows before.
  const auto place = [&](int i, int j) { return j * (subdivision + 1) - j * (j - 1) / 2 + i; };
  for (int triangle = 0; triangle < lattice.triangle_count; ++triangle) {
    const auto add = [&](int i, int j) {
      lattice.indices.push_back(static_cast<std::uint16_t>(triangle * point_count + place(i, j)));
    };
    for (int j = 0; j <= subdivision; ++j) {
      for (int i = 0; i + j <= subdivision; ++i) {
        lattice.points.push_back({static_cast<std::uint16_t>(subdivision - i - j),
                                  static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j),
                                  static_cast<std::uint16_t>(triangle)});
      }
    }
    for (int j = 0; j < subdivision; ++j) {
      for (int i = 0; i + j < subdivision; ++i) {
        add(i, j), add(i + 1, j), add(i, j + 1);
        if (i + j + 1 < subdivision) {
          add(i + 1, j), add(i + 1, j + 1), add(i, j + 1);
        }
      }
    }
  }
  return lattice;
}

}  // namespace cholecystectomy
