// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Several pictures as one.

#include <span>
#include <string>

#include "apps/viewer/image.h"

namespace cholecystectomy {

struct CaptionedImage {
  std::string caption;  ///< printable ASCII
  Image image;
};

/// Pictures row by row from the top left, each above its caption, on white.
/// @throws pbdsurg::InvalidArgument  if there is none, they differ in size, or columns < 1
[[nodiscard]] Image make_montage(std::span<const CaptionedImage> pictures, int columns);

}  // namespace cholecystectomy
