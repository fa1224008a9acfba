// SPDX-License-Identifier: Apache-2.0
// Burns a block of liver with a flat electrode: heat [W] [s] [mm^2 of contact].
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <span>

#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

int main(int argc, char** argv) try {
  const double power = argc > 1 ? std::atof(argv[1]) : 30;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 2;
  const double area = (argc > 3 ? std::atof(argv[3]) : 5) * 1e-6;  // m^2
  pbdsurg::TetrahedralizeOptions fine;
  fine.spacing = 1e-3;  // m
  const pbdsurg::TetMesh block =
      pbdsurg::tetrahedralize(pbdsurg::rounded_box_shape({0, 0, -6e-3}, {12e-3, 12e-3, 6e-3}, 1e-3),
                              fine)
          .mesh;
  pbdsurg::Scene scene;
  const pbdsurg::Index body = scene.add_body("liver", block);
  pbdsurg::Solver solver(scene);
  const pbdsurg::ThermalBody liver{body, pbdsurg::tissues::liver().heat};
  pbdsurg::CauteryOptions options;
  options.contact_radius = std::sqrt(area / std::numbers::pi);
  pbdsurg::Cautery cautery(solver.tissue(), std::span(&liver, 1), options);

  const Eigen::Vector3f tip(0, 0, 0);  // on top
  std::printf("  t s   R ohm  P W  hottest  depth mm  width mm  removed mm^3\n");
  double removed = 0;
  constexpr double kStep = 10e-3;  // s
  const int count = std::max(1, static_cast<int>(std::lround(seconds / kStep)));
  for (int i = 1; i <= count; ++i) {
    const pbdsurg::CauteryReport report =
        cautery.update(solver, {tip, tip}, pbdsurg::cut_settings(power), kStep);
    removed += 1e9 * report.removed_volume;
    if (i % std::max(1, count / 10) != 0) {
      continue;
    }
    double depth = 0, radius = 0;  // mm, of what is coagulated by 63 percent and more
    for (pbdsurg::Index v = 0; v < block.vertex_count(); ++v) {
      if (cautery.field().survival()[v] < std::exp(-1)) {
        const Eigen::Vector3d& x = block.positions()[v];
        depth = std::max(depth, -1e3 * x.z());
        radius = std::max(radius, 1e3 * x.head<2>().norm());
      }
    }
    std::printf("%5.2f %7.0f %4.1f %8.0f %9.1f %9.1f %13.1f\n", i * kStep, report.resistance,
                report.power, report.hottest, depth, 2 * radius, removed);
  }
  const pbdsurg::HeatLedger& ledger = cautery.field().ledger();
  std::printf("%.1f J in = %.1f warmth + %.1f steam + %.1f removed; %.1f J into the electrode\n",
              ledger.in, ledger.sensible, ledger.latent, ledger.removed,
              cautery.electrode_energy());
} catch (const std::exception& error) {
  std::fprintf(stderr, "heat: %s\n", error.what());
  return 2;
}
