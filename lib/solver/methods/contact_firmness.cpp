// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/contact_firmness.h"

#include <array>

#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg {

void ContactFirmness::refresh(const Tissue& tissue, const PieceLists& pieces,
                              std::span<const Index> place_of_vertex) {
  if (version_ == tissue.version()) {
    return;
  }
  of_places_.assign(place_of_vertex.size(), kHeldFirmness);
  for (Index piece = 0; piece < pieces.count(); ++piece) {
    for (const Index place : pieces.places(piece)) {
      of_places_[place] = kPlainFirmness;
    }
  }
  for (const std::array<Index, 3>& triangle : tissue.triangles()) {
    for (const Index vertex : triangle) {
      of_places_[place_of_vertex[vertex]] = kPlainFirmness;
    }
  }
  version_ = tissue.version();
  ++revision_;
}

}  // namespace pbdsurg
