// SPDX-License-Identifier: Apache-2.0
#include "bench/support/table_files.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include "pbdsurg/base/error.h"

namespace pbdsurg::bench {
namespace {

std::string cell_of(const Json& value, int digits) {
  if (!value.is_number_float()) {
    return value.is_null() ? "-" : text_of(value);
  }
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, value.get<double>());
  return text;
}

// Objects give way to their members, as KEY.MEMBER.
void add_members(const Json& row, const std::string& prefix, Json& members) {
  for (const auto& item : row.items()) {
    if (item.value().is_object()) {
      add_members(item.value(), prefix + item.key() + ".", members);
    } else {
      members[prefix + item.key()] = item.value();
    }
  }
}

Json members_of(const Json& row) {
  Json members = Json::object();
  add_members(row, "", members);
  return members;
}

std::string csv_field(const Json& value) {
  const std::string text = text_of(value);
  return text.find(',') == std::string::npos ? text : '"' + text + '"';
}

}  // namespace

Json rounded(std::optional<double> value, double steps) {
  return value ? Json(std::round(*value * steps) / steps) : Json();
}

std::string text_of(const Json& value) {
  return value.is_null() ? "" : value.is_string() ? value.get<std::string>() : value.dump();
}

std::string markdown_header(const std::string& first_title, const std::vector<Column>& columns) {
  std::string titles = "| " + first_title + " |";
  std::string rule = "|---|";
  for (const Column& column : columns) {
    titles += std::string(" ") + column.title + " |";
    rule += "---|";
  }
  return titles + "\n" + rule + "\n";
}

std::string markdown_line(const std::string& label, const Json& row,
                          const std::vector<Column>& columns) {
  std::string line = "| " + label + " |";
  for (const Column& column : columns) {
    line += " " + cell_of(row[column.key], column.digits) + " |";
  }
  return line + "\n";
}

std::string to_csv(const Json& rows) {
  std::string text;
  const Json first = members_of(rows.at(0));
  const auto add_line = [&](auto&& field_of) {
    std::string separator;
    for (const auto& item : first.items()) {
      text += separator + field_of(item.key());
      separator = ",";
    }
    text += "\n";
  };
  add_line([](const std::string& key) { return key; });
  for (const Json& row : rows) {
    const Json members = members_of(row);
    add_line([&](const std::string& key) { return csv_field(members.value(key, Json())); });
  }
  return text;
}

void merge_into_json(const std::filesystem::path& path, const std::string& key, const Json& rows) {
  Json tables = Json::object();
  if (std::ifstream file(path); file) {
    tables = Json::parse(file, nullptr, false);
    if (!tables.is_object()) {
      throw FileError(path.string() + ": is no JSON object, so no table can be added to it");
    }
  }
  tables[key] = rows;
  write_text(path, tables.dump(2) + "\n");
}

void write_table(const std::filesystem::path& folder, const std::string& name, const Json& rows,
                 const std::string& markdown) {
  write_text(folder / (name + ".md"), markdown);
  write_text(folder / (name + ".csv"), to_csv(rows));
  merge_into_json(folder / "tables.json", name, rows);
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) {
    throw FileError(path.string() + ": cannot be written");
  }
}

}  // namespace pbdsurg::bench
