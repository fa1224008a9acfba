// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/nested_domains.h"

#include <algorithm>
#include <array>
#include <vector>

#include "tests/support/catch.h"

namespace pbdsurg {

// Sanitizers would catch arithmetic that overflows where there is nothing to divide.
TEST_CASE("nested domains: few places are one domain", "[unit]") {
  for (const NestedDomains& domains : {NestedDomains(), NestedDomains(0), NestedDomains(5999)}) {
    CHECK(domains.level_count() == 1);
    CHECK(domains.domain_count(0) == 1);
    const NestedDomains::Domain all = domains.domain_of(std::array<Index, 2>{0, 5998});
    CHECK(all.level == 0);
    CHECK(all.index == 0);
  }
}

TEST_CASE("nested domains: leaves are of one size, and two make one of the next level", "[unit]") {
  const Index place_count = 12'003;
  const NestedDomains domains(place_count);
  REQUIRE(domains.level_count() == 3);
  REQUIRE(domains.domain_count(0) == 4);
  std::vector<Index> sizes(4, 0), firsts(4, place_count);
  for (Index place = 0; place < place_count; ++place) {
    const auto [level, leaf] = domains.domain_of(std::array{place});
    REQUIRE(level == 0);
    ++sizes[leaf];
    firsts[leaf] = std::min(firsts[leaf], place);
  }
  CHECK(sizes == std::vector<Index>{3001, 3001, 3001, 3000});
  CHECK(domains.domain_of(std::array{firsts[2], firsts[3]}).level == 1);
  CHECK(domains.domain_of(std::array{firsts[2], firsts[3]}).index == 1);
  CHECK(domains.domain_of(std::array{firsts[1], firsts[2]}).level == 2);
}

}  // namespace pbdsurg
