// SPDX-License-Identifier: Apache-2.0
#include "lib/haptics/hotplug_device.h"

#include <atomic>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/haptics/open_device.h"
#include "tests/support/catch.h"
#include "tests/support/eventually.h"
#include "tests/support/pedal_pipe.h"

namespace pbdsurg {
namespace {

using testing::eventually;

std::atomic<int> attempts = 0;
std::atomic<bool> is_slow = false;

// Takes as long as the test wants.
FileDescriptor open_pipe(const std::filesystem::path& path) {
  ++attempts;
  static_cast<void>(eventually([] { return !is_slow; }));
  return open_device(path, {"", ""});
}

// A pipe with a device that reads it.
class PipeBench {
 public:
  PipeBench() { attempts = 0; }

  long read() {
    char bytes[64];
    return device.read(bytes, sizeof(bytes));
  }

  testing::PedalPipe pipe;
  HotplugDevice device{pipe.path, open_pipe};
};

// The number that the next file will have.
int lowest_free() {
  const FileDescriptor file(open("/dev/null", O_RDONLY | O_CLOEXEC));
  REQUIRE(file.is_open());
  return file.number();
}

}  // namespace

// Would catch a device that is not opened again, a caller that waits until it is, and a dead file
// that is kept: the device would come back under another name.
TEST_CASE("hotplug device: one that was gone is opened by another thread", "[unit]") {
  PipeBench bench;
  CHECK(bench.device.is_there());
  CHECK(bench.read() < 0);
  const int free_before = lowest_free();
  bench.pipe.unplug();
  CHECK(bench.read() == 0);
  CHECK_FALSE(bench.device.is_there());
  CHECK(bench.read() == 0);

  bench.pipe.plug_in();
  is_slow = true;
  bench.device.look(0);
  REQUIRE(eventually([] { return attempts == 1; }));
  CHECK(lowest_free() < free_before);
  bench.device.look(100);
  CHECK_FALSE(bench.device.is_there());
  CHECK(bench.read() == 0);
  is_slow = false;
  CHECK(eventually([&] {
    bench.device.look(100);
    return bench.device.is_there();
  }));
  CHECK(bench.read() < 0);
  bench.pipe.bytes("x", 1);
  CHECK(bench.read() == 1);
  CHECK(attempts == 1);
}

// Would catch a thread that tries all the time, and one that gives up.
TEST_CASE("hotplug device: it is tried once a second until it is there", "[unit]") {
  PipeBench bench;
  bench.pipe.unplug();
  REQUIRE(bench.read() == 0);
  REQUIRE(std::filesystem::remove(bench.pipe.path));
  for (int second = 0; second < 5; ++second) {
    CHECK(eventually([&] {
      bench.device.look(second);
      return attempts == second + 1;
    }));
    for (int look = 0; look < 20; ++look) {
      bench.device.look(second + 0.99);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(attempts == second + 1);
    CHECK_FALSE(bench.device.is_there());
  }
}

// Would catch an end that forgets the thread, or a file that stays open.
TEST_CASE("hotplug device: it may end in the middle of an attempt", "[unit]") {
  const int free_before = lowest_free();
  for (int round = 0; round < 50; ++round) {
    PipeBench bench;
    bench.pipe.unplug();
    REQUIRE(bench.read() == 0);
    bench.pipe.plug_in();
    bench.device.look(0);
  }
  CHECK(lowest_free() == free_before);
}

}  // namespace pbdsurg
