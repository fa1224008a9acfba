// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/generator.h"

#include <cmath>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

}  // namespace

// I = I_max, then P = P_set, then V = V_max (service manual of the Valleylab Force FX-8C). Would
// catch a wrong duty factor, regimes out of order, and peaks taken for root mean squares.
TEST_CASE("generator: its three regimes have their closed forms", "[validation]") {
  const double duty = GENERATE(1.0, 0.08);
  const GeneratorSettings settings{GeneratorMode::coagulate, 40, 2, 800, duty};
  const Generator generator(settings);
  const double low = 40 / (duty * 2 * 2);       // ohm: d I^2 R = P
  const double high = duty * 800.0 * 800 / 40;  // d V^2 / R = P
  REQUIRE(low < high);

  const OperatingPoint weak = generator.drive(0.3 * low);
  CHECK(weak.regime == GeneratorRegime::current);
  CHECK(weak.current == Approx(2 * std::sqrt(duty)).epsilon(1e-12));
  CHECK(weak.power == Approx(0.3 * 40).epsilon(1e-12));

  const OperatingPoint full = generator.drive(std::sqrt(low * high));
  CHECK(full.regime == GeneratorRegime::power);
  CHECK(full.power == Approx(40).epsilon(1e-12));

  const OperatingPoint blocked = generator.drive(5 * high);
  CHECK(blocked.regime == GeneratorRegime::voltage);
  CHECK(blocked.voltage == Approx(800 * std::sqrt(duty)).epsilon(1e-12));
  CHECK(blocked.power == Approx(40.0 / 5).epsilon(1e-12));
}

// Would catch a jump where one regime passes into the next, and power above the setting anywhere.
TEST_CASE("generator: it is continuous in the load and never exceeds its settings", "[property]") {
  for (const GeneratorSettings& settings :
       {cut_settings(10), cut_settings(30), coagulate_settings(30), coagulate_settings(80)}) {
    const Generator generator(settings);
    OperatingPoint last = generator.drive(1e-6);
    int regimes = 1;
    for (double resistance = 1e-6; resistance < 1e12; resistance *= 1.001) {
      const OperatingPoint now = generator.drive(resistance);
      CHECK(now.power <= settings.power);
      CHECK(now.power == Approx(now.voltage * now.current).epsilon(1e-12));
      CHECK(now.voltage == Approx(now.current * resistance).epsilon(1e-12));
      CHECK(now.voltage <= settings.voltage_limit * std::sqrt(settings.duty) * (1 + 1e-12));
      CHECK(now.current <= settings.current_limit * std::sqrt(settings.duty) * (1 + 1e-12));
      CHECK(now.voltage >= last.voltage * (1 - 1e-12));
      CHECK(now.voltage <= last.voltage * 1.0011);
      CHECK(now.current <= last.current * (1 + 1e-12));
      CHECK(now.current >= last.current / 1.0011);
      CHECK(now.regime >= last.regime);
      CHECK(now.may_arc >= last.may_arc);
      regimes += now.regime != last.regime ? 1 : 0;
      last = now;
    }
    CHECK(regimes == 3);
  }
}

TEST_CASE("generator: short and open circuits are safe", "[unit]") {
  const Generator generator(cut_settings(30));
  const OperatingPoint closed = generator.drive(0);
  CHECK(closed.regime == GeneratorRegime::current);
  CHECK(closed.current == generator.settings().current_limit);
  CHECK((closed.voltage == 0 && closed.power == 0 && !closed.may_arc));
  for (const double load : {kInfinite, kNotANumber, -1.0, -kInfinite}) {
    const OperatingPoint open = generator.drive(load);
    CHECK(open.regime == GeneratorRegime::open_circuit);
    CHECK((open.current == 0 && open.power == 0));
    CHECK(open.voltage == generator.settings().voltage_limit);
    CHECK(open.may_arc);
  }
  for (const double load : {5e-324, 1e-300, 1e300, std::numeric_limits<double>::max()}) {
    const OperatingPoint point = generator.drive(load);
    CHECK((std::isfinite(point.voltage) && std::isfinite(point.current)));
    CHECK((point.power >= 0 && point.power <= 30));
  }
}

// A hook of 1 mm^2 on gallbladder (492 ohm) and on liver (2990 ohm), from the spreading resistance
// 1/(4 sigma a): 30 W take 122 V and 247 mA, and about 300 V.
TEST_CASE("generator: at 30 W a hook boils gallbladder and may arc on liver", "[unit]") {
  const Generator generator(cut_settings(30));
  const OperatingPoint gallbladder = generator.drive(492);
  CHECK(gallbladder.voltage == Approx(122).epsilon(0.01));
  CHECK(gallbladder.current == Approx(0.247).epsilon(0.01));
  CHECK_FALSE(gallbladder.may_arc);
  const OperatingPoint liver = generator.drive(2990);
  CHECK(liver.power == Approx(30));
  CHECK(liver.may_arc);
  // bursts carry the same mean power at a higher peak
  CHECK(Generator(coagulate_settings(30)).drive(492).power == Approx(30));
  CHECK(Generator(coagulate_settings(30)).drive(492).may_arc);
}

TEST_CASE("generator: a known current is the same into any load", "[unit]") {
  const Generator generator(known_current_settings(0.25));
  for (const double load : {0.0, 1e-3, 500.0, 1e9}) {
    const OperatingPoint point = generator.drive(load);
    CHECK(point.regime == GeneratorRegime::current);
    CHECK(point.current == 0.25);
    CHECK(point.power == Approx(0.0625 * load).epsilon(1e-12));
  }
  const OperatingPoint open = generator.drive(kInfinite);
  CHECK((open.power == 0 && open.voltage == 0 && open.current == 0));
}

TEST_CASE("generator: bad settings are refused by name", "[unit]") {
  for (const double bad : {0.0, -1.0, kNotANumber, kInfinite}) {
    CHECK_THROWS_WITH(Generator(cut_settings(bad)), ContainsSubstring("power"));
    CHECK_THROWS_WITH(Generator(known_current_settings(bad)), ContainsSubstring("current"));
    GeneratorSettings settings = cut_settings(30);
    settings.current_limit = bad;
    CHECK_THROWS_WITH(Generator(settings), ContainsSubstring("current limit"));
    settings = cut_settings(30);
    settings.voltage_limit = bad;
    CHECK_THROWS_WITH(Generator(settings), ContainsSubstring("voltage limit"));
  }
  for (const double bad : {0.0, 1.5, kNotANumber}) {
    GeneratorSettings settings = coagulate_settings(30);
    settings.duty = bad;
    CHECK_THROWS_WITH(Generator(settings), ContainsSubstring("duty"));
  }
}

}  // namespace pbdsurg
