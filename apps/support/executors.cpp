// SPDX-License-Identifier: Apache-2.0
#include "apps/support/executors.h"

#include <charconv>
#include <optional>
#include <string_view>

#include "pbdsurg/base/error.h"

namespace pbdsurg::programs {
namespace {

// Of "NAME" or "NAME:NUMBER"; none where the text is neither.
std::optional<int> number_after(std::string_view name, std::string_view text, int otherwise) {
  if (!text.starts_with(name)) {
    return std::nullopt;
  }
  text.remove_prefix(name.size());
  if (text.empty()) {
    return otherwise;
  }
  int number = 0;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), number);
  const bool is_number = text.front() == ':' && text.size() > 1 && error == std::errc() &&
                         end == text.data() + text.size() && number >= 0;
  return is_number ? std::optional(number) : std::nullopt;
}

}  // namespace

Executor executor_named(const std::string& name) {
  if (name == "best") {
    return best();
  }
  if (name == "serial") {
    return executor::serial();
  }
  if (const std::optional<int> count = number_after("threads", name, 0)) {
    return executor::threads(*count);
  }
  if (const std::optional<int> ordinal = number_after("cuda", name, 0)) {
    return device(*ordinal);
  }
  throw InvalidArgument("there is no executor '" + name +
                        "'; there are best, serial, threads, threads:N, cuda and cuda:N");
}

}  // namespace pbdsurg::programs
