// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How heat has changed the colour of the organs.

#include <Eigen/Core>
#include <vector>

#include "apps/cholecystectomy/simulation.h"

namespace cholecystectomy {

/// A layer over each vertex of the tissue, by the colour rule of the thermal model: sRGB and cover.
/// Strands that heat has parted were boiled dry; their stumps cover part of the surface that they
/// hung on. [vertex_count of the tissue] zero where nothing burns
[[nodiscard]] std::vector<Eigen::Vector4f> burn_layers(const Simulation& simulation);

}  // namespace cholecystectomy
