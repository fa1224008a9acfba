// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/contact_firmness.h"

#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg {

void ContactFirmness::refresh(const Tissue& tissue, const PieceLists& pieces,
                              std::span<const Index> place_of_vertex) {
  if (version_ == tissue.version()) {
    return;
  }
  of_places_.assign(place_of_vertex.size(), kPlainFirmness);
  for (Index vertex = 0; vertex < tissue.vertex_count(); ++vertex) {
    if (tissue.bodies()[tissue.body_of_vertex(vertex)].tet_count > 0) {
      of_places_[place_of_vertex[vertex]] = kHeldFirmness;
    }
  }
  for (Index piece = 0; piece < pieces.count(); ++piece) {
    for (const Index place : pieces.places(piece)) {
      of_places_[place] = kPlainFirmness;
    }
  }
  version_ = tissue.version();
  ++revision_;
}

}  // namespace pbdsurg
