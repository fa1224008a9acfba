// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A block with heat in a scene of two bodies, and how to compare fields.

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// A block as the second of two bodies, so that its ids are not those of its mesh.
struct Blocks {
  explicit Blocks(TetMesh block) : mesh(std::move(block)) {
    scene.add_body("other", other);
    scene.add_body("block", mesh);
  }

  [[nodiscard]] HeatField field(const Tissue& tissue, const ThermalModel& model = {}) const {
    return {tissue, std::array{ThermalBody{1, tissues::liver().heat}}, model};
  }

  TetMesh other = make_box({3, 3, 3}, 1e-3), mesh;
  Scene scene;
};

inline bool same(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

inline bool same_ledger(const HeatLedger& a, const HeatLedger& b) {
  return a.in == b.in && a.sensible == b.sensible && a.latent == b.latent &&
         a.removed == b.removed && a.surface == b.surface && a.perfusion == b.perfusion;
}

inline bool same_state(const HeatField& a, const HeatField& b) {
  return same(a.temperatures(), b.temperatures()) && same(a.water(), b.water()) &&
         same(a.peak_temperatures(), b.peak_temperatures()) && same(a.survival(), b.survival()) &&
         same(a.collagen(), b.collagen()) && same(a.charred(), b.charred()) &&
         same_ledger(a.ledger(), b.ledger()) &&
         std::ranges::equal(a.active_vertices(), b.active_vertices()) &&
         std::ranges::equal(a.mesh().tets(), b.mesh().tets());
}

/// Sensible heat found afresh, J.
inline double sensible_heat(const HeatField& field) {
  double sum = 0;
  for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
    sum += field.capacity(v) * (field.temperatures()[v] - kBodyTemperature);
  }
  return sum;
}

}  // namespace pbdsurg::testing
