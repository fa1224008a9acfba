// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/lumen.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"

namespace pbdsurg {
namespace {

// Pa: where flow through an orifice becomes linear, so that it has a slope at rest.
constexpr double kLaminar = 1;
// Of ambient pressure: what a gas is linearised at is not thinner.
constexpr double kThinnest = 0.1;

}  // namespace

Lumen::Lumen(const Tissue& tissue, std::span<const Triangle> wall, const LumenOptions& options)
    : cavity_(tissue, wall), options_(options) {
  check_positive("density", options.density, " kg/m^3");
  check_positive("ambient_pressure", options.ambient_pressure, " Pa");
  check(options.discharge > 0 && options.discharge <= 1, "discharge", options.discharge,
        "in (0, 1]");
}

void Lumen::set_inflow(float flow) {
  check(std::isfinite(flow), "flow", flow, "finite");
  inflow_ = flow;
}

void Lumen::set_leak(float area) {
  check_not_negative("area", area);
  leak_ = area;
}

void Lumen::set_reservoir(float area, float pressure) {
  check_not_negative("area", area);
  check(std::isfinite(pressure), "pressure", pressure, "finite");
  reservoir_area_ = area;
  reservoir_pressure_ = pressure;
}

LumenState Lumen::state(Index copy) const {
  check(copy >= 0, "copy", copy, "not negative");
  return static_cast<std::size_t>(copy) < copies_.size() ? copies_[copy].now : LumenState{};
}

void Lumen::set_state(const LumenState& state, Index copy) {
  check(copy >= 0, "copy", copy, "not negative");
  check_not_negative("amount", state.amount);
  check(std::isfinite(state.pressure) && state.pressure >= -options_.ambient_pressure, "pressure",
        state.pressure, "finite and not below vacuum");
  copies_.resize(std::max(copies_.size(), static_cast<std::size_t>(copy) + 1));
  copies_[copy].now = state;
  copies_[copy].version = cavity_.version();
}

void Lumen::begin_step(Index copies) {
  const auto count = static_cast<std::size_t>(copies);
  check(copies_.size() <= count, "copy", static_cast<double>(copies_.size()) - 1,
        "one of the solver's");
  copies_.resize(count);
  if (listed_ != cavity_.version()) {
    list_vertices();
  }
  for (Copy& own : copies_) {
    own.corners.resize(vertices_.size());
    own.ways.resize(vertices_.size());
  }
}

void Lumen::list_vertices() {
  vertices_.assign(cavity_.vertices().begin(), cavity_.vertices().end());
  triangles_.assign(cavity_.triangles().begin(), cavity_.triangles().end());
  for (Triangle& triangle : triangles_) {
    for (Index& v : triangle) {
      v = static_cast<Index>(std::ranges::lower_bound(vertices_, v) - vertices_.begin());
    }
  }
  listed_ = cavity_.version();
}

void Lumen::renumber(const Tissue&, const Renumbering&) noexcept {
  for (Copy& own : copies_) {
    own.version += own.version + 1 == cavity_.version() ? 1 : 0;  // the same wall
  }
}

// m^3/(s Pa), of an orifice at a difference of pressure: a chord of its law, through zero. The law
// with a laminar end is that of Simscape's block "Orifice (IL)".
double Lumen::conductance(double area, double difference) const {
  const double least = difference * difference + kLaminar * kLaminar;
  return double{options_.discharge} * area * std::sqrt(2 / double{options_.density}) /
         std::sqrt(std::sqrt(least));
}

void Lumen::begin_substep(const ConstraintSweep& sweep) {
  sweep.tissue().check_follower(cavity_, "a lumen");
  Copy& own = copies_[sweep.copy()];
  LumenState start = own.now;
  if (own.version != cavity_.version()) {  // a new wall: as much as gives the pressure there was
    for (std::size_t i = 0; i < own.ways.size(); ++i) {
      own.ways[i] = sweep.start(vertices_[i]).cast<double>();
    }
    start.pressure = cavity_.wall_count() > 0 ? start.pressure : 0;
    start.amount = volume_of(own.ways) * (is_gas() ? 1 + start.pressure / ambient() : 1);
    if (!sweep.is_probe()) {
      own.now = start;
      own.version = cavity_.version();
    }
  }
  const double h = sweep.dt();
  const double out = conductance(leak_ + hole_area(sweep), start.pressure);
  const double in = conductance(reservoir_area_, start.pressure - reservoir_pressure_);
  own.most = std::max(0.0, start.amount + h * (inflow_ + in * reservoir_pressure_));
  own.drain = h * (out + in);
  own.pressure = start.pressure;
  own.multiplier = 0;
}

void Lumen::project(ConstraintSweep& sweep) {
  if (cavity_.wall_count() == 0) {
    return;
  }
  Copy& own = copies_[sweep.copy()];
  const double volume = measure(own, sweep);
  // V (P + p) = P (most - drain p), P the ambient pressure, at the last p; of a liquid P is endless
  const double absolute = ambient() + std::max(double{own.pressure}, (kThinnest - 1) * ambient());
  const double ratio = is_gas() ? ambient() / absolute : 1;
  const double compliance = (is_gas() ? std::max(volume, 0.0) / absolute : 0) + ratio * own.drain;
  own.multiplier = sweep.satisfy_together(
      own.corners, static_cast<float>(ratio * (volume - own.most)), static_cast<float>(compliance),
      own.multiplier, {.least = -options_.ambient_pressure});
  own.pressure = own.multiplier;
  if (!sweep.is_probe()) {
    own.now = {std::max(0.0, own.most - own.drain * own.pressure), own.pressure};
  }
}

// Of the vertices of the wall, and how it changes with each.
double Lumen::measure(Copy& own, const ConstraintSweep& sweep) const {
  for (std::size_t i = 0; i < own.ways.size(); ++i) {
    own.ways[i] = sweep.way(vertices_.front(), vertices_[i]).cast<double>();
    own.corners[i] = {vertices_[i], Eigen::Vector3f::Zero()};
  }
  for (const Triangle& triangle : triangles_) {
    const Eigen::Vector3d &a = own.ways[triangle[0]], &b = own.ways[triangle[1]],
                          &c = own.ways[triangle[2]];
    const Eigen::Vector3f third = ((b - a).cross(c - a) / 6).cast<float>();
    for (const Index i : triangle) {
      own.corners[i].gradient += third;
    }
  }
  return volume_of(own.ways);
}

double Lumen::volume_of(std::span<const Eigen::Vector3d> places) const {
  double sum = 0;
  for (const Triangle& triangle : triangles_) {
    const Eigen::Vector3d &a = places[triangle[0]], &b = places[triangle[1]],
                          &c = places[triangle[2]];
    sum += (a - places[0]).dot((b - places[0]).cross(c - places[0]));
  }
  return sum / 6;
}

double Lumen::hole_area(const ConstraintSweep& sweep) const {
  double sum = 0;
  for (Index hole = 0; hole < cavity_.hole_count(); ++hole) {
    Eigen::Vector3d area = Eigen::Vector3d::Zero();
    for (const Triangle& cap : cavity_.caps(hole)) {
      const Eigen::Vector3d a = sweep.start(cap[0]).cast<double>();
      area +=
          (sweep.start(cap[1]).cast<double>() - a).cross(sweep.start(cap[2]).cast<double>() - a);
    }
    sum += area.norm() / 2;
  }
  return sum;
}

}  // namespace pbdsurg
