// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A block of tissue for a cautery, a tip on top of it, and what must hold while it burns.

#include "pbdsurg/surgery/cautery.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// Cells of 8 x 8 x 4, held at the bottom.
struct CauteryBlock {
  static constexpr double kEdge = 1e-3;  // m

  explicit CauteryBlock(const Material& material = {}) {
    scene.add_body("block", mesh, material);
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.1 * kEdge; });
  }

  TetMesh mesh = make_box({8, 8, 4}, kEdge, 0.05);
  Scene scene;
};

/// An electrode that touches with its tip alone.
inline Electrode point(const Eigen::Vector3f& tip) {
  return {tip, tip};
}

/// Just above the middle of the block's upper face.
inline const Electrode kOnTop = point({4e-3F, 4e-3F, 4.2e-3F});

/// What came in equals what is there, what went, and what tissue lost.
inline void check_ledger(const Cautery& cautery) {
  const HeatLedger& ledger = cautery.field().ledger();
  CHECK(ledger.sensible + ledger.latent + ledger.removed + ledger.surface + ledger.perfusion ==
        Approx(ledger.in).epsilon(1e-9).margin(1e-12));
  CHECK(cautery.removal_energy() <= ledger.in);
}

}  // namespace pbdsurg::testing
