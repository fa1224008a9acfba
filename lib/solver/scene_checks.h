// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What parts of a scene must fulfil, whenever they come.

#include <span>
#include <string>

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/scene.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the Neo-Hookean body in fraction mode
void check_materials(std::span<const Body> bodies, ProjectionMode mode);

/// @param what  the link's name
/// @throws InvalidArgument  see Scene::add_link()
void check_link(const std::string& what, const Link& link, Index vertex_count);

}  // namespace pbdsurg
