// SPDX-License-Identifier: Apache-2.0
#include "coloring/thread_team.h"

#include <algorithm>
#include <string>

#include "pbdsurg/core/error.h"

#include "core/processors.h"

namespace pbdsurg {

int resolve_threads(int threads) {
  if (threads < 0) {
    throw InvalidArgument("threads is " + std::to_string(threads) +
                          "; it must be >= 1, or 0 for one a processor");
  }
  const int processors = processor_count();
  // no use for many more, and a slip of the finger should not start a million
  return threads == 0 ? processors : std::min(threads, 8 * processors);
}

}  // namespace pbdsurg
