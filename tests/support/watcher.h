// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A follower that counts what it follows, and refuses what it is told to.

#include <functional>
#include <stdexcept>

#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

struct Watcher final : Follower {
  void validate(const Tissue&, const TopologyEdit& edit) const override {
    if (refuses && refuses(edit)) {
      throw std::runtime_error("not now");
    }
  }
  void follow(const Tissue&, const TissueChange& change) noexcept override {
    ++follows;
    last = change;
  }
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

  std::function<bool(const TopologyEdit&)> refuses;
  int follows = 0;
  TissueChange last;
};

}  // namespace pbdsurg::testing
