// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/file_descriptor.h"

#include <fcntl.h>
#include <unistd.h>

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

bool is_open(int number) {
  return fcntl(number, F_GETFD) >= 0;
}

}  // namespace

// Would catch a descriptor that leaks, is closed twice (the second time it may be another's), or is
// kept by what was moved from.
TEST_CASE("file descriptor: it is closed once, by its last owner", "[unit]") {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  {
    FileDescriptor first(ends[0]);
    FileDescriptor second(std::move(first));
    CHECK_FALSE(first.is_open());  // NOLINT(bugprone-use-after-move)
    CHECK(second.number() == ends[0]);
    FileDescriptor third(ends[1]);
    third = std::move(second);
    CHECK_FALSE(is_open(ends[1]));
    CHECK(is_open(ends[0]));
    third.close();
    CHECK_FALSE(is_open(ends[0]));
    ends[1] = dup(STDIN_FILENO);  // takes a number that was free
    third.close();
  }
  CHECK(is_open(ends[1]));
  close(ends[1]);
}

}  // namespace pbdsurg
