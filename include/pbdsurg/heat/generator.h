// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an electrosurgical generator delivers to a load.

#include <cstdint>
#include <optional>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// The wave that a generator makes.
enum class GeneratorMode : std::uint8_t {
  cut,            ///< a continuous wave
  coagulate,      ///< short bursts of high voltage
  known_current,  ///< the same current into any load, as in Pan et al. 2020; no real device does it
};

/// Voltages and currents are root mean squares; limits hold within a burst.
struct GeneratorSettings {
  GeneratorMode mode;    ///< the wave
  double power;          ///< W, mean over bursts and pauses
  double current_limit;  ///< A
  double voltage_limit;  ///< V
  double duty = 1;       ///< share of time within bursts, (0, 1]
};

/// A cutting wave of up to 450 V. Laparoscopic hooks are driven with 10 to 80 W.
/// Currents are those of the power at 100 ohm (the law of the Valleylab Force FX; numbers typical).
PBDSURG_API GeneratorSettings cut_settings(double power);

/// Bursts of up to 1500 V, 8 % of the time.
PBDSURG_API GeneratorSettings coagulate_settings(double power);

/// @param current  A
PBDSURG_API GeneratorSettings known_current_settings(double current);

/// Switched off, where settings are optional.
[[nodiscard]] constexpr std::optional<GeneratorSettings> off_settings() noexcept {
  return std::nullopt;
}

/// Which limit governs.
enum class GeneratorRegime : std::uint8_t { current, power, voltage, open_circuit };

/// Root mean squares over bursts and pauses, so that power = voltage * current, and the potential
/// scaled to `voltage` heats with `power`. Bursts are microseconds long, heat takes milliseconds.
struct OperatingPoint {
  double voltage = 0;  ///< V across the load
  double current = 0;  ///< A
  double power = 0;    ///< W into the load, never above the setting
  GeneratorRegime regime = GeneratorRegime::open_circuit;  ///< which limit governs
  /// The peak within bursts reaches kArcVoltage, at which sparks jump through steam.
  bool may_arc = false;
};

/// V, peak: below it current heats until steam stops it (Koninckx et al., "Electrosurgery: heating,
/// sparking and electrical arcs").
inline constexpr double kArcVoltage = 200;

/// The control law of real devices: as resistance rises, first constant current, then constant
/// power, then constant voltage, each passing into the next without a jump.
class PBDSURG_API Generator {
 public:
  /// @throws InvalidArgument  naming the setting that is not positive and finite, or the duty
  ///                          outside (0, 1]; of a known current, only that is looked at
  explicit Generator(const GeneratorSettings& settings);

  /// As given.
  [[nodiscard]] const GeneratorSettings& settings() const noexcept { return settings_; }

  /// @param resistance  ohm, of the whole circuit. Zero is a short circuit: full current, no power.
  ///                    What is infinite, negative or not a number is an open circuit: no current.
  [[nodiscard]] OperatingPoint drive(double resistance) const noexcept;

 private:
  GeneratorSettings settings_;
};

}  // namespace pbdsurg
