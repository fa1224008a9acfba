// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Findings of a check, as sentences.

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/check.h"

namespace pbdsurg {

/// Elements by the ids of their points.
[[nodiscard]] std::string in_words(Index id);
[[nodiscard]] std::string in_words(const Edge& edge);
[[nodiscard]] std::string in_words(const Triangle& t);
[[nodiscard]] std::string in_words(const std::pair<Triangle, Triangle>& pair);
[[nodiscard]] std::string in_words(const std::pair<Index, Index>& pair);

void add_finding(MeshReport& report, Severity severity, std::string text);

/// "<text>: 7 (4, 9, 12, 13, 20, ...)": how many, and the first few.
template <class Element>
void add_finding(MeshReport& report, Severity severity, const std::string& text,
                 const std::vector<Element>& elements) {
  constexpr std::size_t kShown = 5;
  if (elements.empty()) {
    return;
  }
  std::string list;
  for (std::size_t i = 0; i < std::min(kShown, elements.size()); ++i) {
    list += (i == 0 ? "" : ", ") + in_words(elements[i]);
  }
  add_finding(report, severity,
              text + ": " + std::to_string(elements.size()) + " (" + list +
                  (elements.size() > kShown ? ", ...)" : ")"));
}

}  // namespace pbdsurg
