// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the subcommands on mesh files share.

#include <span>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pbdsurg/mesh/check.h"
#include "pbdsurg/mesh/read.h"

#include "apps/pbdsurg/unit_options.h"

namespace pbdsurg {

struct NamedMesh {
  std::string path;
  MeshFile file;
};

/// Reads a mesh whose unit, if it is to be guessed, is left to settle_unit().
[[nodiscard]] NamedMesh read_named_mesh(const std::string& path, const UnitOptions& options);

/// Guesses the unit that files of one run share, where it is to be guessed, and says on stderr what
/// they were taken for. Files that state their unit keep it.
/// @throws InvalidArgument  naming all readings, if more than one unit is plausible, or none
void settle_unit(std::span<NamedMesh> meshes, const UnitOptions& options);

/// Reads one mesh and settles its unit.
[[nodiscard]] MeshFile read_with_unit(const std::string& path, const UnitOptions& options);

/// Why the size is not that of an organ, and what unit would make it one; empty if it is. Not a
/// finding of check_mesh(): that knows no unit, and judges a mesh alike at every scale.
[[nodiscard]] std::string size_remark(const MeshFile& file);

/// @throws InvalidArgument  if a file to be written is the mesh that is read
void check_is_not_input(const std::string& input, const std::string& output);

/// Says on stderr what the format of a file that was written left out of a mesh.
void print_losses(const std::string& path, const MeshData& mesh);

/// The report with the keys that scripts rely on, in a fixed order.
[[nodiscard]] nlohmann::ordered_json to_json(const MeshFile& file, const MeshReport& report);

/// The report for people: one line a quantity.
[[nodiscard]] std::string to_text(const std::string& path, const MeshFile& file,
                                  const MeshReport& report);

}  // namespace pbdsurg
