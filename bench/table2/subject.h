// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What table 2 steps.

#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/solver/scene.h"

namespace pbdsurg::bench {

/// A scene at rest and where it stands in the table.
struct Subject {
  std::optional<int> row;  ///< of the paper's table
  std::string kind;        ///< "hollow", "surface_filled" or "scene"
  Scene scene;
};

/// Rows kind by kind: those of the table, then the paper's largest scene; or, to see it work, the
/// smallest row alone.
/// @param notes  gets a line for each kind that cannot be made here
[[nodiscard]] std::vector<Subject> make_subjects(bool quick, std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
