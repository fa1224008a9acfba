// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/safety_chain.h"

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

constexpr float kTick = 1e-3F;  // s

Eigen::Vector3f up(float newtons) {
  return {0, newtons, 0};
}

SafetyChain engaged_chain(const SafetyLimits& limits = {}) {
  SafetyChain chain(limits);
  for (int i = 0; i < 1100; ++i) {
    static_cast<void>(chain.apply(up(0), {}));
  }
  REQUIRE(chain.engaged() == 1);
  return chain;
}

float after(SafetyChain& chain, float newtons, int ticks, const SafetyInput& input = {}) {
  for (int i = 0; i < ticks; ++i) {
    static_cast<void>(chain.apply(up(newtons), input));
  }
  return chain.commanded().y();
}

}  // namespace

TEST_CASE("safety chain: force waits until it is quiet, then comes in slowly", "[unit]") {
  SafetyChain chain;
  CHECK(after(chain, 1, 1000) == 0);
  CHECK(after(chain, 0.1F, 19) == 0);
  CHECK(after(chain, 1, 1000) == 0);
  CHECK(after(chain, 0.1F, 20) == 0);
  CHECK(after(chain, 1, 500) == Approx(0.5).epsilon(0.01));
  CHECK(after(chain, 1, 510) == Approx(1));
  // resists motion only while it comes in
  Engagement engagement;
  const Eigen::Vector3f still = Eigen::Vector3f::Zero();
  for (int i = 0; i < 520; ++i) {
    static_cast<void>(engagement.apply(up(0), still, kTick));
  }
  CHECK(engagement.apply(up(0), up(0.1F), kTick).y() ==
        Approx(-0.1F * Engagement::kDamping).epsilon(0.01));
}

TEST_CASE("safety chain: steps are within the slew limit, down to zero as well", "[unit]") {
  SafetyChain chain = engaged_chain();
  CHECK(after(chain, 1, 1) == Approx(0.2));
  CHECK(after(chain, 1, 1) == Approx(0.4));
  CHECK(after(chain, 1, 10) == Approx(1));
  CHECK(after(chain, std::numeric_limits<float>::quiet_NaN(), 1) == Approx(0.8));
  CHECK(after(chain, std::numeric_limits<float>::infinity(), 9) == 0);
  CHECK(chain.faults().count(ServoFault::bad_force) == 1);
  CHECK(chain.engaged() == 0);
  SafetyChain late = engaged_chain();  // a late tick steps no further
  CHECK(after(late, 1, 1, {.tick = 0.02F}) == Approx(0.2));
}

TEST_CASE("safety chain: zeros of the gates are reached, and counted once", "[unit]") {
  const auto check_gate = [](ServoFault fault, const SafetyInput& input) {
    SafetyChain chain = engaged_chain();
    CHECK(after(chain, 1, 20) == Approx(1));
    CHECK(after(chain, 1, 1, input) == Approx(0.8));
    CHECK(after(chain, 1, 20, input) == 0);
    CHECK(chain.engaged() == 0);
    if (fault != ServoFault::device_lost) {  // which the servo counts
      CHECK(chain.faults().count(fault) == 1);
      CHECK(chain.faults().is_on(fault));
    }
    CHECK(after(chain, 1, 2000) == 0);
    CHECK_FALSE(chain.faults().is_on(fault));
  };
  check_gate(ServoFault::speed, {.velocity = {1.1F, 0, 0}});
  check_gate(ServoFault::stale_packet, {.packet_age = 0.15F});
  check_gate(ServoFault::device_lost, {.is_ready = false});
}

TEST_CASE("safety chain: stale packets fade out in time and slowly", "[unit]") {
  for (const float period : {1e-3F, 0.01F, 0.033F}) {
    StallWatchdog watchdog;
    float last = 1;
    for (float age = 0; age < 0.2F; age += kTick) {
      const float gain = watchdog.gain(age, period, kTick);
      CHECK(last - gain < 0.0126F);  // of 2.6 N: 0.033 N/ms
      last = gain;
      if (age < 1.5F * period) {
        CHECK(gain == 1);  // one that is late is not stale
      }
      if (age > 0.141F) {
        CHECK(gain == 0);
      }
    }
    CHECK(watchdog.gain(0, period, kTick) <= 0.0101F);  // no step on return
  }
}

