// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/jacobi.h"

#include <algorithm>

#include "bench/support/neo_hookean.h"

namespace pbdsurg::bench {
namespace {

Vec3<float> to_vec3(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

JacobiLoop::JacobiLoop(const Cantilever& bar, JacobiSum sum, int substeps, int iterations,
                       float damping)
    : substeps_(substeps),
      iterations_(iterations),
      damping_(damping),
      gravity_(to_vec3(bar.scene.gravity())) {
  const NeoHookeanModuli moduli(bar.material);
  shares_.assign(bar.scene.vertex_count(), 0);
  for (const Element& element : make_elements(bar.scene)) {
    Constraint constraint{element.vertices, {}, {}};
    float* const parameters = constraint.parameters;
    for (int i = 0; i < 9; ++i) {
      parameters[NeoHookeanConstraint::kInverseShape + i] =
          static_cast<float>(element.shapes[1 + i / 3][i % 3]);
    }
    parameters[NeoHookeanConstraint::kStiffness] = static_cast<float>(moduli.mu * element.volume);
    parameters[NeoHookeanConstraint::kRatio] = static_cast<float>(moduli.lambda / moduli.mu);
    constraints_.push_back(constraint);
    for (const Index v : element.vertices) {
      shares_[v] += 1;
    }
  }
  for (Index v = 0; v < bar.scene.vertex_count(); ++v) {
    x_.push_back(to_vec3(bar.scene.positions()[v].cast<float>()));
    inverse_masses_.push_back(
        bar.scene.is_fixed(v) ? 0 : static_cast<float>(1 / bar.scene.masses()[v]));
    shares_[v] = sum == JacobiSum::averaged ? 1 / shares_[v] : 1;
  }
  previous_ = x_;
  velocities_.assign(x_.size(), {});
  moves_ = velocities_;
}

void JacobiLoop::write_positions(const std::vector<Eigen::Vector3f>& positions) {
  std::transform(positions.begin(), positions.end(), x_.begin(), to_vec3);
  std::fill(velocities_.begin(), velocities_.end(), Vec3<float>{});
}

void JacobiLoop::step(float dt) {
  const float h = dt / static_cast<float>(substeps_);
  const float keep = 1 / (1 + damping_ * h);
  for (int substep = 0; substep < substeps_; ++substep) {
    for (std::size_t v = 0; v < x_.size(); ++v) {
      previous_[v] = x_[v];
      if (inverse_masses_[v] > 0) {
        x_[v] = x_[v] + h * (keep * velocities_[v] + h * gravity_);
      }
    }
    for (Constraint& constraint : constraints_) {
      std::fill_n(constraint.multipliers, NeoHookeanConstraint::kMultiplierCount, 0.0F);
    }
    for (int i = 0; i < iterations_; ++i) {
      iterate({1 / h, 1 / (h * h)});
    }
    for (std::size_t v = 0; v < x_.size(); ++v) {
      velocities_[v] = (1 / h) * (x_[v] - previous_[v]);
    }
  }
}

std::vector<Eigen::Vector3f> JacobiLoop::positions() const {
  std::vector<Eigen::Vector3f> positions;
  for (const Vec3<float>& x : x_) {
    positions.emplace_back(x.x, x.y, x.z);
  }
  return positions;
}

void JacobiLoop::iterate(const Substep<float>& substep) {
  std::fill(moves_.begin(), moves_.end(), Vec3<float>{});
  for (Constraint& constraint : constraints_) {
    Vec3<float> x[4];
    float w[4];
    for (int i = 0; i < 4; ++i) {
      x[i] = x_[constraint.vertices[i]];
      w[i] = inverse_masses_[constraint.vertices[i]];
    }
    NeoHookeanConstraint::project<ProjectionMode::compliance>(x, w, constraint.parameters, substep,
                                                              constraint.multipliers);
    for (int i = 0; i < 4; ++i) {
      const Index v = constraint.vertices[i];
      moves_[v] = moves_[v] + (x[i] - x_[v]);
    }
  }
  for (std::size_t v = 0; v < x_.size(); ++v) {
    x_[v] = x_[v] + shares_[v] * moves_[v];
  }
}

}  // namespace pbdsurg::bench
