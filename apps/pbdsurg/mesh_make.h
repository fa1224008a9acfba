// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The subcommand that makes meshes of tetrahedra.

namespace CLI {
class App;
}

namespace pbdsurg {

/// mesh make WHAT OUT: a built-in organ, a row of table 2, or a surface file filled with
/// tetrahedra.
void add_mesh_make(CLI::App& mesh);

}  // namespace pbdsurg
