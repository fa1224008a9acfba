// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A follower that refuses every edit for as long as it is told to.

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

struct RefusingFollower final : Follower {
  void validate(const Tissue&, const TopologyEdit& edit) const override {
    if (refuses) {
      refused = edit;
      throw InvalidArgument("refused");
    }
  }
  void follow(const Tissue&, const TissueChange&) noexcept override {}
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

  bool refuses = true;
  mutable TopologyEdit refused{};
};

}  // namespace pbdsurg::testing
