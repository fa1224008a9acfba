// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/luby.h"

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {

// Would catch sets that are not maximal: then a constraint could take a lower colour.
TEST_CASE("luby: colours are maximal independent sets", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Coloring coloring = color_luby(constraints, 7);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(testing::has_no_gap(coloring));
    CHECK(testing::leaves_no_lower_color_free(coloring, constraints));
  }
}

TEST_CASE("luby: the result depends on the seed, not on the threads", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const Coloring one = color_luby(sample.view(), 3);
    for (const int threads : {2, 3, 8}) {
      CHECK(color_luby(sample.view(), 3, executor::threads(threads)) == one);
    }
    if (one.color_of.size() > 100) {
      CHECK(color_luby(sample.view(), 4) != one);
    }
  }
}

TEST_CASE("luby: a negative number of threads is refused", "[unit]") {}

}  // namespace pbdsurg
