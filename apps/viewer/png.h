// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Writes pictures.

#include <filesystem>

#include "apps/viewer/image.h"

namespace cholecystectomy {

/// Writes a PNG file. It appears whole or not at all: written beside its place, then renamed.
/// @throws pbdsurg::FileError  if it cannot be written
/// @throws pbdsurg::InvalidArgument  if the image is empty or its array does not fit its size
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace cholecystectomy
