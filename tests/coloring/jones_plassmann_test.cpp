// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/jones_plassmann.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {

TEST_CASE("jones_plassmann: valid, first fit in some order, and of its seed alone", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Coloring coloring = color_jones_plassmann(constraints, 7);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(testing::has_no_gap(coloring));
    CHECK(testing::leaves_no_lower_color_free(coloring, constraints));
    CHECK(color_jones_plassmann(constraints, 7) == coloring);
    if (coloring.color_of.size() > 100) {
      CHECK(color_jones_plassmann(constraints, 8) != coloring);
    }
  }
}

}  // namespace pbdsurg
