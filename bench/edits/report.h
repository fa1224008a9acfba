// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The table of edits, and whether what was aimed at is met.

#include <string>
#include <vector>

#include "bench/edits/measure.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// One mesh on one backend.
struct Measured {
  std::string mesh;     ///< "hollow 2"
  std::string backend;  ///< "threaded" or "cuda"
  std::string method;   ///< "paper" or "vertex blocks"
  Index tets;
  EditRun run;
};

[[nodiscard]] Json to_json(const std::vector<Measured>& all);

/// Whether what was aimed at is met, a line each.
[[nodiscard]] std::vector<std::string> verdicts(const std::vector<Measured>& all);

/// The table, after one line for each note.
[[nodiscard]] std::string to_markdown(const Json& rows, const std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
