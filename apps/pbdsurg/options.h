// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Options of subcommands that say what they allow when they refuse a value.

#include <charconv>
#include <cmath>
#include <limits>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace pbdsurg {

/// Adds an option that takes one of several words.
/// @param value   must outlive the parsing
/// @param advice  ends the refusal of any other word
template <class T>
CLI::Option* add_choice(CLI::App& command, const std::string& name, T& value,
                        const std::vector<std::pair<std::string, T>>& choices,
                        const std::string& help, const std::string& advice = "") {
  std::string words;
  for (const auto& choice : choices) {
    words += (words.empty() ? "" : "|") + choice.first;
  }
  const auto choose = [name, &value, choices, words, advice](const std::string& text) {
    for (const auto& [word, meaning] : choices) {
      if (text == word) {
        value = meaning;
        return;
      }
    }
    throw CLI::ValidationError(name, "'" + text + "' is none of " + words + advice);
  };
  return command.add_option_function<std::string>(name, choose, help)->type_name(words);
}

/// Adds an option that takes a whole number of a type's range from `least` on. Digits alone count:
/// nothing is wrapped, clamped or read as octal.
/// @param value  must outlive the parsing
template <class T>
CLI::Option* add_whole_number(CLI::App& command, const std::string& name, T& value, T least,
                              const std::string& help) {
  const auto read = [name, &value, least](const std::string& text) {
    T number{};
    const char* text_end = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), text_end, number);
    if (error != std::errc() || end != text_end || number < least) {
      throw CLI::ValidationError(name, "'" + text + "' is no whole number from " +
                                           std::to_string(least) + " to " +
                                           std::to_string(std::numeric_limits<T>::max()));
    }
    value = number;
  };
  return command.add_option_function<std::string>(name, read, help)->type_name("N");
}

/// Adds an option that takes a number which follows a rule. Text is refused, and so is nan.
/// @param value  must outlive the parsing
/// @param rule   as in "number from 1 to 2"
/// @param holds  whether a number follows it; false for nan
inline CLI::Option* add_number(CLI::App& command, const std::string& name, double& value,
                               const std::string& rule, bool (*holds)(double),
                               const std::string& help) {
  const auto read = [name, &value, rule, holds](const std::string& text) {
    double number = 0;
    const char* text_end = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), text_end, number);
    if (error != std::errc() || end != text_end || !holds(number)) {
      throw CLI::ValidationError(name, "'" + text + "' is no " + rule);
    }
    value = number;
  };
  return command.add_option_function<std::string>(name, read, help)->type_name("X");
}

/// Adds an option that takes a positive, finite number.
/// @param value  must outlive the parsing
inline CLI::Option* add_positive_number(CLI::App& command, const std::string& name, double& value,
                                        const std::string& help) {
  return add_number(
      command, name, value, "positive, finite number",
      [](double number) { return number > 0 && std::isfinite(number); }, help);
}

}  // namespace pbdsurg
