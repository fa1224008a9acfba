// SPDX-License-Identifier: Apache-2.0
#include "bench/sizes/memory.h"

#include <fstream>

#include <malloc.h>
#include <unistd.h>

#include "pbdsurg/base/error.h"

namespace pbdsurg::bench {

std::int64_t heap_bytes() {
  const struct mallinfo2 now = mallinfo2();
  return static_cast<std::int64_t>(now.uordblks + now.hblkhd);
}

std::int64_t resident_bytes() {
  malloc_trim(0);
  std::int64_t total_pages = 0, resident_pages = 0;
  std::ifstream file("/proc/self/statm");
  if (!(file >> total_pages >> resident_pages)) {
    throw FileError("/proc/self/statm: cannot be read");
  }
  return resident_pages * sysconf(_SC_PAGESIZE);
}

}  // namespace pbdsurg::bench
