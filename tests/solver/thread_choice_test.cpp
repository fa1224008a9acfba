// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/thread_choice.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using CostOf = std::function<double(int threads)>;  // s

/// @return  [step] threads that each took
std::vector<int> run(ThreadChoice& choice, int steps, const CostOf& cost_of) {
  std::vector<int> taken;
  for (int i = 0; i < steps; ++i) {
    const int threads = choice.threads();
    taken.push_back(threads);
    const double cost = cost_of(threads);
    const bool is_left_to_one = threads > 1 && cost > choice.limit();
    choice.took(is_left_to_one ? choice.limit() + cost_of(1) : cost);
  }
  return taken;
}

int count_above(const std::vector<int>& taken, int threads) {
  int count = 0;
  for (const int each : taken) {
    count += each > threads ? 1 : 0;
  }
  return count;
}

double shared(int threads) {
  return 8e-3 / threads;
}
double beside_neighbours(int threads) {
  return threads == 1 ? 8e-3 : 80e-3;
}
// work that is too small to share
double tiny(int threads) {
  return 1e-4 + 2e-5 * (threads - 1);
}

}  // namespace

// Would catch a choice that stops short, or takes numbers of threads that are not there.
TEST_CASE("thread choice: takes all threads where each pays", "[unit]") {
  for (const int most : {1, 2, 6, 16, 200}) {
    ThreadChoice choice(most);
    CHECK(choice.threads() == 1);
    run(choice, 400, shared);
    CHECK(choice.threads() == most);
    const std::vector<int> later = run(choice, 4000, shared);
    CHECK(count_above(later, most) == 0);
    CHECK(count_above(later, most / 2) > 3900);  // fewer are tried now and then
  }
}

// Would catch trials that come too often where they keep failing.
TEST_CASE("thread choice: stays at one thread where more are slow", "[unit]") {
  ThreadChoice beside(16);
  CHECK(count_above(run(beside, 1000, beside_neighbours), 1) <= 10);
  CHECK(count_above(run(beside, 10000, beside_neighbours), 1) <= 30);
  ThreadChoice alone(16);  // where a trial costs little, it is made to its end
  CHECK(count_above(run(alone, 1000, tiny), 1) <= 40);
  CHECK(count_above(run(alone, 10000, tiny), 1) <= 90);
}

// Would catch a choice that never moves again, or moves slowly when steps have become slow.
TEST_CASE("thread choice: leaves threads to a neighbour that comes, and takes them when it goes",
          "[unit]") {
  ThreadChoice choice(16);
  run(choice, 400, shared);
  REQUIRE(choice.threads() == 16);
  const std::vector<int> busy = run(choice, 1000, beside_neighbours);
  CHECK(count_above(busy, 1) <= 15);
  REQUIRE(choice.threads() == 1);
  run(choice, 6000, shared);
  CHECK(choice.threads() == 16);
}

// Would catch a single long step, of an edit, that sends all threads away, or after which nothing
// counts as slow.
TEST_CASE("thread choice: one long step changes nothing", "[unit]") {
  ThreadChoice choice(4);
  run(choice, 400, shared);
  REQUIRE(choice.threads() == 4);
  const double limit = choice.limit();
  choice.took(1);
  CHECK(choice.threads() == 4);
  CHECK(choice.limit() == limit);
  CHECK(count_above(run(choice, 300, beside_neighbours), 1) <= 12);
}

// Would catch a mean that slow steps raise until they are no longer slow.
TEST_CASE("thread choice: goes back to one thread where every other step is slow", "[unit]") {
  ThreadChoice choice(2);
  run(choice, 400, [](int threads) { return threads == 1 ? 1e-3 : 0.55e-3; });
  REQUIRE(choice.threads() == 2);
  int step = 0;
  const std::vector<int> taken = run(choice, 500, [&](int threads) {
    return threads == 1 ? 1e-3 : ++step % 2 == 0 ? 30e-3 : 0.55e-3;
  });
  CHECK(count_above(taken, 1) <= 40);
}

// Would catch trials of more threads that leave no turn to fewer.
TEST_CASE("thread choice: between more and fewer threads, both are tried again", "[unit]") {
  ThreadChoice choice(4);
  run(choice, 20000, [](int threads) { return threads == 2 ? 1e-3 : 1.5e-3; });
  REQUIRE(choice.threads() == 2);
  run(choice, 10000, [](int threads) { return threads == 1 ? 0.8e-3 : 1.5e-3; });
  CHECK(choice.threads() == 1);
}

// Would catch limits that are there before anything is known, or that the first, cold step sets.
TEST_CASE("thread choice: a step may take twice the usual time", "[unit]") {
  ThreadChoice choice(4);
  CHECK(std::isinf(choice.limit()));
  choice.took(20e-3);
  CHECK(std::isinf(choice.limit()));
  choice.took(1e-3);
  CHECK(choice.limit() == 2e-3);
}

}  // namespace pbdsurg
