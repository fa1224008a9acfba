// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/smoke.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "pbdsurg/base/random.h"

namespace cholecystectomy {
namespace {

constexpr double kBirthRadius = 1.2e-3;  // m
constexpr double kSpreading = 6e-3;      // m, that the radius grows in the first second
constexpr double kJetSpeed = 0.03;       // m/s
constexpr double kJetTime = 0.15;        // s, in which the gas around stops it
constexpr double kRiseSpeed = 0.03;      // m/s, of the plume
constexpr double kRiseTime = 0.1;        // s, until it rises so fast
constexpr double kEddySize = 4e-3;       // m, after the first second
constexpr double kEddyRate = 1.2;        // turns a second
constexpr double kPuffDepth = 1.0;       // optical, of kEnergyPerPuff at birth
constexpr double kDensestPuff = 3;       // of that
constexpr double kSuctionTime = 0.35;    // s, in which suction thins puffs to 1 / e

// Least time between puffs: not more than kMostPuffs are then alive.
constexpr double kLeastInterval = Smoke::kLongestLife / static_cast<double>(Smoke::kMostPuffs);

void check(const char* name, double value, double most) {
  if (!(value >= 0) || !(value <= most) || !std::isfinite(value)) {
    throw pbdsurg::InvalidArgument(std::string("smoke: ") + name + " is " + std::to_string(value) +
                                   "; it must be finite and in [0, " + std::to_string(most) + "]");
  }
}

}  // namespace

Smoke::Smoke(std::uint64_t seed, const Eigen::Vector3f& up)
    : seed_(seed),
      up_(up.stableNormalized()),
      last_source_(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN())) {
  if (!up.allFinite() || up.isZero(0)) {
    throw pbdsurg::InvalidArgument("smoke: up has no direction");
  }
  origins_.reserve(kMostPuffs);
  puffs_.reserve(kMostPuffs);
}

float Smoke::haze() const noexcept {
  // the largest float below 1
  return std::min(static_cast<float>(-std::expm1(-haze_depth_)), std::nextafter(1.0F, 0.0F));
}

Eigen::Vector3f Smoke::random_vector(std::uint64_t number, std::uint64_t use) const {
  Eigen::Vector3f vector;
  for (int axis = 0; axis < 3; ++axis) {
    vector[axis] = static_cast<float>(
        2 * pbdsurg::random_unit(seed_, number, 3 * use + static_cast<std::uint64_t>(axis)) - 1);
  }
  return vector;
}

void Smoke::advance(double dt, const Eigen::Vector3f& source, double power, double suction) {
  check("the time step", dt, std::numeric_limits<double>::max());
  check("the power", power, std::numeric_limits<double>::max());
  check("the suction", suction, 1);
  const double rate = (1 - suction) / kClearing + suction / kClearingBySuction;
  const double left = std::exp(-rate * dt);
  haze_depth_ = haze_depth_ * left + kDepthPerJoule * power * (1 - left) / rate;

  const double thinning = suction / kSuctionTime;
  for (Origin& origin : origins_) {
    origin.age += dt;
    origin.depth *= std::exp(-thinning * dt);
  }
  emit(dt, source, power, thinning);
  std::erase_if(origins_, [](const Origin& origin) { return origin.age >= origin.life; });
  puffs_.clear();
  for (const Origin& origin : origins_) {
    puffs_.push_back(puff_of(origin));
  }
}

// Puffs leave between steps, at even intervals of energy, on the way that the source took.
void Smoke::emit(double dt, const Eigen::Vector3f& source, double power, double thinning) {
  const Eigen::Vector3f from = last_source_.allFinite() ? last_source_ : source;
  last_source_ = source;
  if (!(power > 0) || !(dt > 0) || !source.allFinite()) {
    return;
  }
  const double interval = std::max(kEnergyPerPuff / power, kLeastInterval);
  const double depth = kPuffDepth * std::min(interval * power / kEnergyPerPuff, kDensestPuff);
  double since = -due_ * interval;  // before this step, of the last puff
  due_ += dt / interval;
  const double count = std::floor(due_);
  due_ -= count;
  if (!(count < 1e9)) {
    return;  // a step of years
  }
  const auto whole = static_cast<std::uint64_t>(count);
  const std::uint64_t skipped = whole > kMostPuffs ? whole - kMostPuffs : 0;  // died since
  since += static_cast<double>(skipped) * interval;
  emitted_ += skipped;
  for (std::uint64_t i = skipped; i < whole; ++i) {
    since += interval;
    const double age = std::max(dt - since, 0.0);
    const double life =
        kShortestLife + (kLongestLife - kShortestLife) * pbdsurg::random_unit(seed_, emitted_, 100);
    if (origins_.size() == kMostPuffs) {
      origins_.erase(origins_.begin());
    }
    const auto share = static_cast<float>(std::clamp(since / dt, 0.0, 1.0));
    origins_.push_back(
        {from + share * (source - from), emitted_, age, depth * std::exp(-thinning * age), life});
    ++emitted_;
  }
}

SmokePuff Smoke::puff_of(const Origin& origin) const {
  const double age = origin.age;
  // distances of a jet that is braked, and of a plume that is sped up, by drag
  const double jet = kJetSpeed * kJetTime * -std::expm1(-age / kJetTime);
  const double rise = kRiseSpeed * (age - kRiseTime * -std::expm1(-age / kRiseTime));
  const double spread = std::sqrt(age);
  Eigen::Vector3f center = origin.source;
  center += static_cast<float>(jet) * (random_vector(origin.number, 0) + up_);
  center += static_cast<float>(rise) * (1 + 0.3F * random_vector(origin.number, 1).x()) * up_;
  // eddies: two turns of their own phase in each axis, none at birth
  const Eigen::Vector3f phase = random_vector(origin.number, 2);
  const Eigen::Vector3f pace = random_vector(origin.number, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const double angle = std::numbers::pi * phase[axis];
    const double turn = 2 * std::numbers::pi * kEddyRate * (0.7 + 0.3 * pace[axis]) * age;
    const double eddy = std::sin(angle + turn) + 0.5 * std::sin(2.3 * angle + 1.9 * turn);
    center[axis] += static_cast<float>(0.5 * kEddySize * age * eddy);
  }
  const double radius = kBirthRadius + kSpreading * spread;
  // a choice of display: of the same smoke in a larger puff, 1 / radius^2 would be left
  const double share = kBirthRadius / radius;
  const double fade = std::clamp(1 - age / origin.life, 0.0, 1.0);
  const double depth = origin.depth * std::pow(share, 0.9) * fade;
  return {center, static_cast<float>(radius), static_cast<float>(-std::expm1(-depth))};
}

}  // namespace cholecystectomy
