// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Table 1 for people and for programs, beside the paper's figures. Every form is made of the same
/// JSON rows.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "measure.h"

namespace pbdsurg::bench {

/// One object a row, all with the same keys; null is what does not apply or was not measured. The
/// paper's rows come last.
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<Row>& rows);

/// A line of keys, then one a row; null is empty.
[[nodiscard]] std::string to_csv(const nlohmann::ordered_json& rows);

/// A table for each mesh and type of constraint, after one line for each note.
[[nodiscard]] std::string to_markdown(const nlohmann::ordered_json& rows,
                                      const std::vector<std::string>& notes);

/// Puts rows under a key of a JSON file, which keeps its other keys.
/// @throws FileError  if the file is there and is no JSON object, or cannot be written
void merge_into_json(const std::filesystem::path& path, const std::string& key,
                     const nlohmann::ordered_json& rows);

/// @throws FileError  if the file cannot be written
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace pbdsurg::bench
