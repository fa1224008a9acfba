// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/equilibrium.h"

#include <Eigen/SparseCholesky>
#include <array>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg::bench {
namespace {

using Positions = std::vector<Eigen::Vector3d>;

constexpr int kMostNewtonSteps = 60;
constexpr double kTolerance = 1e-9;  // residual

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Volume over that at rest: gradients and second derivatives at corners.
struct VolumeRatio {
  VolumeRatio(const Positions& x, const Tet& tet, double rest_volume) {
    const std::array<Eigen::Vector3d, 3> e{x[tet[1]] - x[tet[0]], x[tet[2]] - x[tet[0]],
                                           x[tet[3]] - x[tet[0]]};
    const double scale = 1 / (6 * rest_volume);
    value = scale * e[0].cross(e[1]).dot(e[2]);
    gradient[0].setZero();
    for (auto& row : second) {
      row.fill(Eigen::Matrix3d::Zero());
    }
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const int k = (i + 2) % 3;
      gradient[i + 1] = scale * e[j].cross(e[k]);
      gradient[0] -= gradient[i + 1];
      second[i + 1][j + 1] = -scale * skew(e[k]);
      second[i + 1][k + 1] = scale * skew(e[j]);
    }
    for (int i = 1; i < 4; ++i) {
      for (int j = 1; j < 4; ++j) {
        second[0][i] -= second[j][i];
        second[i][0] -= second[i][j];
        second[0][0] += second[j][i];
      }
    }
  }

  double value;
  std::array<Eigen::Vector3d, 4> gradient;               // 1/m
  std::array<std::array<Eigen::Matrix3d, 4>, 4> second;  // 1/m^2
};

}  // namespace

BarEnergy::BarEnergy(const Cantilever& bar)
    : bar_(bar), moduli_(bar.material), elements_(make_elements(bar.scene)) {}

double BarEnergy::value(const Positions& x) const {
  double energy = 0;
  for (const Element& element : elements_) {
    Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 4; ++i) {
      f += x[element.vertices[i]] * element.shapes[i].transpose();
    }
    const double excess = f.determinant() - 1 - moduli_.mu / moduli_.lambda;
    energy += element.volume *
              (0.5 * moduli_.mu * (f.squaredNorm() - 3) + 0.5 * moduli_.lambda * excess * excess);
  }
  const Eigen::Vector3d gravity = bar_.scene.gravity().cast<double>();
  for (std::size_t v = 0; v < x.size(); ++v) {
    energy -= bar_.scene.masses()[v] * gravity.dot(x[v] - bar_.scene.positions()[v]);
  }
  return energy;
}

Positions BarEnergy::forces(const Positions& x) const {
  Positions result;
  for (std::size_t v = 0; v < x.size(); ++v) {
    result.emplace_back(bar_.scene.masses()[v] * bar_.scene.gravity().cast<double>());
  }
  for (const Element& element : elements_) {
    const VolumeRatio ratio(x, element.vertices, element.volume);
    Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 4; ++i) {
      f += x[element.vertices[i]] * element.shapes[i].transpose();
    }
    const double pressure = moduli_.lambda * (ratio.value - 1) - moduli_.mu;
    for (int i = 0; i < 4; ++i) {
      result[element.vertices[i]] -=
          element.volume * (moduli_.mu * (f * element.shapes[i]) + pressure * ratio.gradient[i]);
    }
  }
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (bar_.scene.is_fixed(static_cast<Index>(v))) {
      result[v].setZero();
    }
  }
  return result;
}

Eigen::SparseMatrix<double> BarEnergy::hessian(const Positions& x) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](Index row, Index column, const Eigen::Matrix3d& block) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        entries.emplace_back(3 * row + i, 3 * column + j, block(i, j));
      }
    }
  };
  for (const Element& element : elements_) {
    const VolumeRatio ratio(x, element.vertices, element.volume);
    const double pressure = moduli_.lambda * (ratio.value - 1) - moduli_.mu;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const Index row = element.vertices[i];
        const Index column = element.vertices[j];
        if (bar_.scene.is_fixed(row) || bar_.scene.is_fixed(column)) {
          continue;
        }
        const double shear = moduli_.mu * element.shapes[i].dot(element.shapes[j]);
        add(row, column,
            element.volume * (shear * Eigen::Matrix3d::Identity() + pressure * ratio.second[i][j] +
                              moduli_.lambda * ratio.gradient[i] * ratio.gradient[j].transpose()));
      }
    }
  }
  for (Index v = 0; v < bar_.scene.vertex_count(); ++v) {
    if (bar_.scene.is_fixed(v)) {
      add(v, v, Eigen::Matrix3d::Identity());
    }
  }
  const Eigen::Index size = 3 * bar_.scene.vertex_count();
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

double BarEnergy::residual(const Positions& x) const {
  double sum = 0;
  for (const Eigen::Vector3d& force : forces(x)) {
    sum += force.norm();
  }
  return sum / bar_.weight;
}

double BarEnergy::step_residual(const Positions& x, const Positions& inertial, double dt) const {
  const Positions elastic_and_weight = forces(x);
  const Eigen::Vector3d gravity = bar_.scene.gravity().cast<double>();
  double sum = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!bar_.scene.is_fixed(static_cast<Index>(v))) {
      const double mass = bar_.scene.masses()[v];
      // the inertial position holds the weight already
      sum +=
          (elastic_and_weight[v] - mass * gravity - mass / (dt * dt) * (x[v] - inertial[v])).norm();
    }
  }
  return sum / bar_.weight;
}

Positions find_equilibrium(const Cantilever& bar) {
  const BarEnergy energy(bar);
  Positions x(bar.scene.positions().begin(), bar.scene.positions().end());
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
  for (int step = 0; step < kMostNewtonSteps; ++step) {
    if (energy.residual(x) < kTolerance) {
      return x;
    }
    const Positions forces = energy.forces(x);
    const Eigen::Map<const Eigen::VectorXd> force(forces[0].data(),
                                                  static_cast<Eigen::Index>(3 * forces.size()));
    factors.compute(energy.hessian(x));
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0)) {
      throw Error("the bar's equilibrium: the energy is not convex after " + std::to_string(step) +
                  " of Newton's steps");
    }
    const Eigen::VectorXd move = factors.solve(force);
    const double before = energy.value(x);
    const double slope = move.dot(force);
    Positions next(x.size());
    for (double share = 1; share > 1e-6; share /= 2) {
      for (std::size_t v = 0; v < x.size(); ++v) {
        next[v] = x[v] + share * move.segment<3>(static_cast<Eigen::Index>(3 * v));
      }
      // near the end, the energy's own rounding hides what a step gains
      if (energy.value(next) <= before - 1e-4 * share * slope || slope < 1e-12 * std::abs(before)) {
        break;
      }
    }
    x = next;
  }
  throw Error("the bar's equilibrium is not found: a residual of " +
              std::to_string(energy.residual(x)) + " remains");
}

double lowest_frequency(const Cantilever& bar, const Positions& equilibrium) {
  const Eigen::Vector3d gravity = bar.scene.gravity().cast<double>();
  double work = 0;
  double inertia = 0;
  for (std::size_t v = 0; v < equilibrium.size(); ++v) {
    const Eigen::Vector3d moved = equilibrium[v] - bar.scene.positions()[v];
    work += bar.scene.masses()[v] * gravity.dot(moved);
    inertia += bar.scene.masses()[v] * moved.squaredNorm();
  }
  return std::sqrt(work / inertia);
}

}  // namespace pbdsurg::bench
