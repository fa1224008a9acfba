// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/cantilever.h"

#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 2e-3;  // m, as in the demo's organs

Material make_tissue() {
  Material tissue;
  tissue.density = 1060;  // kg/m^3
  tissue.model = ElasticModel::neo_hookean;
  tissue.youngs_modulus = 10e3F;  // Pa
  tissue.poissons_ratio = 0.45F;
  return tissue;
}

}  // namespace

Cantilever::Cantilever(const std::array<Index, 3>& cells)
    : material(make_tissue()), length(cells[0] * kEdge), weight(0) {
  const Index body = scene.add_body("bar", testing::make_box(cells, kEdge), material);
  scene.fix_where(body, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEdge; });
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (!scene.is_fixed(v)) {
      weight += scene.masses()[v] * scene.gravity().norm();
    }
    if (scene.positions()[v].x() > length - 0.5 * kEdge) {
      tip.push_back(v);
    }
  }
}

Eigen::Vector3d tip_displacement(const Cantilever& bar,
                                 const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Index v : bar.tip) {
    sum += positions[v] - bar.scene.positions()[v];
  }
  return sum / static_cast<double>(bar.tip.size());
}

}  // namespace pbdsurg::bench
