// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/tissue_color.h"

#include <algorithm>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

constexpr Color kFlesh{0.6F, 0.2F, 0.15F, 1};

void check_color(const Color& color, float red, float green, float blue, float alpha) {
  CHECK(color.red == Approx(red).margin(1e-6));
  CHECK(color.green == Approx(green).margin(1e-6));
  CHECK(color.blue == Approx(blue).margin(1e-6));
  CHECK(color.alpha == Approx(alpha).margin(1e-6));
}

double temperature_at(double k) {
  return 37 + 63 * k;
}

}  // namespace

// Equation 7 with k_change = 0.8 and k_vaporization = 0.99, worked by hand.
TEST_CASE("tissue colour: temperatures colour as equation 7 of the paper", "[validation]") {
  check_color(temperature_color(kFlesh, 37), 0.6F, 0.2F, 0.15F, 1);
  check_color(temperature_color(kFlesh, 20), 0.6F, 0.2F, 0.15F, 1);
  check_color(temperature_color(kFlesh, temperature_at(0.5)), 0.8F, 0.6F, 0.575F, 0.5F);
  // 0.1 C + 0.9 C_2
  check_color(temperature_color(kFlesh, temperature_at(0.9)), 0.96F, 0.848F, 0.735F, 0.73F);
  check_color(temperature_color(kFlesh, 100), 1, 0.82F, 0.70F, 0.2F);
  check_color(temperature_color(kFlesh, 1000), 1, 0.82F, 0.70F, 0.2F);
  // where it changes colour
  CHECK(temperature_color(kFlesh, 87.39).blue == Approx(0.2 * 0.15 + 0.8).epsilon(1e-3));
  CHECK(temperature_color(kFlesh, 87.41).blue == Approx(0.2 * 0.15 + 0.8 * 0.8).epsilon(1e-3));
  CHECK(temperature_color(kFlesh, 99.36).green == Approx(0.92).epsilon(0.01));
  CHECK(temperature_color(kFlesh, 99.38).green == Approx(0.82).epsilon(0.01));
}

// Would catch a colour that heals: after any history of heat, cooling changes no mark.
TEST_CASE("tissue colour: marks of heat never fall, and cooling changes none", "[property]") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    double survival = 1, water = 1, charred = 0;
    BurnMarks last;
    for (std::uint64_t i = 0; i < 200; ++i) {
      const bool cools = i >= 150;
      double temperature =
          cools ? 40 - 0.02 * static_cast<double>(i) : 30 + 300 * random_unit(seed, i);
      survival = surviving(tissues::liver().heat.damage, survival, temperature, 0.01);
      charred = charring(charred, temperature, 0.01);
      const auto boiled = boil(tissues::liver().heat, temperature, water);
      water = boiled.water;
      const BurnMarks now = burn_marks(survival, water, charred);
      CHECK((now.white >= last.white && now.brown >= last.brown && now.charred >= last.charred));
      CHECK((to_byte(now.white) >= to_byte(last.white)));
      if (cools && i > 150) {
        CHECK((now.white == last.white && now.brown == last.brown && now.charred == last.charred));
        const Color a = state_color(kFlesh, now), b = state_color(kFlesh, last);
        CHECK((a.red == b.red && a.green == b.green && a.blue == b.blue));
      }
      last = now;
    }
    CHECK(last.white > 0.99F);
    CHECK(last.charred > 0);
  }
}

TEST_CASE("tissue colour: unburnt flesh keeps its colour, char covers all", "[unit]") {
  check_color(state_color(kFlesh, {}), 0.6F, 0.2F, 0.15F, 1);
  check_color(state_color(kFlesh, {1, 1, 1}), 0.03F, 0.025F, 0.02F, 1);
  // whiter, then darker
  const auto light = [](const BurnMarks& marks) { return state_color(kFlesh, marks).green; };
  CHECK(light({1, 0, 0}) > light({0.5F, 0, 0}));
  CHECK(light({1, 0.5F, 0}) < light({1, 0, 0}));
  CHECK(light({1, 1, 0.5F}) < light({1, 1, 0}));
}

// Would catch a layer that is right for one flesh alone, or for one rule.
TEST_CASE("tissue colour: a layer over any flesh is the colour of that tissue", "[property]") {
  for (std::uint64_t i = 0; i < 300; ++i) {
    const auto share = [&](std::uint64_t k) {
      return static_cast<float>(2 * random_unit(5, i, k) - 0.5);  // often 0 or 1
    };
    const auto clamped = [&](std::uint64_t k) { return std::clamp(share(k), 0.0F, 1.0F); };
    const BurnMarks marks{clamped(0), clamped(1), clamped(2)};
    const double temperature = 30 + 90 * random_unit(5, i, 3);
    const Color flesh{clamped(4), clamped(5), clamped(6), 0.5F};
    for (const ColorRule rule : {ColorRule::state, ColorRule::temperature}) {
      const Color expected = tissue_color(rule, flesh, temperature, marks);
      const Color layer = burn_layer(rule, temperature, marks);
      const Color actual = mix(flesh, layer, layer.alpha);
      CHECK(actual.red == Approx(expected.red).margin(1e-5));
      CHECK(actual.green == Approx(expected.green).margin(1e-5));
      CHECK(actual.blue == Approx(expected.blue).margin(1e-5));
      CHECK(expected.alpha == 0.5F);
    }
  }
  CHECK(burn_layer(ColorRule::state, 200, {}).alpha == 0);
  CHECK(burn_layer(ColorRule::temperature, 37, {1, 1, 1}).alpha == 0);
}

// Would catch a scale on which two temperatures look the same.
TEST_CASE("tissue colour: false colours darken from body temperature to boiling", "[property]") {
  const auto light = [](double temperature) {
    const Color color = false_color(temperature);
    return 0.2126F * color.red + 0.7152F * color.green + 0.0722F * color.blue;
  };
  for (int temperature = 37; temperature < 100; ++temperature) {
    CHECK(light(temperature + 1) < light(temperature));
  }
  CHECK(light(20) == light(37));
  CHECK(light(500) == light(100));
}

TEST_CASE("tissue colour: bytes are rounded and clamped", "[unit]") {
  CHECK(to_byte(0) == 0);
  CHECK(to_byte(1) == 255);
  CHECK(to_byte(0.5F) == 128);
  CHECK(to_byte(-3) == 0);
  CHECK(to_byte(7) == 255);
}

}  // namespace pbdsurg
