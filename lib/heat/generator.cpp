// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/generator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLowResistance = 100;  // ohm, below which current is limited

void check_setting(const char* what, double value, double most, const char* rule) {
  if (!(value > 0 && value <= most)) {
    throw InvalidArgument(std::string("generator ") + what + " is " + std::to_string(value) +
                          "; it must be " + rule);
  }
}

}  // namespace

GeneratorSettings cut_settings(double power) {
  return {GeneratorMode::cut, power, std::sqrt(power / kLowResistance), 450, 1};
}

GeneratorSettings coagulate_settings(double power) {
  constexpr double kDuty = 0.08;
  return {GeneratorMode::coagulate, power, std::sqrt(power / (kDuty * kLowResistance)), 1500,
          kDuty};
}

GeneratorSettings known_current_settings(double current) {
  return {GeneratorMode::known_current, kInfinity, current, kInfinity, 1};
}

Generator::Generator(const GeneratorSettings& settings) : settings_(settings) {
  constexpr double kMost = std::numeric_limits<double>::max();
  const char* const positive = "positive and finite";
  if (settings.mode == GeneratorMode::known_current) {
    check_setting("current", settings.current_limit, kMost, positive);
    settings_ = known_current_settings(settings.current_limit);
    return;
  }
  check_setting("power", settings.power, kMost, positive);
  check_setting("current limit", settings.current_limit, kMost, positive);
  check_setting("voltage limit", settings.voltage_limit, kMost, positive);
  check_setting("duty", settings.duty, 1, "in (0, 1]");
}

OperatingPoint Generator::drive(double resistance) const noexcept {
  const auto& [mode, power, current_limit, voltage_limit, duty] = settings_;
  OperatingPoint point;
  double voltage = 0, current = 0;  // within a burst
  if (!(resistance >= 0 && resistance < kInfinity)) {
    voltage = mode == GeneratorMode::known_current ? 0 : voltage_limit;
  } else {
    point.regime = GeneratorRegime::current;
    current = current_limit;
    voltage = current * resistance;
    const double by_power = std::sqrt(power / duty * resistance);
    if (by_power < voltage) {
      point.regime = GeneratorRegime::power;
      voltage = by_power;
      current = std::sqrt(power / duty / resistance);
    }
    if (voltage_limit < voltage) {
      point.regime = GeneratorRegime::voltage;
      voltage = voltage_limit;
      current = voltage / resistance;
    }
  }
  point.voltage = std::sqrt(duty) * voltage;
  point.current = std::sqrt(duty) * current;
  point.power = std::min(power, point.voltage * point.current);
  point.may_arc = std::sqrt(2.0) * voltage >= kArcVoltage;
  return point;
}

}  // namespace pbdsurg