TEST_CASE("safety chain: peaks keep their direction", "[unit]") {
  SafetyChain chain = engaged_chain();
  for (int i = 0; i < 30; ++i) {
    static_cast<void>(chain.apply({30, 40, 0}, {}));
  }
  CHECK((chain.commanded() - Eigen::Vector3f(0.6F * 2.6F, 0.8F * 2.6F, 0)).norm() < 1e-4F);
  CHECK(chain.faults().count(ServoFault::peak) == 1);
  CHECK(after(chain, 5, 30, {.is_warm = true}) == Approx(1.3));
  CHECK(chain.faults().count(ServoFault::warm_motors) == 1);

  CHECK(limits_of_motors(3.3F, 0.88F).peak == Approx(2.6));
  CHECK(limits_of_motors(2, 0.5F).peak == Approx(1.6));
  CHECK_THROWS_AS(limits_of_motors(0, 1), InvalidArgument);
  CHECK_THROWS_AS(limits_of_motors(1, std::numeric_limits<float>::quiet_NaN()), InvalidArgument);
}

TEST_CASE("safety chain: motors stay within what they can do for long", "[unit]") {
  SafetyChain chain = engaged_chain();
  CHECK(after(chain, 2.6F, 1000) == Approx(2.6).epsilon(0.01));  // a second is no matter
  float last = chain.commanded().y(), largest_step = 0;
  double squares = 0;
  constexpr int kTicks = 300000, kLast = 30000;
  for (int i = 0; i < kTicks; ++i) {
    const float force = chain.apply(up(2.6F), {}).y();
    largest_step = std::max(largest_step, std::abs(force - last));
    last = force;
    squares += i >= kTicks - kLast ? static_cast<double>(force) * static_cast<double>(force) : 0;
  }
  CHECK(std::sqrt(squares / kLast) <= 0.88 * 1.02);
  CHECK(last > 0.8F);
  CHECK(largest_step < 2e-3F);
  CHECK(chain.faults().count(ServoFault::budget) == 1);
}

TEST_CASE("safety chain: any input leaves finite force in clamp and slew", "[unit]") {
  std::uint64_t drawn = 0;
  SafetyChain chain = engaged_chain();
  const auto wild = [&]() -> float {
    switch (random_bits(11, 0, drawn++) % 8) {
      case 0:
        return std::numeric_limits<float>::quiet_NaN();
      case 1:
        return -std::numeric_limits<float>::infinity();
      case 2:
        return 3e38F;
      case 3:
        return 100;
      default:
        return static_cast<float>(0.2 * random_unit(11, 1, drawn) - 0.1);
    }
  };
  Eigen::Vector3f last = chain.commanded();
  for (int i = 0; i < 100000; ++i) {
    const bool is_calm = i / 3000 % 2 == 0;
    const Eigen::Vector3f force =
        chain.apply(is_calm ? up(i % 200 < 100 ? 100.0F : -100.0F) * (i % 3000 > 1500)
                            : Eigen::Vector3f(wild(), wild(), wild()),
                    {.velocity = is_calm ? up(0) : up(wild())});
    REQUIRE(force.allFinite());
    REQUIRE(force.norm() <= 2.6001F);
    REQUIRE((force - last).norm() <= 0.2001F);
    last = force;
  }
}

TEST_CASE("safety chain: faults have names", "[unit]") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kServoFaultCount; ++i) {
    names.insert(name_of(static_cast<ServoFault>(i)));
  }
  CHECK(names.size() == kServoFaultCount);
  CHECK(names.count("") == 0);
}

}  // namespace pbdsurg
