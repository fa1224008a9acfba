// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What colourings ask of a device.

#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/color.h"

namespace pbdsurg {

class PBDSURG_API ColoringDevice {
 public:
  virtual ~ColoringDevice() = default;

  /// As color_constraints(), with the same result.
  /// @param options  that are not sequential by nature
  [[nodiscard]] virtual Coloring color(const ConstraintVertices& constraints,
                                       const ColoringOptions& options) = 0;
};

}  // namespace pbdsurg
