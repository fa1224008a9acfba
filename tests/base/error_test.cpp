// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg {

TEST_CASE("error: a file error says where it is", "[unit]") {
  CHECK(std::string(FileError::at_line("a.msh", 7, "no nodes").what()) == "a.msh:7: no nodes");
  CHECK(std::string(FileError::at_byte("a.stl", 84, "cut off").what()) ==
        "a.stl: byte 84: cut off");
}

}  // namespace pbdsurg
