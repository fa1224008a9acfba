// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Elements that use a vertex twice, or the vertices of others.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

template <class Element>
bool repeats_vertex(const Element& element) {
  for (std::size_t i = 0; i < element.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (element[i] == element[j]) {
        return true;
      }
    }
  }
  return false;
}

/// (element, earlier element with the same vertices)
template <class Element>
std::vector<std::pair<Index, Index>> find_repeated(const std::vector<Element>& elements) {
  std::vector<std::pair<Element, Index>> keys;
  keys.reserve(elements.size());
  for (std::size_t e = 0; e < elements.size(); ++e) {
    keys.emplace_back(elements[e], static_cast<Index>(e));
    std::sort(keys.back().first.begin(), keys.back().first.end());
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::pair<Index, Index>> repeated;
  std::size_t first = 0;
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].first == keys[first].first) {
      repeated.emplace_back(keys[i].second, keys[first].second);
    } else {
      first = i;
    }
  }
  std::sort(repeated.begin(), repeated.end());
  return repeated;
}

}  // namespace pbdsurg
