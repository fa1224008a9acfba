// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/mailbox.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <set>
#include <stdexcept>
#include <stop_token>
#include <thread>
#include <type_traits>
#include <vector>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

static_assert(!std::is_copy_constructible_v<Mailbox<int>>);
static_assert(!std::is_move_constructible_v<Mailbox<int>>);

// Copies count how many there are, and throw when asked to.
struct Throwing {
  static inline int alive = 0;
  static inline int copies_left = 0;  // before one throws

  int value = 0;

  Throwing() { ++alive; }
  Throwing(const Throwing& other) : value(other.value) {
    spend_copy();
    ++alive;
  }
  Throwing& operator=(const Throwing& other) {
    value = -1;  // what is left is no value of anybody
    spend_copy();
    value = other.value;
    return *this;
  }
  ~Throwing() { --alive; }

  static void spend_copy() {
    if (copies_left-- <= 0) {
      throw std::runtime_error("no copy left");
    }
  }
};

// What each published value of the stress tests is made of, by its sequence number.
constexpr std::size_t kWords = 96;  // several cache lines
std::uint64_t word_of(std::uint64_t sequence, std::size_t at) {
  return random_bits(7, sequence, at);
}
template <class Words>
bool is_whole(const Words& words, std::uint64_t sequence) {
  for (std::size_t i = 0; i < kWords; ++i) {
    if (words[i] != word_of(sequence, i)) {
      return false;
    }
  }
  return true;
}

}  // namespace

TEST_CASE("mailbox: the reader has the first value until one is published", "[unit]") {
  Mailbox<int> zero;
  CHECK(zero.take() == 0);
  CHECK(zero.value() == 0);
  CHECK(zero.sequence() == 0);

  Mailbox<int> box(5);
  CHECK(box.draft() == 5);
  CHECK(box.take() == 0);
  CHECK(box.value() == 5);
  box.draft() = 6;  // not published yet
  CHECK(box.take() == 0);
  CHECK(box.value() == 5);
  CHECK(box.publish() == 1);
  CHECK(box.value() == 5);  // not taken yet
  CHECK(box.sequence() == 0);
  CHECK(box.take() == 1);
  CHECK(box.value() == 6);
  CHECK(box.sequence() == 1);
  CHECK(box.take() == 0);
  CHECK(box.value() == 6);
}

// Would catch a mailbox that keeps the oldest value, counts a value twice, or loses count where the
// writer exchanges its slot for one that was not taken.
TEST_CASE("mailbox: the reader gets the newest value and learns how many it missed", "[property]") {
  Mailbox<std::uint64_t> box;
  std::uint64_t published = 0, taken = 0;
  for (std::uint64_t round = 0; round < 2000; ++round) {
    for (std::uint64_t n = random_bits(1, round) % 6; n > 0; --n) {
      box.draft() = 10 * ++published;
      REQUIRE(box.publish() == published);
      REQUIRE(box.value() == 10 * taken);
      REQUIRE(box.sequence() == taken);
    }
    for (std::uint64_t n = random_bits(2, round) % 3; n > 0; --n) {
      REQUIRE(box.take() == published - taken);
      taken = published;
      REQUIRE(box.value() == 10 * taken);
      REQUIRE(box.sequence() == taken);
    }
  }
}

// Would catch a slot that is moved, copied or made anew: its buffer would be another.
TEST_CASE("mailbox: values that can only be moved are filled in place, in three buffers",
          "[unit]") {
  using Buffer = std::unique_ptr<int[]>;
  Mailbox<Buffer> box;
  std::set<const int*> buffers;
  for (int i = 0; i < 60; ++i) {
    Buffer& draft = box.draft();
    if (draft == nullptr) {
      draft = std::make_unique<int[]>(2);
    }
    draft[0] = draft[1] = i;
    buffers.insert(draft.get());
    const int* const read_before = box.value().get();
    CHECK(draft.get() != read_before);
    box.publish();
    CHECK(box.value().get() == read_before);
    if (i % 5 != 1) {
      REQUIRE(box.take() == (i % 5 == 2 ? 2 : 1));
      CHECK(box.value()[0] == i);
      CHECK(box.value()[1] == i);
    }
  }
  CHECK(buffers.size() == 3);
}

// Would catch a slot that is made by a move: an atomic has none.
TEST_CASE("mailbox: values that can be neither copied nor moved", "[unit]") {
  Mailbox<std::atomic<int>> box;
  box.draft() = 3;
  box.publish();
  CHECK(box.take() == 1);
  CHECK(box.value() == 3);
}

TEST_CASE("mailbox: values that can only be copied", "[unit]") {
  struct Named {
    explicit Named(int v) : value(v) {}
    int value;
  };
  static_assert(!std::is_default_constructible_v<Mailbox<Named>>);
  Mailbox<Named> box(Named(4));
  CHECK(box.value().value == 4);
  box.draft().value = 5;
  box.publish();
  CHECK(box.take() == 1);
  CHECK(box.value().value == 5);
}

