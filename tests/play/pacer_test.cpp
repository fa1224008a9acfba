// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/pacer.h"

#include "apps/cholecystectomy/play/picture_pace.h"
#include "tests/support/catch.h"

namespace cholecystectomy {

using pbdsurg::testing::Approx;

namespace {

constexpr double kStep = 0.01;

// Steps whenever one is due, each of which takes some time of the clock. Gives how many were done.
int run(Pacer& pacer, double& now, double length, double step_takes) {
  int steps = 0;
  for (const double end = now + length; now < end;) {
    if (pacer.is_due(now)) {
      now += step_takes;
      pacer.took_step(now);
      ++steps;
    } else {
      now = pacer.next();
    }
  }
  return steps;
}

}  // namespace

// Would catch time that drifts from the clock.
TEST_CASE("pacer: steps that are short enough keep to the clock", "[unit]") {
  double now = 5;
  Pacer pacer(kStep, now);
  CHECK(run(pacer, now, 10, 0.004) == Approx(1000).margin(1));
  CHECK(pacer.factor() == Approx(1).margin(0.011));
  CHECK(pacer.owed(now) < 0.006);
}

// Would catch a debt of steps that grows without end, or a stretch that is not told.
TEST_CASE("pacer: steps that are too long stretch time, and owe no more than a moment", "[unit]") {
  double now = 0;
  Pacer pacer(kStep, now);
  CHECK(run(pacer, now, 10, 0.02) == Approx(500).margin(3));
  CHECK(pacer.factor() == Approx(0.5).margin(0.01));
  CHECK(pacer.owed(now) <= Pacer::kMostOwed + 1e-9);
  // after the load, what was given up is not caught up
  CHECK(run(pacer, now, 1, 0.001) <= 100 + static_cast<int>(Pacer::kMostOwed / kStep) + 1);
}

// Would catch a load of a moment that costs time for good.
TEST_CASE("pacer: one late step is caught up", "[unit]") {
  double now = 0;
  Pacer pacer(kStep, now);
  run(pacer, now, 1, 0.001);
  now += 0.04;
  CHECK(run(pacer, now, 0.96, 0.001) == Approx(100).margin(1));
}

TEST_CASE("pacer: slow motion, and standing still", "[unit]") {
  double now = 0;
  Pacer pacer(kStep, now);
  pacer.set_speed(0.25, now);
  CHECK(run(pacer, now, 4, 0.004) == Approx(100).margin(1));
  CHECK(pacer.factor() == Approx(1).margin(0.05));
  pacer.set_speed(0, now);
  CHECK_FALSE(pacer.is_due(now + 100));
  now += 100;
  pacer.set_speed(1, now);  // the pause owes nothing
  CHECK(run(pacer, now, 1, 0.001) == Approx(100).margin(1));
}

// Would catch pictures that starve steps, or that stay few when the load has gone.
TEST_CASE("picture pace: late steps make pictures rarer, to five a second at least", "[unit]") {
  PicturePace pace;
  pace.drew(0, 10);
  CHECK(pace.next() == Approx(10 + PicturePace::kShortest));
  CHECK_FALSE(pace.is_due(10));
  for (int i = 0; i < 100; ++i) {
    pace.drew(0.04, 20);
  }
  CHECK(pace.next() == Approx(20 + PicturePace::kLongest));
  CHECK_FALSE(pace.is_due(20.1));
  CHECK(pace.is_due(20.21));
  for (int i = 0; i < 100; ++i) {
    pace.drew(0, 30);
  }
  CHECK(pace.next() == Approx(30 + PicturePace::kShortest));
}

}  // namespace cholecystectomy
