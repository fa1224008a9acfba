// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tables for people and for programs. Every form is made of the same JSON rows: one object a row,
/// all with the same keys; null is what does not apply or was not measured.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace pbdsurg::bench {

using Json = nlohmann::ordered_json;

/// A column of a Markdown table.
struct Column {
  const char* key;
  const char* title;
  int digits;  ///< after the point, of numbers that are not whole
};

/// Enough digits to compare, and no more than what repeats.
/// @param steps  in 1
[[nodiscard]] Json rounded(std::optional<double> value, double steps);

/// Strings without quotes; null is empty.
[[nodiscard]] std::string text_of(const Json& value);

/// The two lines above the rows of a Markdown table.
[[nodiscard]] std::string markdown_header(const std::string& first_title,
                                          const std::vector<Column>& columns);

/// One row of it.
[[nodiscard]] std::string markdown_line(const std::string& label, const Json& row,
                                        const std::vector<Column>& columns);

/// A line of keys, then one a row; null is empty. Text with a comma is quoted. An object has a
/// column for each of its members, KEY.MEMBER; those of the first row count.
[[nodiscard]] std::string to_csv(const Json& rows);

/// Puts rows under a key of a JSON file, which keeps its other keys.
/// @throws FileError  if the file is there and is no JSON object, or cannot be written
void merge_into_json(const std::filesystem::path& path, const std::string& key, const Json& rows);

/// Writes a table as NAME.md and NAME.csv, and puts it under its name into tables.json.
/// @throws FileError  as those below and above
void write_table(const std::filesystem::path& folder, const std::string& name, const Json& rows,
                 const std::string& markdown);

/// @throws FileError  if the file cannot be written
void write_text(const std::filesystem::path& path, const std::string& text);

}  // namespace pbdsurg::bench
