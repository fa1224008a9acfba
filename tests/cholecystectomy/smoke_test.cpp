// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/smoke.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

const Eigen::Vector3f kSource(0.01F, 0.02F, 0.03F);

void burn(Smoke& smoke, double seconds, double power, double dt = 5e-3, double suction = 0) {
  const int steps = static_cast<int>(std::lround(seconds / dt));
  for (int i = 0; i < steps; ++i) {
    smoke.advance(dt, kSource, power, suction);
  }
}

double opacity_of(const Smoke& smoke) {
  double sum = 0;
  for (const SmokePuff& puff : smoke.puffs()) {
    sum += puff.opacity;
  }
  return sum;
}

}  // namespace

// Would catch puffs that never die, and a haze that stays.
TEST_CASE("smoke: it thins to nothing once the current stops", "[unit]") {
  Smoke smoke;
  burn(smoke, 3, 40);
  REQUIRE(!smoke.puffs().empty());
  REQUIRE(smoke.haze() > 0.1F);
  burn(smoke, Smoke::kLongestLife, 0);
  CHECK(smoke.puffs().empty());
  burn(smoke, 300, 0);
  CHECK(smoke.haze() < 1e-4F);
}

// Would catch smoke by time in place of energy, and smoke without any.
TEST_CASE("smoke: more power makes more puffs and more haze, none makes none", "[unit]") {
  Smoke none, weak, strong;
  burn(none, 1.5, 0);
  burn(weak, 1.5, 10);
  burn(strong, 1.5, 40);
  CHECK(none.puffs().empty());
  CHECK(none.haze() == 0);
  CHECK(strong.puffs().size() > 3 * weak.puffs().size());
  CHECK(strong.haze() > 3 * weak.haze());
  CHECK(opacity_of(strong) > 3 * opacity_of(weak));
}

// Would catch arrays that grow with power or time, and opacities that add up beyond 1.
TEST_CASE("smoke: puffs and haze are bounded, whatever the power", "[unit]") {
  Smoke smoke;
  const double power = GENERATE(100.0, 1e4, 1e9, 1e300);
  for (int i = 0; i < 2000; ++i) {
    smoke.advance(5e-3, kSource, power);
    REQUIRE(smoke.puffs().size() <= Smoke::kMostPuffs);
  }
  CHECK(smoke.puffs().size() > Smoke::kMostPuffs / 2);
  CHECK(smoke.haze() < 1);
  for (const SmokePuff& puff : smoke.puffs()) {
    REQUIRE(puff.center.allFinite());
    REQUIRE(puff.opacity >= 0);
    REQUIRE(puff.opacity <= 1);
    REQUIRE((puff.center - kSource).norm() < 0.2F);
  }
}

// Would catch an array that is reallocated in a long operation.
TEST_CASE("smoke: puffs stay where they are in memory", "[unit]") {
  Smoke smoke;
  burn(smoke, 1, 5);
  const SmokePuff* before = smoke.puffs().data();
  burn(smoke, 5, 300);
  CHECK(smoke.puffs().data() == before);
}

// Would catch random numbers that depend on anything but the seed.
TEST_CASE("smoke: a seed gives the same puffs to the bit, another seed others", "[unit]") {
  Smoke first(3), second(3), other(4);
  for (Smoke* smoke : {&first, &second, &other}) {
    burn(*smoke, 2, 35);
  }
  REQUIRE(first.puffs().size() == second.puffs().size());
  for (std::size_t i = 0; i < first.puffs().size(); ++i) {
    REQUIRE(first.puffs()[i].center == second.puffs()[i].center);
    REQUIRE(first.puffs()[i].opacity == second.puffs()[i].opacity);
  }
  CHECK(first.puffs().back().center != other.puffs().back().center);
}

