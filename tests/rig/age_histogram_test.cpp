// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/age_histogram.h"

#include <limits>

#include "tests/support/catch.h"

namespace rig {

using pbdsurg::testing::Approx;

// Would catch bins of the wrong width, quantiles that are too small, or a worst that is a bin's.
TEST_CASE("age histogram: quantiles are those of the ages, or a fifth more", "[unit]") {
  AgeHistogram ages;
  CHECK(ages.quantile(0.5) == 0);
  for (int i = 1; i <= 1000; ++i) {
    ages.add(1e-5 * i);
  }
  CHECK(ages.count() == 1000);
  CHECK(ages.worst() == 1e-2);
  CHECK(ages.quantile(1) == 1e-2);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    CHECK(ages.quantile(share) >= 1e-2 * share * (1 - 1e-9));
    CHECK(ages.quantile(share) <= 1.2 * (1e-2 * share + 1e-9));
  }
}

// Would catch an index beyond the bins.
TEST_CASE("age histogram: ages that are none, or hours", "[unit]") {
  AgeHistogram ages;
  for (const double age : {0.0, -1.0, 1e4, std::numeric_limits<double>::quiet_NaN()}) {
    ages.add(age);
  }
  CHECK(ages.count() == 4);
  CHECK(ages.worst() == 1e4);
  CHECK(ages.quantile(0.5) == Approx(1e-6));
}

}  // namespace rig
