// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Table 1 beside the paper's figures.

#include <string>
#include <vector>

#include "bench/support/table_files.h"
#include "bench/table1/measure.h"

namespace pbdsurg::bench {

/// The paper's rows come last.
[[nodiscard]] Json to_json(const std::vector<Row>& rows);

/// The sizes of all colours, one a row; joint constraints have those of the tetrahedra.
[[nodiscard]] Json colors_of(const std::vector<Row>& rows);

/// A table for each mesh and type of constraint, after one line for each note.
[[nodiscard]] std::string to_markdown(const Json& rows, const std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
