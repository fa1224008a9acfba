// SPDX-License-Identifier: Apache-2.0
#include "edit/renumbering.h"

#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {

void check_map_size(const char* who, const char* what, const std::vector<Index>& ids,
                    std::size_t count) {
  if (ids.size() != count) {
    throw InvalidArgument(std::string(who) + " has " + std::to_string(count) + " " + what +
                          ", the compaction was of a solver with " + std::to_string(ids.size()));
  }
}

}  // namespace pbdsurg
