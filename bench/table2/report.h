// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Table 2 beside the paper's figures.

#include <optional>
#include <string>
#include <vector>

#include "bench/support/cpu_times.h"
#include "bench/support/gpu_times.h"
#include "bench/support/subject.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// One subject under one plan of the CPU's backends.
struct Row {
  const Subject* subject;
  CpuTimes cpu;
  std::optional<GpuTimes> gpu;  ///< under the plan that is fastest there
};

[[nodiscard]] Json to_json(const std::vector<Row>& rows);

/// Tables for each kind, after one line for each note.
[[nodiscard]] std::string to_markdown(const Json& rows, const std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
