// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What parts of a scene must fulfil, whenever they come.

#include <string>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg {

/// @param what  the link's name
/// @throws InvalidArgument  see Scene::add_link()
void check_link(const std::string& what, const Link& link, Index vertex_count);

}  // namespace pbdsurg
