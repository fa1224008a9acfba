// SPDX-License-Identifier: Apache-2.0
#include "bench/support/static_energy.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

namespace pbdsurg::bench {
namespace {

constexpr int kMostNewtonSteps = 200;
constexpr double kTolerance = 1e-9;  // of the load

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

Eigen::Matrix3d deformation(const Element& element, const Positions& x) {
  Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 4; ++i) {
    f += x[element.vertices[i]] * element.shapes[i].transpose();
  }
  return f;
}

// What has become of the direction of the fibres.
Eigen::Vector3d stretched_fibre(const Element& element, const Positions& x) {
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    along += element.fibre_shares[i] * x[element.vertices[i]];
  }
  return along;
}

double pressure_of(const Element& element, double volume_ratio) {
  return element.moduli.lambda * (volume_ratio - 1) - element.moduli.mu;
}

// Visits what pulls or pushes, each with its direction from second to first and its length.
template <class Visit>
void for_each_bar(std::span<const Bar> bars, const Positions& x, Visit visit) {
  for (const Bar& bar : bars) {
    const Eigen::Vector3d d = x[bar.first] - x[bar.second];
    const double length = d.norm();
    if (!bar.is_limit || length > bar.rest_length) {
      visit(bar, d, length);
    }
  }
}

std::vector<Bar> make_bars(const Scene& scene) {
  std::vector<Bar> bars;
  for (const Link& link : scene.links()) {
    bars.push_back(
        {link.first, link.second, 1.0 / link.stiffness.compliance, link.rest_length, false});
  }
  for (const Body& body : scene.bodies()) {
    const Material& material = body.material;
    if (!std::isfinite(material.max_stretch)) {
      continue;
    }
    for (const Edge& edge : find_edges(scene.tets().subspan(body.first_tet, body.tet_count))) {
      const double length = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
      bars.push_back({edge[0], edge[1], material.youngs_modulus * length,
                      material.max_stretch * length, true});
    }
  }
  return bars;
}

}  // namespace

StaticEnergy::StaticEnergy(const Scene& scene)
    : scene_(scene),
      elements_(make_elements(scene)),
      bars_(make_bars(scene)),
      pulls_(static_cast<std::size_t>(scene.vertex_count()), Eigen::Vector3d::Zero()) {
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    stays_.push_back(scene.is_fixed(v));
  }
  for (const Element& element : elements_) {
    const double edge = std::cbrt(6 * element.volume);
    contact_stiffness_ = std::max(contact_stiffness_, 1e4 * 3 * element.moduli.mu * edge);
  }
}

void StaticEnergy::hold(std::span<const Index> vertices) {
  for (const Index v : vertices) {
    stays_[v] = true;
  }
}

void StaticEnergy::press(const Eigen::Vector3d& center, double radius) {
  spheres_.push_back({center, radius});
}

void StaticEnergy::pull(Index vertex, const Eigen::Vector3d& force) {
  pulls_[vertex] = force;
}

double StaticEnergy::value(const Positions& x) const {
  double energy = 0;
  for (const Element& element : elements_) {
    const Eigen::Matrix3d f = deformation(element, x);
    const auto [mu, lambda] = element.moduli;
    const double excess = f.determinant() - 1 - mu / lambda;
    const double tension = std::max(0.0, stretched_fibre(element, x).norm() - 1);
    energy += element.volume * (0.5 * mu * (f.squaredNorm() - 3) + 0.5 * lambda * excess * excess +
                                0.5 * element.fibre_stiffness * tension * tension);
  }
  for_each_bar(bars_, x, [&](const Bar& bar, const Eigen::Vector3d&, double length) {
    energy += 0.5 * bar.stiffness * (length - bar.rest_length) * (length - bar.rest_length);
  });
  const Eigen::Vector3d gravity = scene_.gravity().cast<double>();
  for (std::size_t v = 0; v < x.size(); ++v) {
    energy -= (scene_.masses()[v] * gravity + pulls_[v]).dot(x[v] - scene_.positions()[v]);
    for (const Sphere& sphere : spheres_) {
      const double depth = std::max(0.0, sphere.radius - (x[v] - sphere.center).norm());
      energy += 0.5 * contact_stiffness_ * depth * depth;
    }
  }
  return energy;
}

