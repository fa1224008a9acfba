// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What other programs reach in a scenario of ours: measured elsewhere, kept in peers.json.

#include <string>

#include "bench/support/table_files.h"

namespace pbdsurg::bench {

struct Peers {
  std::string
      notes;  ///< lines of a Markdown list: where rows are from, and what they count as error
  Json rows;  ///< with the keys of ours
};

/// Those that stand beside rows of ours, of the same scenario and step.
/// @param ours  at least one row
/// @throws FileError  if peers.json cannot be read
[[nodiscard]] Peers peers_beside(const Json& ours);

}  // namespace pbdsurg::bench
