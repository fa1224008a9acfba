// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// report.json: everything that a run counted.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "procedure.h"

namespace cholecystectomy {

/// Writes the report. But for `stages_ms` it depends on the input and the seed alone.
/// @param organ_notes  where organs came from, a line each
/// @throws pbdsurg::FileError  if it cannot be written
void write_report(const std::filesystem::path& path, const Simulation& simulation,
                  const Recovery& recovery, std::uint64_t seed,
                  const std::vector<std::string>& organ_notes);

}  // namespace cholecystectomy
