// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Times of steps as columns of a table.

#include <optional>
#include <string>
#include <vector>

#include "bench/support/cpu_times.h"
#include "bench/support/gpu_times.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// `NAME_ms` and `NAME_p99_ms`; null if it was not measured.
void add_times(Json& row, const std::string& name, const std::optional<StepStatistics>& times);

/// Keys that begin with `gpu_` and `rate_`, and ratios; null where there is no device.
/// @param cpu  of the same scene
void add_gpu_columns(Json& row, const std::optional<GpuTimes>& gpu, const CpuTimes& cpu);

/// The ones to print of these.
[[nodiscard]] const std::vector<Column>& gpu_columns();

/// What they mean, a line each.
extern const char* const kGpuLegend;

}  // namespace pbdsurg::bench