// Would catch slots that a mailbox without all three leaves behind.
TEST_CASE("mailbox: a first value that cannot be copied three times leaves nothing behind",
          "[unit]") {
  const Throwing first;
  for (int copies = 0; copies < 3; ++copies) {
    Throwing::copies_left = copies;
    CHECK_THROWS_AS(Mailbox<Throwing>(first), std::runtime_error);
    CHECK(Throwing::alive == 1);
  }
  Throwing::copies_left = 3;
  {
    const Mailbox<Throwing> box(first);
    CHECK(Throwing::alive == 4);
  }
  CHECK(Throwing::alive == 1);
}

// Would catch a half-written draft that gets out, or that is counted.
TEST_CASE("mailbox: a value that throws while it is written was never published", "[unit]") {
  Mailbox<Throwing> box;
  Throwing next;
  next.value = 1;
  Throwing::copies_left = 1;
  box.draft() = next;
  box.publish();
  const auto write_badly = [&] {
    Throwing::copies_left = 0;
    CHECK_THROWS_AS(box.draft() = next, std::runtime_error);
  };

  write_badly();  // while a value waits for the reader
  CHECK(box.take() == 1);
  CHECK(box.value().value == 1);
  write_badly();  // while none does
  CHECK(box.take() == 0);
  CHECK(box.value().value == 1);
  CHECK(box.sequence() == 1);

  next.value = 2;
  Throwing::copies_left = 1;
  box.draft() = next;
  CHECK(box.publish() == 2);
  CHECK(box.take() == 1);
  CHECK(box.value().value == 2);
}

// Would catch threads that slow each other down by writing to one line of cache.
TEST_CASE("mailbox: slots share no cache lines, and lie as their values ask", "[unit]") {
  struct alignas(256) Wide {
    int value = 0;
  };
  Mailbox<Wide> wide;
  Mailbox<char> narrow;
  std::vector<std::uintptr_t> slots;
  for (int i = 0; i < 3; ++i) {
    CHECK(reinterpret_cast<std::uintptr_t>(&wide.draft()) % 256 == 0);
    wide.publish();
    slots.push_back(reinterpret_cast<std::uintptr_t>(&narrow.draft()));
    narrow.publish();
    narrow.take();
  }
  std::ranges::sort(slots);
  CHECK(slots[1] - slots[0] >= 128);
  CHECK(slots[2] - slots[1] >= 128);
}

// Would catch a slot that the writer fills while the reader reads it, or that the reader takes
// before it is filled, as with two slots, or exchanges that go backwards. Under thread sanitizer it
// would also catch an exchange without acquire or release, which this processor may make up for.
TEST_CASE("mailbox: two threads never see a torn, old or foreign value", "[property]") {
  using Words = std::array<std::uint64_t, kWords>;
  Mailbox<Words> box;
  std::uint64_t last = 0;  // of the writer; read after its end
  constexpr std::uint64_t kLeastPublished = 20000, kLeastTaken = 5000;
  std::jthread writer([&](const std::stop_token& stop) {
    while (last < kLeastPublished || !stop.stop_requested()) {
      Words& draft = box.draft();
      for (std::size_t i = 0; i < kWords; ++i) {
        draft[i] = word_of(last + 1, i);
      }
      last = box.publish();
    }
  });

  std::uint64_t before = 0, torn = 0, changed = 0, misordered = 0, miscounted = 0, newer = 0;
  const auto look = [&] {
    const std::uint64_t count = box.take();
    const std::uint64_t sequence = box.sequence();
    misordered += count > 0 && sequence <= before ? 1 : 0;
    miscounted += sequence - before != count ? 1 : 0;
    newer += count > 0 ? 1 : 0;
    before = sequence;
    if (sequence > 0) {
      torn += is_whole(box.value(), sequence) ? 0 : 1;
      std::this_thread::yield();  // the writer goes on
      changed += is_whole(box.value(), sequence) && box.sequence() == sequence ? 0 : 1;
    }
  };
  while (newer < kLeastTaken && torn + changed + misordered + miscounted == 0) {
    look();
  }
  writer.request_stop();
  writer.join();
  look();
  CHECK(box.sequence() == last);
  CHECK(box.take() == 0);
  CHECK(last >= kLeastPublished);
  CHECK(torn == 0);
  CHECK(changed == 0);
  CHECK(misordered == 0);
  CHECK(miscounted == 0);
}

// Would catch a slot that the reader has not let go of, but whose buffer the writer makes larger:
// the reader would read memory that was given back.
TEST_CASE("mailbox: two threads hand over buffers that grow", "[property]") {
  Mailbox<std::vector<std::uint64_t>> box;
  const auto size_of = [](std::uint64_t sequence) {
    return static_cast<std::size_t>(kWords + sequence % 1000);
  };
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t next = 1; !stop.stop_requested(); ++next) {
      std::vector<std::uint64_t>& draft = box.draft();
      draft = std::vector<std::uint64_t>(size_of(next));  // other memory each time
      for (std::size_t i = 0; i < kWords; ++i) {
        draft[i] = word_of(next, i);
      }
      box.publish();
    }
  });

  std::uint64_t torn = 0;
  for (int newer = 0; newer < 1000 && torn == 0;) {
    if (box.take() > 0) {
      ++newer;
      const bool is_good =
          box.value().size() == size_of(box.sequence()) && is_whole(box.value(), box.sequence());
      torn += is_good ? 0 : 1;
    }
  }
  CHECK(torn == 0);
}

}  // namespace pbdsurg
