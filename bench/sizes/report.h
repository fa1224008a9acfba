// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sizes as tables.

#include <string>
#include <vector>

#include "bench/sizes/measure.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// @param executor  its name
[[nodiscard]] Json to_json(const std::string& executor, const SizeTimes& times);

/// @param notes  a line each
[[nodiscard]] std::string to_markdown(const Json& rows, const std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