Positions StaticEnergy::all_forces(const Positions& x) const {
  Positions result;
  for (std::size_t v = 0; v < x.size(); ++v) {
    result.emplace_back(scene_.masses()[v] * scene_.gravity().cast<double>() + pulls_[v]);
    for (const Sphere& sphere : spheres_) {
      const Eigen::Vector3d out = x[v] - sphere.center;
      const double depth = std::max(0.0, sphere.radius - out.norm());
      result.back() += contact_stiffness_ * depth * out.normalized();
    }
  }
  for (const Element& element : elements_) {
    const VolumeRatio ratio(x, element.vertices, element.volume);
    const Eigen::Matrix3d f = deformation(element, x);
    const double pressure = pressure_of(element, ratio.value);
    const Eigen::Vector3d along = stretched_fibre(element, x);
    const double slack = std::max(0.0, 1 - 1 / along.norm());
    for (int i = 0; i < 4; ++i) {
      result[element.vertices[i]] -=
          element.volume *
          (element.moduli.mu * (f * element.shapes[i]) + pressure * ratio.gradient[i] +
           element.fibre_stiffness * slack * element.fibre_shares[i] * along);
    }
  }
  for_each_bar(bars_, x, [&](const Bar& bar, const Eigen::Vector3d& d, double length) {
    // a link of no length at rest has no direction to lose
    const double stretch = bar.rest_length > 0 ? 1 - bar.rest_length / length : 1;
    const Eigen::Vector3d pull = bar.stiffness * stretch * d;
    result[bar.first] -= pull;
    result[bar.second] += pull;
  });
  return result;
}

Positions StaticEnergy::forces(const Positions& x) const {
  Positions result = all_forces(x);
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (stays_[v]) {
      result[v].setZero();
    }
  }
  return result;
}

Eigen::SparseMatrix<double> StaticEnergy::hessian(const Positions& x) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](Index row, Index column, const Eigen::Matrix3d& block) {
    if (stays_[row] || stays_[column]) {
      return;
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        entries.emplace_back(3 * row + i, 3 * column + j, block(i, j));
      }
    }
  };
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  for (const Element& element : elements_) {
    const VolumeRatio ratio(x, element.vertices, element.volume);
    const double pressure = pressure_of(element, ratio.value);
    const Eigen::Vector3d along = stretched_fibre(element, x);
    Eigen::Matrix3d fibres = Eigen::Matrix3d::Zero();  // Pa
    if (const double length = along.norm(); length > 1) {
      fibres = element.fibre_stiffness *
               ((1 - 1 / length) * one + along * along.transpose() / (length * length * length));
    }
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        const double shear = element.moduli.mu * element.shapes[i].dot(element.shapes[j]);
        add(element.vertices[i], element.vertices[j],
            element.volume *
                (shear * one + element.fibre_shares[i] * element.fibre_shares[j] * fibres +
                 pressure * ratio.second[i][j] +
                 element.moduli.lambda * ratio.gradient[i] * ratio.gradient[j].transpose()));
      }
    }
  }
  for_each_bar(bars_, x, [&](const Bar& bar, const Eigen::Vector3d& d, double length) {
    Eigen::Matrix3d block = bar.stiffness * one;
    if (bar.rest_length > 0) {
      const Eigen::Vector3d n = d / length;
      // what turns is held by tension alone
      const double across = std::max(0.0, 1 - bar.rest_length / length);
      block = bar.stiffness * (n * n.transpose() + across * (one - n * n.transpose()));
    }
    add(bar.first, bar.first, block);
    add(bar.second, bar.second, block);
    add(bar.first, bar.second, -block);
    add(bar.second, bar.first, -block);
  });
  for (Index v = 0; v < scene_.vertex_count(); ++v) {
    for (const Sphere& sphere : spheres_) {
      const Eigen::Vector3d out = x[v] - sphere.center;
      if (out.norm() < sphere.radius) {
        add(v, v, contact_stiffness_ * out.normalized() * out.normalized().transpose());
      }
    }
    for (int i = 0; i < 3 && stays_[v]; ++i) {
      entries.emplace_back(3 * v + i, 3 * v + i, 1.0);
    }
  }
  const Eigen::Index size = 3 * scene_.vertex_count();
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

double StaticEnergy::imbalance(const Positions& x) const {
  double sum = 0;
  for (const Eigen::Vector3d& force : forces(x)) {
    sum += force.norm();
  }
  return sum;
}

double StaticEnergy::load(const Positions& x) const {
  const Positions all = all_forces(x);
  double sum = pressing_force(x).norm();
  for (std::size_t v = 0; v < x.size(); ++v) {
    sum +=
        stays_[v] ? all[v].norm() : scene_.masses()[v] * scene_.gravity().norm() + pulls_[v].norm();
  }
  return sum;
}

