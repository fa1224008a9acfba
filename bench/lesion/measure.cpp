// SPDX-License-Identifier: Apache-2.0
#include "bench/lesion/measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

namespace pbdsurg::bench {
namespace {

const Eigen::Vector3d kHalf(7e-3, 7e-3, 3e-3);  // m
constexpr double kArea = 5e-6;                  // m^2
constexpr double kTime = 1, kStep = 10e-3;      // s

double top_of(const TetMesh& mesh) {
  double top = 0;
  for (const Eigen::Vector3d& x : mesh.positions()) {
    top = std::max(top, x.z());
  }
  return top;
}

// Logarithm of the damage integral, which is about linear between vertices where survival is not: 0
// where tissue counts as coagulated.
double log_damage(double survival) {
  return std::log(std::clamp(-std::log(std::max(survival, 1e-300)), 1e-3, 1e3));
}

// Depth and width of what is coagulated, where edges pass its border.
void measure_border(const TetMesh& mesh, std::span<const double> survival, Lesion& lesion) {
  const double top = top_of(mesh);
  std::array<double, 2> low{1, 1}, high{0, 0};
  for (const Tet& tet : mesh.tets()) {
    for (const auto& [a, b] : kTetEdges) {
      const double first = log_damage(survival[tet[a]]), second = log_damage(survival[tet[b]]);
      if ((first > 0) == (second > 0)) {
        continue;
      }
      const Eigen::Vector3d& from = mesh.positions()[tet[a]];
      const Eigen::Vector3d border =
          from + first / (first - second) * (mesh.positions()[tet[b]] - from);
      lesion.depth = std::max(lesion.depth, top - border.z());
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], border[axis]);
        high[axis] = std::max(high[axis], border[axis]);
      }
    }
  }
  lesion.width = std::max(0.0, (high[0] - low[0] + high[1] - low[1]) / 2);
}

}  // namespace

TetMesh make_liver(double edge) {
  TetrahedralizeOptions options;
  options.spacing = edge;
  return tetrahedralize(rounded_box_shape(kHalf, kHalf, 0.25e-3), options).mesh;
}

Lesion burn(const TetMesh& mesh, double edge, double power, int place) {
  Scene scene;
  const ThermalBody body{scene.add_body("liver", mesh), tissues::liver().heat};
  Solver solver(scene, {.executor = executor::serial()});
  CauteryOptions options;
  options.contact_radius = std::sqrt(kArea / std::numbers::pi);
  Cautery cautery(solver.tissue(), std::span(&body, 1), options);
  // the first points of Hammersley's set: 0, 1/2, 1/4, 3/4, ... across, in order along
  const double across = (place & 1) / 2.0 + (place & 2) / 8.0 + (place & 4) / 32.0;
  const Eigen::Vector3d middle(kHalf.x(), kHalf.y(), top_of(mesh));
  const Eigen::Vector3f tip =
      (middle + edge * Eigen::Vector3d(static_cast<double>(place) / kPlaces, across, 0))
          .cast<float>();
  Lesion lesion;
  for (int i = 0; i < std::lround(kTime / kStep); ++i) {
    const CauteryReport report = cautery.update(solver, {tip, tip}, cut_settings(power), kStep);
    lesion.removed += report.removed_volume;
    lesion.hottest = std::max(lesion.hottest, report.hottest);
  }
  measure_border(mesh, cautery.field().survival(), lesion);
  const HeatLedger& ledger = cautery.field().ledger();
  lesion.ledger = std::abs(ledger.sensible + ledger.latent + ledger.removed + ledger.surface +
                           ledger.perfusion - ledger.in) /
                  ledger.in;
  return lesion;
}

}  // namespace pbdsurg::bench