// Would catch explicit integration, puffs counted by steps, and a decay that is linear in dt.
TEST_CASE("smoke: steps of 5 and 10 ms give the same smoke", "[unit]") {
  Smoke fine, coarse;
  for (const auto& [seconds, power, suction] :
       {std::tuple(1.2, 33.0, 0.0), {0.5, 0.0, 1.0}, {0.8, 47.0, 0.3}}) {
    burn(fine, seconds, power, 5e-3, suction);
    burn(coarse, seconds, power, 10e-3, suction);
  }
  CHECK(coarse.haze() == Approx(fine.haze()).epsilon(1e-5));
  // one puff may be born, or die, in rounding
  REQUIRE(std::abs(static_cast<int>(coarse.puffs().size()) -
                   static_cast<int>(fine.puffs().size())) <= 1);
  const std::size_t count = std::min(coarse.puffs().size(), fine.puffs().size());
  REQUIRE(count > 20);
  for (std::size_t i = 1; i < count / 2; ++i) {  // from the youngest on
    const SmokePuff& a = fine.puffs()[fine.puffs().size() - i];
    const SmokePuff& b = coarse.puffs()[coarse.puffs().size() - i];
    REQUIRE((a.center - b.center).norm() < 1e-5F);
    REQUIRE(a.radius == Approx(b.radius).epsilon(1e-3));
  }
}

// Would catch suction that does nothing, and one that acts on puffs alone.
TEST_CASE("smoke: suction clears the haze with its time constant, and thins puffs", "[unit]") {
  Smoke still, sucked;
  burn(still, 2, 40);
  burn(sucked, 2, 40);
  const double depth = -std::log1p(-still.haze());
  burn(still, 1, 0);
  burn(sucked, 1, 0, 5e-3, 1);
  CHECK(-std::log1p(-still.haze()) == Approx(depth * std::exp(-1 / 25.0)).epsilon(1e-3));
  CHECK(-std::log1p(-sucked.haze()) == Approx(depth * std::exp(-1 / 4.0)).epsilon(1e-3));
  CHECK(opacity_of(sucked) < 0.3 * opacity_of(still));
}

// Would catch smoke that falls, or goes the world's z whatever is up.
TEST_CASE("smoke: puffs rise, spread and thin as they age", "[unit]") {
  const Eigen::Vector3f up = GENERATE(Eigen::Vector3f(0, 0, 2), Eigen::Vector3f(-1, 1, 0));
  Smoke smoke(7, up);
  burn(smoke, 1, 40);
  const auto puffs = smoke.puffs();
  const std::size_t third = puffs.size() / 3;
  Eigen::Vector3f old = Eigen::Vector3f::Zero(), young = old;
  for (std::size_t i = 0; i < third; ++i) {
    old += (puffs[i].center - kSource) / static_cast<float>(third);
    young += (puffs[puffs.size() - 1 - i].center - kSource) / static_cast<float>(third);
  }
  CHECK(old.dot(up.normalized()) > young.dot(up.normalized()) + 0.01F);
  CHECK(puffs.front().radius > 2 * puffs.back().radius);
  CHECK(puffs.front().opacity < 0.5F * puffs.back().opacity);
}

TEST_CASE("smoke: values out of range are refused by name, a lost source makes haze alone",
          "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Smoke smoke;
  CHECK_THROWS_WITH(smoke.advance(-1, kSource, 1), ContainsSubstring("time step"));
  CHECK_THROWS_WITH(smoke.advance(5e-3, kSource, nan), ContainsSubstring("power"));
  CHECK_THROWS_WITH(smoke.advance(5e-3, kSource, 1, 1.5), ContainsSubstring("suction"));
  CHECK_THROWS_AS(Smoke(1, Eigen::Vector3f::Zero()), pbdsurg::InvalidArgument);
  for (int i = 0; i < 100; ++i) {
    smoke.advance(5e-3, {0, nan, 0}, 40);
  }
  CHECK(smoke.puffs().empty());
  CHECK(smoke.haze() > 0);
}

}  // namespace cholecystectomy
