// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/reference.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include "bench/support/neo_hookean.h"

namespace pbdsurg::bench {
namespace {

void add_forces(const std::vector<Element>& elements, const Positions& x, Positions& forces) {
  for (const Element& element : elements) {
    const auto& [a, b, c, d] = element.vertices;
    Eigen::Matrix3d sides;
    sides << x[b] - x[a], x[c] - x[a], x[d] - x[a];
    Eigen::Matrix3d inverse;  // of the sides at rest
    inverse << element.shapes[1].transpose(), element.shapes[2].transpose(),
        element.shapes[3].transpose();
    const Eigen::Matrix3d f = sides * inverse;
    Eigen::Matrix3d cofactors;
    cofactors << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
    const auto [mu, lambda] = element.moduli;
    const double pressure = lambda * (f.col(0).dot(cofactors.col(0)) - 1) - mu;
    const Eigen::Matrix3d force =
        -element.volume * (mu * f + pressure * cofactors) * inverse.transpose();
    forces[b] += force.col(0);
    forces[c] += force.col(1);
    forces[d] += force.col(2);
    forces[a] -= force.col(0) + force.col(1) + force.col(2);
  }
}

}  // namespace

Motion integrate(const Scene& scene, const Positions& start, double seconds, double substep) {
  const std::vector<Element> elements = make_elements(scene);
  const Eigen::Vector3d gravity = scene.gravity().cast<double>();
  Motion motion{start, Positions(start.size(), Eigen::Vector3d::Zero())};
  Positions forces(start.size());
  const auto kick = [&](double dt) {
    forces.assign(start.size(), Eigen::Vector3d::Zero());
    add_forces(elements, motion.x, forces);
    for (std::size_t v = 0; v < start.size(); ++v) {
      if (!scene.is_fixed(static_cast<Index>(v))) {
        motion.v[v] += dt * (forces[v] / scene.masses()[v] + gravity);
      }
    }
  };
  const auto count = static_cast<int>(std::lround(seconds / substep));
  kick(substep / 2);
  for (int i = 0; i < count; ++i) {
    for (std::size_t v = 0; v < start.size(); ++v) {
      motion.x[v] += substep * motion.v[v];
    }
    kick(i + 1 < count ? substep : substep / 2);
  }
  return motion;
}

double total_energy(const Scene& scene, const Motion& motion) {
  double energy = StaticEnergy(scene).value(motion.x);
  for (std::size_t v = 0; v < motion.v.size(); ++v) {
    if (!scene.is_fixed(static_cast<Index>(v))) {
      energy += 0.5 * scene.masses()[v] * motion.v[v].squaredNorm();
    }
  }
  return energy;
}

}  // namespace pbdsurg::bench
