// SPDX-License-Identifier: Apache-2.0
#include "tests/support/lock_count.h"

#include <dlfcn.h>
#include <pthread.h>

namespace pbdsurg::testing {

std::atomic<long> lock_count{0};
std::atomic<const void*> last_locked_mutex{nullptr};
std::atomic<const void*> mutex_that_is_left_out{nullptr};

}  // namespace pbdsurg::testing

// That of the program comes before that of the system.
extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Lock = int (*)(pthread_mutex_t*);
  static const auto lock = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  pbdsurg::testing::last_locked_mutex = mutex;
  pbdsurg::testing::lock_count += mutex == pbdsurg::testing::mutex_that_is_left_out ? 0 : 1;
  return lock(mutex);
}
