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

/// @param what  the tetrahedron's or triangle's name
/// @throws InvalidArgument  see Scene::set_stiffnesses()
void check_stiffness_factor(const std::string& what, float factor);

/// @param what  the tetrahedron's name
/// @throws InvalidArgument  see Scene::set_fibres()
void check_fibre(const std::string& what, const Fibre& fibre);

/// @param what  whose fibres these are to be
/// @throws InvalidArgument  naming the body that is not Neo-Hookean
void check_takes_fibres(const std::string& what, const Body& body);

/// @param what  what is to be scaled
/// @throws InvalidArgument  naming the body that is not Neo-Hookean
void check_has_moduli(const std::string& what, const Body& body);

}  // namespace pbdsurg
