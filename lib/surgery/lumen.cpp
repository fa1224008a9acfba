// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/lumen.h"

#include <algorithm>
#include <cmath>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/base/check.h"
#include "lib/solver/methods/filling.h"

namespace pbdsurg {
namespace {

Vec3<double> to_double(const Eigen::Vector3f& x) {
  return {x.x(), x.y(), x.z()};
}

}  // namespace

// As devices see it.
class Lumen::OnDevice final : public Filling {
 public:
  explicit OnDevice(Lumen& lumen) : lumen_(lumen) {}

  [[nodiscard]] Surface surface() const override {
    return {lumen_.listed_, lumen_.vertices_, lumen_.triangles_, lumen_.hole_ends_,
            lumen_.wall_count_};
  }
  [[nodiscard]] FillingLaw law() const override { return lumen_.law(); }
  [[nodiscard]] FillingState state(Index copy) const override {
    const LumenState& now = lumen_.copies_[copy].now;
    return {now.amount, now.pressure};
  }
  [[nodiscard]] bool is_new(Index copy) const override {
    return lumen_.copies_[copy].version != lumen_.listed_;
  }
  void check(const Tissue& tissue) const override {
    tissue.check_follower(lumen_.cavity_, "a lumen");
  }
  void take(Index copy, const FillingState& state) override {
    lumen_.copies_[copy].now = {state.amount, state.pressure};
    lumen_.copies_[copy].version = lumen_.listed_;
  }

 private:
  Lumen& lumen_;
};

Lumen::Lumen(const Tissue& tissue, std::span<const Triangle> wall, const LumenOptions& options)
    : cavity_(tissue, wall), options_(options), on_device_(std::make_unique<OnDevice>(*this)) {
  check_positive("density", options.density, " kg/m^3");
  check_positive("ambient_pressure", options.ambient_pressure, " Pa");
  check(options.discharge > 0 && options.discharge <= 1, "discharge", options.discharge,
        "in (0, 1]");
}

Lumen::~Lumen() = default;

Filling* Lumen::filling() noexcept {
  return on_device_.get();
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
  hole_ends_.clear();
  wall_count_ = cavity_.wall_count();
  Index end = wall_count_;
  for (Index hole = 0; hole < cavity_.hole_count(); ++hole) {
    end += static_cast<Index>(cavity_.caps(hole).size());
    hole_ends_.push_back(end);
  }
  listed_ = cavity_.version();
}

void Lumen::renumber(const Tissue&, const Renumbering&) noexcept {
  for (Copy& own : copies_) {
    own.version += own.version + 1 == cavity_.version() ? 1 : 0;  // the same wall
  }
}

FillingLaw Lumen::law() const noexcept {
  return {options_.density,
          options_.ambient_pressure,
          options_.discharge,
          inflow_,
          leak_,
          reservoir_area_,
          reservoir_pressure_,
          options_.contents == LumenContents::gas};
}

void Lumen::begin_substep(const ConstraintSweep& sweep) {
  on_device_->check(sweep.tissue());
  Copy& own = copies_[sweep.copy()];
  LumenState start = own.now;
  if (own.version != cavity_.version()) {  // a new wall: as much as gives the pressure there was
    for (std::size_t i = 0; i < own.ways.size(); ++i) {
      own.ways[i] = to_double(sweep.start(vertices_[i]));
    }
    start.pressure = cavity_.wall_count() > 0 ? start.pressure : 0;
    start.amount = law().amount_in(volume_of(own.ways), start.pressure);
    if (!sweep.is_probe()) {
      own.now = start;
      own.version = cavity_.version();
    }
  }
  const FillingSubstep begun =
      law().begin({start.amount, start.pressure}, hole_area(sweep), sweep.dt());
  own.most = begun.most;
  own.drain = begun.drain;
  own.pressure = begun.pressure;
  own.multiplier = begun.multiplier;
}

void Lumen::project(ConstraintSweep& sweep) {
  if (cavity_.wall_count() == 0) {
    return;
  }
  Copy& own = copies_[sweep.copy()];
  const double volume = measure(own, sweep);
  FillingSubstep now{own.most, own.drain, own.pressure, own.multiplier};
  const auto [value, compliance] = law().constraint(now, volume);
  now.multiplier = sweep.satisfy_together(own.corners, value, compliance, now.multiplier,
                                          {.least = -options_.ambient_pressure});
  now.pressure = now.multiplier;
  own.pressure = own.multiplier = now.multiplier;
  if (!sweep.is_probe()) {
    const FillingState after = FillingLaw::end(now);
    own.now = {after.amount, after.pressure};
  }
}

// Of the vertices of the wall, and how it changes with each.
double Lumen::measure(Copy& own, const ConstraintSweep& sweep) const {
  for (std::size_t i = 0; i < own.ways.size(); ++i) {
    own.ways[i] = to_double(sweep.way(vertices_.front(), vertices_[i]));
    own.corners[i] = {vertices_[i], Eigen::Vector3f::Zero()};
  }
  for (const auto& [a, b, c] : triangles_) {
    const Vec3<float> third = third_of_area(own.ways[a], own.ways[b], own.ways[c]);
    for (const Index i : {a, b, c}) {
      own.corners[i].gradient += Eigen::Vector3f(third.x, third.y, third.z);
    }
  }
  return volume_of(own.ways);
}

double Lumen::volume_of(std::span<const Vec3<double>> places) const {
  double sum = 0;
  for (const auto& [a, b, c] : triangles_) {
    sum += six_volumes(places[0], places[a], places[b], places[c]);
  }
  return sum / 6;
}

double Lumen::hole_area(const ConstraintSweep& sweep) const {
  double sum = 0;
  Index t = wall_count_;
  for (const Index end : hole_ends_) {
    Vec3<double> area;
    for (; t < end; ++t) {
      const auto start = [&](Index i) { return to_double(sweep.start(vertices_[i])); };
      const auto [a, b, c] = triangles_[t];
      area = area + cross(start(b) - start(a), start(c) - start(a));
    }
    sum += std::sqrt(dot(area, area)) / 2;
  }
  return sum;
}

}  // namespace pbdsurg
