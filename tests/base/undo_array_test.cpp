// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/undo_array.h"

#include <algorithm>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a value that is written twice, or popped and pushed again, and comes back wrong.
TEST_CASE("undo array: undo takes back all since the edit began, and nothing before",
          "[property]") {
  UndoArray<Index> array(std::vector<Index>{1, 2, 3});
  std::vector<Index> mirror{1, 2, 3};
  for (std::uint64_t edit = 0; edit < 500; ++edit) {
    array.begin_edit();
    const std::vector<Index> before = mirror;
    for (std::uint64_t i = 0; i < 1 + random_bits(1, edit) % 20; ++i) {
      const auto value = static_cast<Index>(random_bits(2, edit, i) % 1000);
      switch (random_bits(3, edit, i) % 3) {
        case 0:
          array.push_back(value);
          mirror.push_back(value);
          break;
        case 1:
          if (!mirror.empty()) {
            array.pop_back();
            mirror.pop_back();
          }
          break;
        default:
          if (!mirror.empty()) {
            const auto place = static_cast<Index>(random_bits(4, edit, i) % mirror.size());
            array.set(place, value);
            mirror[place] = value;
          }
      }
    }
    REQUIRE(std::equal(mirror.begin(), mirror.end(), array.values().begin(), array.values().end()));
    if (random_bits(5, edit) % 2 == 0) {
      array.undo();
      mirror = before;
      REQUIRE(
          std::equal(mirror.begin(), mirror.end(), array.values().begin(), array.values().end()));
    }
  }
}

}  // namespace pbdsurg
