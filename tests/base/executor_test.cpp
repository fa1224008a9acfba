// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/executor.h"

#include <thread>

#include "pbdsurg/base/error.h"

#include "lib/base/executor_state.h"
#include "lib/base/processors.h"
#include "lib/base/step_team.h"
#include "tests/support/catch.h"

namespace pbdsurg {

using testing::ContainsSubstring;

TEST_CASE("executor: each says who works", "[unit]") {
  CHECK_FALSE(Executor());
  CHECK_THROWS_AS(Executor().kind(), InvalidArgument);
  CHECK_THROWS_AS(Executor().name(), InvalidArgument);
  const Executor serial = executor::serial();
  CHECK(serial.kind() == ExecutorKind::serial);
  CHECK(serial.name() == "serial");
  const Executor two = executor::threads(2);
  CHECK(two.kind() == ExecutorKind::threads);
  CHECK(two.name() == "2 threads");
  CHECK(executor::threads(1).name() == "1 thread");
  CHECK_FALSE(two.state()->is_to_choose());
  CHECK(two.state()->threads() == 2);

  const Executor some = executor::threads();
  CHECK(some.state()->is_to_choose());
  CHECK(some.state()->most_threads() == processor_count());
  CHECK(some.state()->threads() == 1);
  CHECK(executor::threads(1'000'000).state()->threads() == 8 * processor_count());
  CHECK_THROWS_AS(executor::threads(-2), InvalidArgument);
  CHECK_THROWS_WITH(executor::threads(-2), ContainsSubstring("threads is -2"));
}

TEST_CASE("executor: copies are the same, others are not", "[unit]") {
  const Executor two = executor::threads(2);
  const Executor copy = two;
  CHECK(copy == two);
  CHECK_FALSE(two == executor::threads(2));
  CHECK(Executor().or_else(two) == two);
  CHECK(two.or_else(executor::serial()) == two);
  CHECK(copy.state() == two.state());
}

// Would catch a team that two have at once, one that is not given back, or one that is made for
// nobody.
TEST_CASE("executor: one at a time has its threads", "[unit]") {
  const Executor executor = executor::threads(3);
  CHECK(TeamLease(nullptr, 3).team() == nullptr);
  CHECK(TeamLease(executor.state(), 1).team() == nullptr);
  CHECK(TeamLease(executor::serial().state(), 3).team() == nullptr);
  for (int i = 0; i < 2; ++i) {
    const TeamLease lease(executor.state(), 3);
    REQUIRE(lease.team() != nullptr);
    CHECK(lease.team()->size() == 3);
    CHECK(TeamLease(executor.state(), 2).team() == nullptr);
    bool is_alone = false;
    std::jthread([&] { is_alone = TeamLease(executor.state(), 3).team() == nullptr; }).join();
    CHECK(is_alone);
  }
}

}  // namespace pbdsurg