std::vector<Eigen::Vector3d> StaticEnergy::holding_forces(std::span<const Index> vertices,
                                                          const Positions& x) const {
  const Positions all = all_forces(x);
  std::vector<Eigen::Vector3d> result;
  for (const Index v : vertices) {
    result.emplace_back(-all[v]);
  }
  return result;
}

Eigen::Vector3d StaticEnergy::pressing_force(const Positions& x) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& each : x) {
    for (const Sphere& sphere : spheres_) {
      const Eigen::Vector3d out = each - sphere.center;
      sum += contact_stiffness_ * std::max(0.0, sphere.radius - out.norm()) * out.normalized();
    }
  }
  return sum;
}

Positions find_equilibrium(const StaticEnergy& energy, Positions x) {
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
  for (int step = 0; step < kMostNewtonSteps; ++step) {
    if (energy.imbalance(x) <= kTolerance * energy.load(x)) {
      return x;
    }
    const Positions forces = energy.forces(x);
    const Eigen::Map<const Eigen::VectorXd> force(forces[0].data(),
                                                  static_cast<Eigen::Index>(3 * forces.size()));
    // where the energy is not convex, as much of a diagonal as makes it so
    Eigen::SparseMatrix<double> hessian = energy.hessian(x);
    const double diagonal = hessian.diagonal().mean();
    for (double share = 0; share < 10; share = share == 0 ? 1e-3 : 4 * share) {
      Eigen::SparseMatrix<double> shifted = hessian;
      shifted.diagonal().array() += share * diagonal;
      factors.compute(shifted);
      if (factors.info() == Eigen::Success && factors.vectorD().minCoeff() > 0) {
        break;
      }
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
  throw Error("the equilibrium is not found: forces of " + std::to_string(energy.imbalance(x)) +
              " N remain");
}

Positions find_equilibrium_by_steps(const StaticEnergy& energy, const Positions& places,
                                    int steps) {
  const std::span<const Eigen::Vector3d> rest = energy.scene().positions();
  Positions x(rest.begin(), rest.end());
  for (int step = 1; step <= steps; ++step) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (energy.stays(static_cast<Index>(v))) {
        x[v] = rest[v] + (static_cast<double>(step) / steps) * (places[v] - rest[v]);
      }
    }
    x = find_equilibrium(energy, std::move(x));
  }
  return x;
}

namespace {

Positions in_double(std::span<const Eigen::Vector3f> positions) {
  Positions result;
  for (const Eigen::Vector3f& x : positions) {
    result.push_back(x.cast<double>());
  }
  return result;
}

double farthest_of(const Positions& some, const Positions& others) {
  double farthest = 0;
  for (std::size_t v = 0; v < some.size(); ++v) {
    farthest = std::max(farthest, (some[v] - others[v]).norm());
  }
  return farthest;
}

}  // namespace

HeldRest rest_with_held(const Scene& scene, std::span<const Index> held,
                        std::span<const Eigen::Vector3f> positions) {
  StaticEnergy energy(scene);
  energy.hold(held);
  const Positions start = in_double(positions);
  const Positions rest = find_equilibrium(energy, start);
  HeldRest result{Eigen::Vector3d::Zero(), farthest_of(rest, start)};
  for (const Eigen::Vector3d& each : energy.holding_forces(held, rest)) {
    result.force -= each;
  }
  return result;
}

HeldRest rest_under_ball(const Scene& scene, const Eigen::Vector3d& center, double radius,
                         std::span<const Eigen::Vector3f> positions) {
  StaticEnergy energy(scene);
  energy.press(center, radius);
  const Positions start = in_double(positions);
  const Positions rest = find_equilibrium(energy, start);
  return {-energy.pressing_force(rest), farthest_of(rest, start)};
}

double lowest_frequency(const Scene& scene, const Positions& equilibrium) {
  const Eigen::Vector3d gravity = scene.gravity().cast<double>();
  double work = 0;
  double inertia = 0;
  for (std::size_t v = 0; v < equilibrium.size(); ++v) {
    const Eigen::Vector3d moved = equilibrium[v] - scene.positions()[v];
    work += scene.masses()[v] * gravity.dot(moved);
    inertia += scene.masses()[v] * moved.squaredNorm();
  }
  return std::sqrt(work / inertia);
}

}  // namespace pbdsurg::bench
