// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a mesh would be if points that lie at one place were one point.

#include <cstddef>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// The point that stands for each point once repeated ones are joined with earlier ones.
class Welding {
 public:
  explicit Welding(std::size_t point_count) : stands_for_(point_count) {
    std::iota(stands_for_.begin(), stands_for_.end(), 0);
  }

  /// @param repeated  as of RepeatedPoints: (point, the one to join it with)
  void join(std::span<const std::pair<Index, Index>> repeated) {
    for (const auto& [point, earlier] : repeated) {
      stands_for_[point] = earlier;
    }
  }

  [[nodiscard]] Index operator()(Index point) const {
    while (stands_for_[point] != point) {
      point = stands_for_[point];
    }
    return point;
  }

  /// The same elements of the points that stand for theirs.
  template <class Element>
  [[nodiscard]] std::vector<Element> operator()(const std::vector<Element>& elements) const {
    std::vector<Element> welded = elements;
    for (Element& element : welded) {
      for (Index& v : element) {
        v = (*this)(v);
      }
    }
    return welded;
  }

 private:
  std::vector<Index> stands_for_;
};

}  // namespace pbdsurg
